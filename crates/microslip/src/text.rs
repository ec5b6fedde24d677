//! Text for terminals: what files hold may be in it, control characters and lines of megabytes included.

use anyhow::Result;
use host::with_causes;
use serde::Serialize;
use std::io::Write;

/// Prints a finished text; a reader that has gone away (as `head` does) is no error.
///
/// # Errors
/// Standard output cannot be written.
pub fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(visible(text).as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

/// An error with its causes in one line, for a terminal.
pub(crate) fn of_error(error: &anyhow::Error) -> String {
    short(&visible(&with_causes(error.as_ref())))
}

/// A line of JSON. JSON itself asks for escapes of some control characters, terminals need them of all.
///
/// # Errors
/// A value that JSON has no form for.
pub(crate) fn json(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string(value)?;
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        match c.is_control() {
            true => line.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => line.push(c),
        }
    }
    Ok(line)
}

/// The text with its control characters escaped, but for the ends of lines and tabulators: a terminal shows them, and does not obey.
pub(crate) fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c.is_control() && !matches!(c, '\n' | '\t') {
            true => shown.extend(c.escape_debug()),
            false => shown.push(c),
        }
    }
    shown
}

/// The text with the middle left out of words and lines that nobody would read.
pub(crate) fn short(text: &str) -> String {
    let line = |line: &str| -> String {
        let words: Vec<String> = line.split(' ').map(|word| ends(word, 300, [60, 20])).collect();
        ends(&words.join(" "), 2000, [1500, 400])
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// The text, or its first and last characters if it has more than `most`.
fn ends(text: &str, most: usize, [first, last]: [usize; 2]) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.into();
    }
    let head: String = text.chars().take(first).collect();
    let tail: String = text.chars().skip(count - last).collect();
    format!("{head} ... ({count} characters) ... {tail}")
}

#[cfg(test)]
mod tests {
    use super::{json, of_error, short, visible};
    use anyhow::anyhow;

    #[test]
    fn causes_are_said_once() {
        let error = anyhow!("no such file")
            .context("a.json: no such file; check it")
            .context("the scene");
        assert_eq!(of_error(&error), "the scene: a.json: no such file; check it");
        assert_eq!(of_error(&anyhow!("b").context("a")), "a: b");
    }

    #[test]
    fn json_reads_back_and_commands_no_terminal() {
        let text = "a\u{1b}[2J\n\u{9b}\u{7f}\u{e9}";
        let line = json(&text).unwrap();
        assert!(!line.chars().any(char::is_control), "{line:?}");
        assert_eq!(serde_json::from_str::<String>(&line).unwrap(), text);
    }

    #[test]
    fn terminals_are_not_commanded_nor_flooded() {
        assert_eq!(visible("a\u{1b}[2J\r\n\tb\u{9b}"), "a\\u{1b}[2J\\r\n\tb\\u{9b}");
        let long = short(&format!("{} is no {}", "x".repeat(3_000_000), "unit ".repeat(10_000)));
        assert!(long.starts_with("xxx") && long.contains("3000000 characters"));
        assert!(long.chars().count() < 2100);
        let path = "/a/folder/of/a/usual/length/".repeat(8);
        assert_eq!(short(&path), path);
    }
}

//! Text in XML and HTML, and a check that a document is well formed.

/// Replaces the characters that XML gives a meaning.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            c => out.push(c),
        }
    }
    printable(&out)
}

/// Replaces the control characters that XML has no way to write.
pub fn printable(text: &str) -> String {
    text.replace(|c: char| c.is_control() && !c.is_whitespace(), "\u{fffd}")
}

/// Checks that tags are balanced, attributes quoted and special characters escaped.
///
/// # Errors
/// What is wrong, and in which line.
pub fn check(text: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut elements = 0_usize;
    let mut at = 0;
    let line = |at: usize| text[..at].matches('\n').count() + 1;
    let fail = |at: usize, what: String| Err(format!("line {}: {what}", line(at)));
    while let Some(offset) = text[at..].find('<') {
        let begin = at + offset;
        if let Some(place) = bare_ampersand(&text[at..begin]) {
            return fail(at + place, "`&` that begins no entity".into());
        }
        let rest = &text[begin..];
        let skip = [("<!--", "-->"), ("<?", "?>"), ("<!", ">")]
            .into_iter()
            .find(|(from, _)| rest.starts_with(from));
        if let Some((_, to)) = skip {
            match rest.find(to) {
                Some(end) => at = begin + end + to.len(),
                None => return fail(begin, format!("`{}` is not closed", &rest[..2])),
            }
            continue;
        }
        let Some(length) = tag_length(rest) else {
            return fail(begin, "a tag or a quoted value is not closed".into());
        };
        let tag = &rest[1..length - 1];
        let name = tag
            .trim_start_matches('/')
            .split([' ', '\n', '\t', '/'])
            .next()
            .unwrap_or_default();
        if name.is_empty() || !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return fail(begin, format!("`<{tag}>` has no name"));
        }
        if tag.starts_with('/') {
            match open.pop() {
                Some(last) if last == name => {}
                Some(last) => return fail(begin, format!("</{name}> closes <{last}>")),
                None => return fail(begin, format!("</{name}> closes nothing")),
            }
        } else {
            elements += 1;
            if let Some(place) = bare_ampersand(tag) {
                return fail(begin + place, "`&` that begins no entity".into());
            }
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
        at = begin + length;
        // Within scripts nothing is markup but their end.
        if tag.starts_with("script") && !tag.ends_with('/') {
            match text[at..].find("</script") {
                Some(end) => at += end,
                None => return fail(begin, "<script> is not closed".into()),
            }
        }
    }
    match open.pop() {
        Some(name) => fail(text.len(), format!("<{name}> is not closed")),
        None if elements == 0 => fail(text.len(), "no element".into()),
        None => Ok(()),
    }
}

/// Length of the tag that `text` begins with; `>` within quotes does not end it, `<` must not occur.
fn tag_length(text: &str) -> Option<usize> {
    let mut quote = None;
    for (i, c) in text.char_indices().skip(1) {
        match (quote, c) {
            (None, '"' | '\'') => quote = Some(c),
            (Some(q), c) if q == c => quote = None,
            (None, '>') => return Some(i + 1),
            (_, '<') => return None,
            _ => {}
        }
    }
    None
}

fn bare_ampersand(text: &str) -> Option<usize> {
    text.match_indices('&').map(|(i, _)| i).find(|&i| {
        let name = text[i + 1..].split(';').next().unwrap_or_default();
        let known = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '#');
        !(known && text[i + 1..].contains(';'))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_text_is_well_formed() {
        let text = escape("a < b & \"c\" > d\u{1}");
        assert_eq!(text, "a &lt; b &amp; &quot;c&quot; &gt; d\u{fffd}");
        assert_eq!(check(&format!("<p title=\"{text}\">{text}</p>")), Ok(()));
    }

    #[test]
    fn defects_are_found_where_they_are() {
        assert_eq!(
            check("<?xml version=\"1.0\"?><!-- <x> --><a><b c=\">\"/>\n</a>"),
            Ok(())
        );
        assert_eq!(check("<a><script>1 < 2 && \"</a>\"</script></a>"), Ok(()));
        for (text, line) in [
            ("<a>\n<script>\n</a>", 2),
            ("<a>\n<b></a></b>", 2),
            ("<a>\n\n", 3),
            ("</a>", 1),
            ("<a>\n5 < 6</a>", 2),
            ("<a>\n5 & 6</a>", 2),
            ("<a b=\"></a>", 1),
            ("<!-- <a></a>", 1),
            ("plain", 1),
        ] {
            let error = check(text).expect_err(text);
            assert!(error.starts_with(&format!("line {line}:")), "{text}: {error}");
        }
    }
}

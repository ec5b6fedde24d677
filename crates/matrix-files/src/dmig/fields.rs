//! Lines of bulk data in fields.

use crate::Error;
use crate::text::Line;
use file_io::quoted;

/// Characters of the first field of a line, and where the last but one ends: the last is a label of the continuation.
const FIRST: usize = 8;
const LABEL: usize = 72;
const END: usize = 80;

/// Puts the fields of a line between the first and the last into `fields`, eight or in large form four, and returns the
/// first: the name of an entry, nothing for its continuation. None for a line without contents.
pub(super) fn split<'a>(line: Line<'a>, fields: &mut Vec<&'a [u8]>) -> Result<Option<&'a [u8]>, Error> {
    fields.clear();
    let text = line
        .text
        .split(|b| *b == b'$')
        .next()
        .unwrap_or_default()
        .trim_ascii_end();
    if text.is_empty() {
        return Ok(None);
    }
    if text.contains(&b'\t') {
        return Err(line.malformed("a tabulator", "blanks or commas between fields"));
    }
    let is_free = text.contains(&b',');
    let first = match is_free {
        true => text.split(|b| *b == b',').next().unwrap_or_default(),
        false => &text[..text.len().min(FIRST)],
    };
    let rest = text.get(first.len() + usize::from(is_free)..).unwrap_or_default();
    let first = first.trim_ascii();
    let is_large = first.starts_with(b"*") || first.ends_with(b"*");
    let count = if is_large { 4 } else { 8 };
    if is_free {
        fields.extend(rest.split(|b| *b == b',').map(<[u8]>::trim_ascii));
        let labels = fields.get(count..).unwrap_or_default();
        if labels.len() > 1
            || labels
                .iter()
                .any(|l| !l.is_empty() && !l.starts_with(b"+") && !l.starts_with(b"*"))
        {
            return Err(line.malformed(quoted(text), format!("at most {count} fields after the first")));
        }
    } else {
        if text.len() > END {
            return Err(line.malformed(quoted(&text[END..]), format!("nothing beyond column {END}")));
        }
        let body = &rest[..rest.len().min(LABEL - FIRST)];
        fields.extend(body.chunks((LABEL - FIRST) / count).map(<[u8]>::trim_ascii));
    }
    fields.resize(count, b"");
    let is_continuation = first.starts_with(b"+") || first.starts_with(b"*");
    Ok(Some(match is_continuation {
        true => b"",
        false => first.strip_suffix(b"*").unwrap_or(first),
    }))
}

//! What a page consists of.

/// The tag of a script.
pub(crate) const SCRIPT: &str = "<script>";

/// The tag of the data.
pub(crate) const DATA: &str = "<script type=\"application/json\" id=\"data\">";

/// The page without what its scripts contain, and each script's tag and contents.
pub(crate) fn scripts_of(page: &str) -> (String, Vec<(&str, &str)>) {
    let mut markup = String::new();
    let mut scripts = Vec::new();
    let mut rest = page;
    while let Some(begin) = rest.find("<script") {
        let tag = begin + rest[begin..].find('>').unwrap() + 1;
        let end = tag + rest[tag..].find("</script>").unwrap();
        markup += &rest[..tag];
        scripts.push((&rest[begin..tag], &rest[tag..end]));
        rest = &rest[end..];
    }
    (markup + rest, scripts)
}

/// The data of a page as they stand in it.
pub(crate) fn data_of(page: &str) -> &str {
    let (_, scripts) = scripts_of(page);
    scripts.into_iter().find(|(tag, _)| *tag == DATA).unwrap().1
}

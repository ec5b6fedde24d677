//! Numbers in messages.

/// A number with five significant digits, without zeros at its end.
pub fn significant(value: f64) -> String {
    let text = format!("{value:.4e}");
    let rounded: f64 = text.parse().unwrap_or(value);
    match rounded.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e7).contains(&size) => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

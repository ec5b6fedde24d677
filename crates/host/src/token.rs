//! Words that nobody can guess.

use rand::TryRng;
use rand::rngs::SysRng;

/// A word of 32 hexadecimal digits from the random numbers of the system.
///
/// # Errors
/// The system has none.
pub fn token() -> std::io::Result<String> {
    let mut bytes = [0; 16];
    SysRng.try_fill_bytes(&mut bytes).map_err(std::io::Error::other)?;
    Ok(file_io::durable::hex(&bytes))
}

#[cfg(test)]
mod tests {
    use super::token;

    #[test]
    fn words_differ() {
        let [a, b] = [token().unwrap(), token().unwrap()];
        assert!(a != b && a.len() == 32 && a.bytes().all(|digit| digit.is_ascii_hexdigit()));
    }
}

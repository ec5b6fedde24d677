//! What a program for Linux needs of the system, read from its headers.

use anyhow::{Context, Result, ensure};
use std::fmt;

/// What a program needs beside the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Linkage {
    /// Nothing.
    Static,
    /// Libraries, with the oldest version of glibc that has all that is asked of it, if it is asked.
    Dynamic(Option<(u32, u32)>),
}

impl fmt::Display for Linkage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Static => write!(f, "static: it needs no library of the system"),
            Self::Dynamic(Some((major, minor))) => write!(f, "dynamic: it needs glibc {major}.{minor} or later"),
            Self::Dynamic(None) => write!(f, "dynamic: it needs libraries of the system"),
        }
    }
}

/// Reads a 64-bit little-endian ELF file.
///
/// # Errors
/// It is no such file, or shorter than its headers say.
pub fn linkage(file: &[u8]) -> Result<Linkage> {
    const INTERPRETER: u64 = 3;
    const DYNAMIC: u64 = 2;
    const NEEDED: u64 = 1;
    ensure!(
        file.starts_with(b"\x7fELF\x02\x01"),
        "this is no 64-bit little-endian ELF file"
    );
    let (table, size, count) = (number::<8>(file, 32)?, number::<2>(file, 54)?, number::<2>(file, 56)?);
    let mut is_static = true;
    for header in (0..count).map(|n| table.saturating_add(n * size)) {
        match number::<4>(file, header)? {
            INTERPRETER => is_static = false,
            DYNAMIC => {
                let (begin, bytes) = (number::<8>(file, header + 8)?, number::<8>(file, header + 32)?);
                for entry in (0..bytes / 16).map(|n| begin.saturating_add(16 * n)) {
                    match number::<8>(file, entry)? {
                        0 => break,
                        NEEDED => is_static = false,
                        _ => {}
                    }
                }
            }
            _ => {}
        }
    }
    Ok(match is_static {
        true => Linkage::Static,
        // The names of versions stand in the table of strings.
        false => Linkage::Dynamic(file.split(|byte| *byte == 0).filter_map(glibc).max()),
    })
}

fn glibc(name: &[u8]) -> Option<(u32, u32)> {
    let version = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?;
    let (major, minor) = version.split_once('.')?;
    Some((major.parse().ok()?, minor.split('.').next()?.parse().ok()?))
}

fn number<const N: usize>(file: &[u8], at: u64) -> Result<u64> {
    let bytes = usize::try_from(at).ok().and_then(|at| file.get(at..at.checked_add(N)?));
    let bytes = bytes.with_context(|| format!("the ELF file ends before byte {at}"))?;
    Ok(bytes.iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte)))
}

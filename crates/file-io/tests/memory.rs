//! A refusal takes no memory.

use file_io::input::{Kind, read};
use std::fs::File;
use test_support::TemporaryFolder;
use test_support::memory::{self, Counting};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn refusals_take_no_memory() -> std::io::Result<()> {
    let folder = TemporaryFolder::new("input-files-memory");
    let path = folder.join("zeros.npz");
    // Without blocks on the disk.
    File::create(&path)?.set_len(1 << 40)?;
    for path in [path, "/dev/zero".into()] {
        let (result, bytes) = memory::peak(|| read(&path, Kind::Matrices));
        assert!(result.is_err() && bytes < 10_000, "{}: {bytes}", path.display());
    }
    Ok(())
}

//! Folders of results: held by one process, replaced as a set.

use crate::durable::Error;
use crate::durable::lock::Lock;
use crate::durable::manifest::{COMPLETE, Identity, MANIFEST, Manifest};
use crate::durable::write::{create_folder, is_temporary, sync_folder, temporary};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Name of the manifest that a set replaces, while it does.
const SUPERSEDED: &str = "superseded.json";

/// A folder of results that no other process writes into.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    identity: Identity,
    overwrite: bool,
    /// What the folder held when it was opened.
    earlier: Option<Manifest>,
    lock: Lock,
}

impl Folder {
    /// Takes hold of a folder, made if missing, for a set of the given identity. A move of files that was interrupted is
    /// completed. With `overwrite` the set may replace one of another identity, and files that belong to no set.
    ///
    /// # Errors
    /// [`Error::Busy`], [`Error::OtherResults`], [`Error::DamagedManifest`], [`Error::File`].
    pub fn open(path: &Path, identity: &Identity, overwrite: bool) -> Result<Self, Error> {
        create_folder(path)?;
        let lock = Lock::acquire(path, &identity.to_string())?;
        if lock.is_held() {
            remove_staged(path);
        }
        match complete(path, &mut || Ok(())) {
            Err(Error::DamagedManifest { .. }) if overwrite => {
                let whole = path.join(COMPLETE);
                std::fs::remove_dir_all(&whole).map_err(|source| Error::file(&whole, "removing", source))?;
            }
            completed => completed?,
        }
        let earlier = match Manifest::read_file(&path.join(MANIFEST)) {
            Err(Error::DamagedManifest { .. }) if overwrite => None,
            read => read?,
        };
        match &earlier {
            Some(earlier) if earlier.identity != *identity && !overwrite => Err(Error::OtherResults {
                folder: path.to_owned(),
                there: earlier.identity.to_string(),
                wanted: identity.to_string(),
            }),
            _ => Ok(Self {
                path: path.to_owned(),
                identity: identity.clone(),
                overwrite,
                earlier,
                lock,
            }),
        }
    }

    /// Refuses to go on if one of these files is there and belongs to no set, so that it is known before the computation.
    ///
    /// # Errors
    /// [`Error::Unlisted`], [`Error::Obstructed`].
    pub fn expect<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<(), Error> {
        for name in names {
            let path = self.path.join(name);
            if path.is_dir() {
                return Err(Error::Obstructed { path });
            }
            let listed = self
                .earlier
                .as_ref()
                .is_some_and(|earlier| earlier.files.contains_key(name));
            if path.exists() && !listed && !self.overwrite {
                return Err(Error::Unlisted {
                    path,
                    wanted: self.identity.to_string(),
                });
            }
        }
        Ok(())
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether other processes are kept out; false on a file system without locks.
    pub fn is_locked(&self) -> bool {
        self.lock.is_held()
    }

    /// Replaces the set in the folder: at any moment the old set or the new one is whole. Files of the old set that the new
    /// one does not have are removed; other files are left alone.
    ///
    /// # Errors
    /// Those of [`Folder::expect`]; [`Error::File`]. Unless all files were written, the old set is as it was.
    pub fn publish(self, files: &[(&str, &[u8])]) -> Result<(), Error> {
        self.publish_in_steps(files, &mut || Ok(()))
    }

    /// As [`Folder::publish`]; `step` is called before every change of the file system.
    fn publish_in_steps(self, files: &[(&str, &[u8])], step: &mut dyn FnMut() -> io::Result<()>) -> Result<(), Error> {
        self.expect(
            files
                .iter()
                .map(|(name, _)| *name)
                .chain(self.earlier.is_none().then_some(MANIFEST)),
        )?;
        let folder = &self.path;
        let fail = |operation, path: &Path| {
            let path = path.to_owned();
            move |source| Error::file(&path, operation, source)
        };
        step().map_err(fail("staging", folder))?;
        let mut builder = temporary();
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        // Dropping it removes it.
        let staged = builder
            .tempdir_in(folder)
            .map_err(fail("making a temporary folder", folder))?;
        let manifest = Manifest::new(&self.identity, files).to_bytes();
        let mut write = |name: &str, contents: &[u8]| {
            let path = staged.path().join(name);
            step()
                .and_then(|()| File::create_new(&path))
                .and_then(|mut file| file.write_all(contents).and_then(|()| file.sync_all()))
                .map_err(fail("writing", &folder.join(name)))
        };
        files.iter().try_for_each(|(name, contents)| write(name, contents))?;
        write(MANIFEST, &manifest)?;
        sync_folder(staged.path())?;
        let whole = folder.join(COMPLETE);
        step()
            .and_then(|()| std::fs::rename(staged.path(), &whole))
            .map_err(fail("completing the set", &whole))?;
        // It has another name by now, under which it stays until its files are in place.
        let _ = staged.keep();
        sync_folder(folder)?;
        complete(folder, step)
    }
}

/// Moves the files of a complete set into place, if there is one; can be interrupted and called again at any point.
fn complete(folder: &Path, step: &mut dyn FnMut() -> io::Result<()>) -> Result<(), Error> {
    let whole = folder.join(COMPLETE);
    if !whole.is_dir() {
        return Ok(());
    }
    let mut rename = |from: &Path, to: &Path| {
        step()
            .and_then(|()| match std::fs::rename(from, to) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
                other => other,
            })
            .map_err(|source| Error::file(to, "moving into place", source))
    };
    let (new, old) = (whole.join(MANIFEST), whole.join(SUPERSEDED));
    if let Some(manifest) = Manifest::read_file(&new)? {
        if !old.exists() {
            rename(&folder.join(MANIFEST), &old)?;
            sync_folder(folder)?;
        }
        for name in manifest.files.keys() {
            rename(&whole.join(name), &folder.join(name))?;
        }
        // What a damaged manifest lists is not known, and stays.
        let superseded = Manifest::read_file(&old).ok().flatten();
        let stale = superseded.iter().flat_map(|old| old.files.keys());
        for name in stale.filter(|name| !manifest.files.contains_key(*name)) {
            let path = folder.join(name);
            match std::fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(Error::file(&path, "removing a file of the earlier results", error));
                }
                _ => {}
            }
        }
        sync_folder(folder)?;
        rename(&new, &folder.join(MANIFEST))?;
        sync_folder(folder)?;
    }
    step()
        .and_then(|()| std::fs::remove_dir_all(&whole))
        .map_err(|source| Error::file(&whole, "removing", source))
}

/// Removes what a killed process had staged. What cannot be removed is left for the next time.
fn remove_staged(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_temporary(&entry.file_name()) && entry.path().is_dir() {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_support::TemporaryFolder;

    const OLD: [(&str, &[u8]); 3] = [("a.csv", b"old a"), ("b.csv", b"old b"), ("summary.json", b"old")];
    const NEW: [(&str, &[u8]); 3] = [("a.csv", b"new a"), ("c.csv", b"new c"), ("summary.json", b"new")];

    fn identity() -> Identity {
        Identity::new("run", "scene")
    }

    fn open(path: &Path) -> Folder {
        Folder::open(path, &identity(), false).unwrap()
    }

    /// Whether exactly these files are in the folder, with what they hold.
    fn holds(path: &Path, files: &[(&str, &[u8])]) -> bool {
        let names = std::fs::read_dir(path)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name != MANIFEST && name != "mine.txt").collect();
        names.sort();
        let expected: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
        names == expected
            && files
                .iter()
                .all(|(name, of)| std::fs::read(path.join(name)).unwrap() == *of)
    }

    #[test]
    fn wherever_the_replacement_of_a_set_ends_the_old_set_or_the_new_one_is_whole() {
        let mut seen = [0; 2];
        for steps in 0.. {
            let directory = TemporaryFolder::new(&format!("durable-steps-{steps}"));
            open(&directory).publish(&OLD).unwrap();
            std::fs::write(directory.join("mine.txt"), "mine").unwrap();
            let mut left = steps;
            let mut step = || {
                if left == 0 {
                    return Err(io::Error::other("stop"));
                }
                left -= 1;
                Ok(())
            };
            let ended = open(&directory).publish_in_steps(&NEW, &mut step);
            // Before anything is completed: what a manifest vouches for is as it says.
            if let Ok(manifest) = Manifest::read(&directory) {
                assert_eq!(manifest.defects(&directory).unwrap(), [], "{steps}");
                assert!(holds(&directory, &OLD) || holds(&directory, &NEW), "{steps}");
            }
            drop(open(&directory));
            let manifest = Manifest::read(&directory).unwrap();
            assert_eq!(manifest.defects(&directory).unwrap(), [], "{steps}");
            let (old, new) = (holds(&directory, &OLD), holds(&directory, &NEW));
            assert!(old != new, "{steps}");
            seen[usize::from(new)] += 1;
            assert_eq!(std::fs::read(directory.join("mine.txt")).unwrap(), b"mine");
            if ended.is_ok() {
                assert!(new);
                break;
            }
        }
        // Staging and completing, and then as many steps as there are files to move.
        assert!(seen[0] >= 5 && seen[1] >= 6, "{seen:?}");
    }

    #[test]
    fn what_killed_processes_left_is_removed_and_nothing_else() {
        let directory = TemporaryFolder::new("durable-left");
        let staged = temporary().tempdir_in(&*directory).unwrap().keep();
        std::fs::write(staged.join("a.csv"), "half").unwrap();
        let foreign = directory.join("mine.part");
        std::fs::write(&foreign, "mine").unwrap();
        drop(open(&directory));
        assert!(!staged.exists() && foreign.exists());
    }
}

//! Where the numbers of a summary come from: program, processor and inputs.
//!
//! What a library must not find out by itself (the date, the command line, the commit of the program) is the caller's.

pub use dense_algebra::arithmetic_fingerprint;

use crate::Error;
use finite_elements::formats::abaqus;
use finite_elements::formats::solid_mesh::SolidMesh;
use joints::structure::matrix_files_of;
use scenes::{Scene, StructureSource, Surface};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Program, processor and inputs of a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Provenance {
    /// Program.
    pub program: ProgramBuild,
    /// When the run began, as ISO 8601 in UTC; `null` if the caller did not say.
    pub date: Option<String>,
    /// Program and arguments as they were called.
    pub command_line: Vec<String>,
    /// Folder that relative paths start from.
    pub working_directory: String,
    /// Instruction set that laws are evaluated with.
    pub instruction_set: String,
    /// Fingerprint of the arithmetic of processor and build ([`dense_algebra::arithmetic_fingerprint`]): with the same one and
    /// the same program, results are equal bit by bit.
    pub arithmetic: String,
    /// Threads; they change no bit.
    pub threads: usize,
    /// Files that the run read.
    pub inputs: Vec<Input>,
}

impl Provenance {
    /// Of a run in this process, with the threads of the calling pool. The caller knows the rest.
    pub fn new(
        program: ProgramBuild,
        date: Option<String>,
        command_line: Vec<String>,
        working_directory: &Path,
        inputs: Vec<Input>,
    ) -> Self {
        Self {
            program,
            date,
            command_line,
            working_directory: working_directory.display().to_string(),
            instruction_set: contact_laws::instruction_set().to_owned(),
            arithmetic: arithmetic_fingerprint().to_owned(),
            threads: rayon::current_num_threads(),
            inputs,
        }
    }
}

/// A build of a program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProgramBuild {
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Commit that it was built from, with `-modified` and a hash of the differences where sources differed from it; `null` if that is not known.
    pub commit: Option<String>,
}

/// What an input is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum InputRole {
    /// A scene that comes with the program; `path` is its name.
    BuiltInScene,
    /// The plan of a study.
    Plan,
    /// The scene file.
    Scene,
    /// The input deck.
    Deck,
    /// A file that the deck includes.
    DeckInclude,
    /// The mesh.
    Mesh,
    /// Matrices of the structure, or of a body.
    Matrices,
    /// Scan of the top face.
    TopScan,
    /// Scan of the bottom face.
    BottomScan,
    /// A record of a load in time.
    Record,
    /// A measured backbone.
    Measured,
}

impl InputRole {
    /// Which limits hold for it.
    fn kind(self) -> file_io::input::Kind {
        match self {
            Self::BuiltInScene | Self::Plan | Self::Scene => file_io::input::Kind::Scene,
            Self::Deck | Self::DeckInclude => file_io::input::Kind::Deck,
            Self::Mesh => file_io::input::Kind::Mesh,
            Self::Matrices => file_io::input::Kind::Matrices,
            Self::Record => file_io::input::Kind::Record,
            Self::Measured => file_io::input::Kind::Table,
            Self::TopScan | Self::BottomScan => file_io::input::Kind::Scan,
        }
    }
}

/// A file that a run read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Input {
    /// What it is.
    pub role: InputRole,
    /// Its path; relative ones start from the working directory.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// Its SHA-256, as hexadecimal text.
    pub sha256: String,
}

impl Input {
    /// A file as it stands.
    ///
    /// # Errors
    /// [`scenes::Error::InputFile`] if it is no regular file within the limit of its kind; [`Error::Store`] if it cannot be read.
    pub fn of_file(role: InputRole, path: &Path) -> Result<Self, Error> {
        file_io::input::check(path, role.kind())?;
        let (bytes, sha256) = file_io::durable::sha256_of_file(path)?;
        Ok(Self {
            role,
            path: path.display().to_string(),
            bytes,
            sha256,
        })
    }

    /// A scene that comes with the program.
    pub fn of_built_in_scene(name: &str, text: &str) -> Self {
        Self {
            role: InputRole::BuiltInScene,
            path: name.to_owned(),
            bytes: text.len() as u64,
            sha256: file_io::durable::sha256(text.as_bytes()),
        }
    }

    /// Refuses a file that is not what it was; relative paths start from `folder`. Scenes that came with the program are no
    /// files. A scene file may be gone, because the summary repeats it.
    ///
    /// # Errors
    /// [`Error::InputChanged`]; [`Error::Store`] if it cannot be read.
    pub fn check(&self, folder: &Path) -> Result<(), Error> {
        let path = folder.join(&self.path);
        match self.role {
            InputRole::BuiltInScene => return Ok(()),
            InputRole::Scene if !path.exists() => return Ok(()),
            _ => {}
        }
        let Self { bytes, sha256, .. } = Self::of_file(self.role, &path)?;
        if (bytes, &sha256) != (self.bytes, &self.sha256) {
            return Err(Error::InputChanged {
                path,
                expected: self.sha256.clone(),
                found: sha256,
            });
        }
        Ok(())
    }
}

/// The files that a scene names, and those that they include, as they stand.
///
/// # Errors
/// [`Error::Store`] for a file that cannot be read; of a deck whose includes cannot be found.
pub fn inputs_of(scene: &Scene) -> Result<Vec<Input>, Error> {
    let mut files: Vec<(InputRole, PathBuf)> = Vec::new();
    match &scene.structure.source {
        StructureSource::Deck(deck) => {
            files.push((InputRole::Deck, deck.path.clone()));
            let all = abaqus::files(&deck.path, deck.includes)?;
            files.extend(all.into_iter().skip(1).map(|path| (InputRole::DeckInclude, path)));
        }
        StructureSource::Mesh(mesh) => {
            let all = SolidMesh::files(&mesh.path)?;
            files.extend(all.into_iter().map(|path| (InputRole::Mesh, path)));
            for body in &mesh.superelements {
                let all = matrix_files_of(&body.path);
                files.extend(all.into_iter().map(|path| (InputRole::Matrices, path)));
            }
        }
        StructureSource::Matrices(matrices) => {
            let all = matrix_files_of(&matrices.path);
            files.extend(all.into_iter().map(|path| (InputRole::Matrices, path)));
        }
        StructureSource::Benchmark(_) => {}
    }
    for surface in scene.interfaces.surfaces() {
        if let Surface::Scans(scans) = surface {
            files.push((InputRole::TopScan, scans.top.path.clone()));
            files.push((InputRole::BottomScan, scans.bottom.path.clone()));
        }
    }
    if let Some(record) = scene.analyses.shock.as_ref().and_then(|shock| shock.record.as_ref()) {
        files.push((InputRole::Record, record.path.clone()));
    }
    let measured = scene.analyses.backbone.measured.iter();
    files.extend(measured.map(|path| (InputRole::Measured, path.clone())));
    files.iter().map(|(role, path)| Input::of_file(*role, path)).collect()
}

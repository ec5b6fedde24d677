//! `new`: a commented scene to start from, or a structure with the script that makes its mesh.

use super::destination::write_new;
use crate::text::print;
use anyhow::{Context, Result, bail};
use bolted_structures::Chain;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Options of `new`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the files, made if missing.
    directory: PathBuf,
    /// A bolted structure to start from, with a script that makes its mesh by Gmsh: half-brake-reuss-beam, lap-joint (two plates), ring (two
    /// flanges), s4 (two C-shaped beams); or with its mesh: chain-of-laps (bars in a row).
    #[arg(long, value_name = "NAME")]
    benchmark: Option<String>,
    /// Joints of a chain-of-laps, 1 to 200 [default: 4]
    #[arg(long, value_name = "N", requires = "benchmark", value_parser = clap::value_parser!(u16).range(1..=200))]
    joints: Option<u16>,
}

/// What all mesh scripts use.
const BLOCKS: (&str, &str) = ("blocks.py", include_str!("blocks.py"));

/// A structure to start from.
struct Template {
    name: &'static str,
    /// Names and contents of its files.
    files: [(&'static str, &'static str); 4],
}

macro_rules! template {
    ($name:literal) => {
        Template {
            name: $name,
            files: [
                ("README.md", include_str!(concat!($name, "/README.md"))),
                ("scene.json", include_str!(concat!($name, "/scene.json"))),
                ("mesh.py", include_str!(concat!($name, "/mesh.py"))),
                BLOCKS,
            ],
        }
    };
}

const TEMPLATES: [Template; 4] = [
    template!("half-brake-reuss-beam"),
    template!("lap-joint"),
    template!("ring"),
    template!("s4"),
];

/// The structure whose mesh is made here.
const CHAIN: &str = "chain-of-laps";

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let directory = &arguments.directory;
    let Some(name) = &arguments.benchmark else {
        write_new(directory, &[("scene.json", include_str!("plain.json").as_bytes())])?;
        return print(&format!(
            "a scene to start from is in {0}/scene.json; run it by\n  microslip run {0}/scene.json\n",
            directory.display()
        ));
    };
    if name == CHAIN {
        let default = Chain::default();
        let chain = Chain {
            joints: arguments.joints.map_or(default.joints, usize::from),
            ..default
        };
        let scene = format!("{:#}\n", chain.scene("chain.msh"));
        let mesh = chain.mesh().context("making the mesh")?;
        let readme = include_str!("chain-of-laps/README.md");
        let files = [
            ("README.md", readme.as_bytes()),
            ("scene.json", scene.as_bytes()),
            ("chain.msh", mesh.as_bytes()),
        ];
        return write_all(directory, &files);
    }
    if arguments.joints.is_some() {
        bail!("`{name}` has the joints that it has; --joints is for {CHAIN}");
    }
    let Some(template) = TEMPLATES.iter().find(|template| template.name == *name) else {
        let known = TEMPLATES.map(|template| template.name).join(", ");
        bail!("there is no structure `{name}` to start from; there are {known}, {CHAIN}");
    };
    write_all(directory, &template.files.map(|(name, text)| (name, text.as_bytes())))
}

/// Writes the files of a structure, and says so.
fn write_all(directory: &Path, files: &[(&str, &[u8])]) -> Result<()> {
    write_new(directory, files)?;
    let mut text = format!("written to {}:", directory.display());
    for (name, _) in files {
        write!(text, " {name}")?;
    }
    print(&format!("{text}\nREADME.md tells how to go on\n"))
}

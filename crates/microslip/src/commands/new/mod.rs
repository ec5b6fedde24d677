//! `new`: a commented scene to start from, or a structure with the script that makes its mesh.

pub(super) mod from;

use super::destination::write_new;
use crate::text::print;
use anyhow::{Context, Result, bail};
use bolted_structures::{Chain, Flange, Frame};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Options of `new`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the files, made if missing.
    directory: PathBuf,
    /// A bolted structure to start from, with a script that makes its mesh by Gmsh: half-brake-reuss-beam, lap-joint (two plates), ring (two
    /// flanges), s4 (two C-shaped beams); or with its mesh: bolted-frame (20 laps), chain-of-laps (bars in a row), flange (two rings on pads).
    #[arg(long, value_name = "NAME")]
    benchmark: Option<String>,
    /// A mesh or input deck to make a scene of: bodies that touch become interfaces, holes in a row bolts.
    #[arg(long, value_name = "FILE", conflicts_with = "benchmark", requires = "length")]
    from: Option<PathBuf>,
    /// Unit of length of that file: m, cm, mm, in or ft.
    #[arg(long, value_name = "UNIT", requires = "from", value_parser = from::LENGTHS)]
    length: Option<String>,
    /// Joints of a chain-of-laps, 1 to 200 [default: 4]
    #[arg(long, value_name = "N", requires = "benchmark", value_parser = clap::value_parser!(u16).range(1..=200))]
    joints: Option<u16>,
    /// Bolts of a flange, 3 to 200 [default: 8]
    #[arg(long, value_name = "N", requires = "benchmark", value_parser = clap::value_parser!(u16).range(3..=200))]
    bolts: Option<u16>,
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

/// Name of a mesh that is made here.
const MESH: &str = "mesh.msh";

/// Structures whose meshes are made here.
const MADE: [&str; 3] = ["bolted-frame", "chain-of-laps", "flange"];

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let directory = &arguments.directory;
    if let (Some(file), Some(length)) = (&arguments.from, &arguments.length) {
        return from::run(file, length, directory);
    }
    let Some(name) = &arguments.benchmark else {
        write_new(directory, &[("scene.json", include_str!("plain.json").as_bytes())])?;
        return print(&format!(
            "a scene to start from is in {0}/scene.json; run it by\n  microslip run {0}/scene.json\n",
            directory.display()
        ));
    };
    for (option, given, of) in [
        ("joints", arguments.joints, MADE[1]),
        ("bolts", arguments.bolts, MADE[2]),
    ] {
        if given.is_some() && name != of {
            bail!("`{name}` has as many joints and bolts as it has; --{option} is for {of}");
        }
    }
    let made = match MADE.iter().position(|made| made == name) {
        Some(0) => Some((Frame::default().mesh(), Frame::default().scene(MESH))),
        Some(1) => {
            let default = Chain::default();
            let joints = arguments.joints.map_or(default.joints, usize::from);
            let chain = Chain { joints, ..default };
            Some((chain.mesh(), chain.scene(MESH)))
        }
        Some(_) => {
            let default = Flange::default();
            let bolts = arguments.bolts.map_or(default.bolts, usize::from);
            let flange = Flange { bolts, ..default };
            Some((flange.mesh(), flange.scene(MESH)))
        }
        None => None,
    };
    if let Some((mesh, scene)) = made {
        let (mesh, scene) = (mesh.context("making the mesh")?, format!("{scene:#}\n"));
        let files = [
            ("README.md", include_str!("joints.md").as_bytes()),
            ("scene.json", scene.as_bytes()),
            (MESH, mesh.as_bytes()),
        ];
        return write_all(directory, &files);
    }
    let Some(template) = TEMPLATES.iter().find(|template| template.name == *name) else {
        let known = TEMPLATES.map(|template| template.name).join(", ");
        bail!(
            "there is no structure `{name}` to start from; there are {known}, {}",
            MADE.join(", ")
        );
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

//! Compiles C programs against the header and the static library, and runs them.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "helpers of tests")]

use std::env;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The static library of this build: it lies beside the test, or one folder up.
fn library() -> PathBuf {
    let test = env::current_exe().unwrap();
    let name = "libcontact_laws_c.a";
    let found = test
        .ancestors()
        .skip(1)
        .take(2)
        .map(|folder| folder.join(name))
        .find(|path| path.exists());
    found.unwrap_or_else(|| panic!("no {name} near {}", test.display()))
}

/// What the program prints, or `None` with a note where it cannot be compiled.
fn run(source: &Path) -> Option<String> {
    if !cfg!(target_os = "linux") {
        println!("skipped {}: how to link it is known for Linux only", source.display());
        return None;
    }
    let compiler = env::var_os("CC").unwrap_or_else(|| "cc".into());
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(source.file_stem().unwrap());
    let compiled = Command::new(&compiler)
        .args([
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-O1",
            "-g",
            "-I",
        ])
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("include"))
        .args(["-I", env!("CARGO_TARGET_TMPDIR")])
        .arg(source)
        .arg(library())
        .args(["-lpthread", "-ldl", "-lm", "-o"])
        .arg(&program)
        .output();
    let compiled = match compiled {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let source = source.display();
            println!("skipped {source}: no C compiler {compiler:?}, name one in the environment variable CC");
            return None;
        }
        other => other.unwrap(),
    };
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );

    let run = Command::new(&program).output().unwrap();
    let [out, err] = [&run.stdout, &run.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
    assert!(run.status.success(), "{}: {out}{err}", run.status);
    Some(out)
}

#[test]
fn the_loop_passes() {
    if let Some(text) = run(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/loop.c")) {
        assert_eq!(text, "passed\n");
    }
}

#[test]
fn the_example_of_the_readme_runs() {
    let readme = include_str!("../../README.md");
    let code = readme.split_once("```c\n").unwrap().1.split_once("```").unwrap().0;
    let source = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme.c");
    fs::write(&source, code).unwrap();
    if let Some(text) = run(&source) {
        // Stuck: k_x u_x = 4.5e5 Pa; slipping: mu k_n u_n = 2e5 Pa.
        assert_eq!(text, "t_x = 450000 and 200000 Pa, 1 slip\n");
    }
}

/// A list of any depth as an initialiser in C.
fn initialiser(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Array(list) => {
            let entries: Vec<String> = list.iter().map(initialiser).collect();
            format!("{{{}}}", entries.join(", "))
        }
        value => format!("{:e}", value.as_f64().unwrap()),
    }
}

/// Element cycles of yielding asperities as the authors' code computes them.
#[test]
fn the_element_cycles_are_those_of_the_reference() {
    let Some(folder) = env::var_os("BRB_REFERENCE") else {
        println!("skipped the element cycles of the authors' code: BRB_REFERENCE is not set");
        return;
    };
    // The variable may be relative to the workspace, while tests run in the crate's folder.
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = fs::read_to_string(workspace.join(folder).join("elastic_plastic_asperity.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let part = &file["element_cycles"];
    let length = |value: &serde_json::Value| value.as_array().unwrap().len();
    let (bins, cycles, steps) = (
        length(&part["gap_values"]),
        length(&part["uxyn"]),
        length(&part["uxyn"][0][0]),
    );
    let mut header = format!("enum {{ N_BINS = {bins}, N_CYCLES = {cycles}, N_STEPS = {steps} }};\n");
    for (name, field) in [
        ("radius", "R"),
        ("youngs_modulus", "E"),
        ("poisson_ratio", "nu"),
        ("yield_strength", "Sys"),
        ("tangent_modulus", "Et"),
        ("mu", "mu"),
        ("gaps[N_BINS]", "gap_values"),
        ("densities[N_BINS]", "gap_weights"),
        ("u[N_CYCLES][3][N_STEPS]", "uxyn"),
        ("expected[N_CYCLES][3][N_STEPS]", "txyn"),
    ] {
        header += &format!("static const double {name} = {};\n", initialiser(&part[field]));
    }
    fs::write(Path::new(env!("CARGO_TARGET_TMPDIR")).join("reference.h"), header).unwrap();
    if let Some(text) = run(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/element_cycles.c")) {
        let error: f64 = text.trim().parse().unwrap();
        println!("element cycles from C within {error:e} of the largest traction of a cycle");
        assert!(error <= 1e-6);
    }
}

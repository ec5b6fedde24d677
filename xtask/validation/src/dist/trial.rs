//! What is published, as a newcomer meets it.

use super::build::{Say, pip, python};
use super::elf::Linkage;
use super::process::{command, output};
use super::sources::Sources;
use anyhow::{Context, Result, ensure};
use flate2::read::GzDecoder;
use microslip::check::{self, Demand};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Runs a benchmark by a static program where there is nothing but the archive; the results must be those of an ordinary build, to the last bit.
///
/// # Errors
/// The program fails there, or its results are not sound or others.
pub fn program(
    sources: &Sources,
    archive: &[u8],
    folder: &str,
    linkage: Linkage,
    scratch: &Path,
    say: Say<'_>,
) -> Result<()> {
    const ALONE: [&str; 5] = ["--map-root-user", "--mount", "--pid", "--kill-child", "--mount-proc"];
    if linkage != Linkage::Static {
        return say("skipped: a dynamic program does not run where there is nothing else\n");
    }
    if let Err(why) = output(Command::new("unshare").args(ALONE).arg("true")) {
        return say(&format!("skipped: no program can be shut away here: {why:#}\n"));
    }
    let began = Instant::now();
    let root = scratch.join("root");
    tar::Archive::new(GzDecoder::new(archive))
        .unpack(&root)
        .context("unpacking the archive")?;
    for name in ["proc", "tmp"] {
        std::fs::create_dir_all(root.join(name)).with_context(|| format!("making {name} in {}", root.display()))?;
    }
    let alone = |arguments: &[&str]| {
        let mut command = Command::new("unshare");
        command.args(ALONE).arg("--root").arg(&root).args(["--wd", "/tmp"]);
        command.env_clear().arg(format!("/{folder}/microslip")).args(arguments);
        command
    };
    output(&mut alone(&[
        "run",
        "--benchmark",
        "brake-reuss-beam",
        "--out",
        "results",
    ]))?;
    let seconds = began.elapsed().as_secs_f64();
    let results = root.join("tmp/results");
    let count = check::results(&results, Demand::Complete)?;
    view(alone(&["view", "results", "--no-open"]))?;
    say(&format!(
        "from the archive alone to a backbone: {seconds:.1} s; {count} checks passed; `view` shows it\n"
    ))?;
    let verify = "cargo run --locked --release --package microslip -- verify --rerun";
    let compared = output(command(verify, &sources.root).arg(&results))?;
    let last = compared.trim().lines().last().unwrap_or_default();
    say(&format!("by an ordinary build: {last}\n"))
}

/// Asks the server of `view` for the page of the run.
fn view(mut command: Command) -> Result<()> {
    let mut server = command.stdout(Stdio::piped()).spawn().context("starting `view`")?;
    let mut ask = || {
        let mut line = String::new();
        BufReader::new(server.stdout.take().context("`view` has no output")?).read_line(&mut line)?;
        let address = line.split("http://").nth(1).and_then(|rest| rest.split('/').next());
        let address = address.with_context(|| format!("`view` gives no address: `{line}`"))?;
        let mut stream = TcpStream::connect(address)?;
        write!(stream, "GET /1/report.html HTTP/1.0\r\nHost: {address}\r\n\r\n")?;
        let mut page = String::new();
        stream.read_to_string(&mut page)?;
        let status = page.lines().next().unwrap_or_default();
        ensure!(
            status.contains(" 200 ") && page.contains("<svg"),
            "`view` answers `{status}`"
        );
        Ok(())
    };
    let asked = ask();
    server.kill().and_then(|()| server.wait()).context("ending `view`")?;
    asked.context("asking `view` for a report")
}

/// Installs a wheel for a Python that knows no Rust, and runs a benchmark.
///
/// # Errors
/// The package fails, or finds no backbone.
pub fn wheel(name: &str, contents: &[u8], scratch: &Path, say: Say<'_>) -> Result<()> {
    const SCRIPT: &str = "import microslip\n\
        run = microslip.run(microslip.Scene.benchmark('brake-reuss-beam'))\n\
        assert len(run.frequency_hz) > 0 and run.frequency_hz[0] > run.frequency_hz[-1] > 0";
    let path = scratch.join(name);
    std::fs::write(&path, contents).with_context(|| format!("writing {}", path.display()))?;
    let began = Instant::now();
    let folder = scratch.join("newcomer");
    let Some(programs) = python(&folder, &["numpy"], say)? else {
        return Ok(());
    };
    output(pip(&programs).arg("--no-deps").arg(&path))?;
    let mut command = Command::new(programs.join("python"));
    output(
        command
            .env_clear()
            .env("HOME", &folder)
            .current_dir(&folder)
            .args(["-c", SCRIPT]),
    )?;
    say(&format!(
        "from the wheel to a backbone in Python: {:.1} s\n",
        began.elapsed().as_secs_f64()
    ))
}

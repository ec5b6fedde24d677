//! `view`: runs beside each other in a browser.

mod server;

use crate::files;
use crate::text::print;
use analyses::results::summary::Summary;
use anyhow::{Context, Result, ensure};
use reports::names::SUMMARY;
use reports::several::{self, Entry};
use server::Site;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Options of `view`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folders of results of `run`, or of `forced`.
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// Print the address and leave it to the reader to open it.
    #[arg(long)]
    no_open: bool,
}

/// Runs the command, which ends with the process.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let mut runs = Vec::with_capacity(arguments.results.len());
    for folder in &arguments.results {
        ensure!(
            folder.is_dir(),
            "{} is no folder; give the folders of results, which `microslip run` writes",
            folder.display()
        );
        let path = folder.join(SUMMARY);
        let text = file_io::input::read_text(&path, file_io::input::Kind::Table)?;
        let summary: Summary = files::parse(&path, &text, files::A_SUMMARY)?;
        runs.push(summary);
    }
    let name = |summary: &Summary| summary.scene["name"].as_str().unwrap_or_default().to_owned();
    let names: Vec<String> = runs
        .iter()
        .zip(&arguments.results)
        .map(
            |(run, folder)| match runs.iter().filter(|other| name(other) == name(run)).count() {
                1 => name(run),
                _ => format!("{} ({})", name(run), folder.display()),
            },
        )
        .collect();
    let pages: Vec<String> = (1..=runs.len()).map(|number| format!("{number}/report.html")).collect();
    let entries: Vec<Entry<'_>> = (names.iter().zip(&pages).zip(&runs))
        .map(|((name, page), summary)| Entry { name, page, summary })
        .collect();
    let site = Site {
        index: several::document(&entries)?,
        folders: arguments.results.clone(),
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).context("listening on the loopback interface")?;
    let address = format!(
        "http://{}/",
        listener.local_addr().context("listening on the loopback interface")?
    );
    print(&format!("{} runs at {address}; Ctrl-C ends it\n", runs.len()))?;
    if !arguments.no_open {
        open(&address);
    }
    server::serve(&listener, site)
}

/// Asks the system to show an address. Where it cannot, the reader has the address.
fn open(address: &str) {
    let (program, arguments) = if cfg!(target_os = "macos") {
        ("open", vec![address])
    } else if cfg!(windows) {
        ("rundll32", vec!["url.dll,FileProtocolHandler", address])
    } else {
        ("xdg-open", vec![address])
    };
    let mut command = Command::new(program);
    let command = command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    if let Ok(mut child) = command.spawn() {
        std::thread::spawn(move || child.wait());
    }
}

//! The program: `microslip --help`.

use clap::Parser;
use host::user_cache;
use microslip::Defaults;
use microslip::cli::Cli;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = Cli::parse();
    microslip::execute(cli.display(), || {
        cli.run(&Defaults {
            cache: user_cache(),
            benchmark: None,
        })
    })
}

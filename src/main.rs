//! joton: from the command line's words to an exit code.
#![forbid(unsafe_code)]

mod cli;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::run(cli::Arguments::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(e) => {
            eprintln!("joton: {e}");
            ExitCode::from(2)
        }
    }
}

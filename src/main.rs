//! joton: from the command line's words to an exit code.
#![deny(unsafe_code)]

mod cli;
mod system;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    system::leave_windows_out();
    system::outlive_large_files();
    let done = match cli::Arguments::try_parse() {
        Ok(arguments) => cli::run(arguments).map_err(|e| e.to_string()),
        Err(e) => cli::refuse(&e),
    };
    match done {
        Ok(code) => ExitCode::from(code),
        Err(line) => {
            cli::tell(format_args!("joton: {line}"));
            ExitCode::from(2)
        }
    }
}

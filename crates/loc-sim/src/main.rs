//! The command `loc-sim`.

use clap::Parser;
use loc_sim::cli::{self, Cli};
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    // A wrong usage ends here, with exit code 2.
    match Cli::parse().execute() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Where even this cannot be written, the exit code has to do.
            let _ = writeln!(std::io::stderr(), "error: {}", cli::one_line(&error));
            cli::exit_code(&error).into()
        }
    }
}

//! The command `loc-sim`.

use clap::{Parser, Subcommand};
use loc_sim::cli::{self, eval};
use std::io::Write;
use std::process::ExitCode;

/// Every estimator on every recording, simulated or real, judged the same way.
#[derive(Debug, Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Eval(eval::EvalArgs),
}

fn main() -> ExitCode {
    // A wrong usage ends here, with exit code 2.
    let result = match Cli::parse().command {
        Command::Eval(args) => eval::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Where even this cannot be written, the exit code has to do.
            let _ = writeln!(std::io::stderr(), "error: {}", cli::one_line(&error));
            ExitCode::FAILURE
        }
    }
}

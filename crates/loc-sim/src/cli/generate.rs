//! `loc-sim completions` and `loc-sim man`: what a shell and a manual need, made from the command line
//! itself.

use super::Cli;
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::Write;

/// Print the completions of a shell.
///
/// For bash: `loc-sim completions bash > ~/.local/share/bash-completion/completions/loc-sim`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell.
    shell: Shell,
}

/// Print the manual page.
///
/// To read it: `loc-sim man | man -l -`.
#[derive(Debug, clap::Args)]
pub struct ManArgs {}

/// Prints the completions of a shell.
///
/// # Errors
/// Those of standard output; a closed pipe is not one.
pub fn completions(args: &CompletionsArgs) -> anyhow::Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "loc-sim", &mut text);
    write_all(&text)
}

/// Prints the manual page.
///
/// # Errors
/// Those of standard output; a closed pipe is not one.
pub fn man() -> anyhow::Result<()> {
    let mut text = Vec::new();
    clap_mangen::Man::new(Cli::command()).render(&mut text)?;
    write_all(&text)
}

fn write_all(text: &[u8]) -> anyhow::Result<()> {
    match std::io::stdout().lock().write_all(text) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result?),
    }
}

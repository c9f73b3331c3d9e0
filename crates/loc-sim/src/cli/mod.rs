//! The command `loc-sim`: one module per subcommand.

pub mod eval;

use std::io::Write;

/// Writes a text and a line break to standard output.
///
/// A reader that has gone away (`loc-sim .. | head -1`) is no failure.
///
/// # Errors
/// Whatever else the operating system says.
pub fn print(text: &str) -> anyhow::Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result?),
    }
}

/// An error with its chain of causes in one line. A cause that the line tells already is left out.
pub fn one_line(error: &anyhow::Error) -> String {
    let mut line = String::new();
    for cause in error.chain() {
        let text = cause.to_string();
        if line.is_empty() {
            line = text;
        } else if !line.contains(&text) {
            line = format!("{line}: {text}");
        }
    }
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

//! The command `loc-sim`: one module per subcommand.

mod console;
pub mod convert;
pub mod eval;
pub mod fit_beam;
pub mod generate;
pub mod info;
pub mod map;
pub mod replay;
pub mod run;
pub mod sense;
mod show;
pub mod study;

use crate::Result;
use crate::localizer::MethodSettings;
use clap::{Parser, Subcommand};
use std::io::Write;

/// Every estimator on every recording, simulated or real, evaluated the same way.
///
/// Without a subcommand it runs the scenario `overview`.
#[derive(Debug, Parser)]
#[command(version)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    global: Global,
}

/// The options of every subcommand.
#[derive(Debug, Clone, clap::Args)]
pub struct Global {
    /// Print JSON on standard output instead of tables.
    #[arg(long, global = true)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Number of threads of methods that can use several; the results stay the same.
    #[arg(long, global = true, value_name = "N")]
    pub threads: Option<usize>,
}

#[derive(Debug, Subcommand)]
enum Command {
    List(run::ListArgs),
    Run(run::RunArgs),
    Replay(Box<replay::ReplayArgs>),
    Info(info::InfoArgs),
    Convert(convert::ConvertArgs),
    Eval(eval::EvalArgs),
    Map(map::MapArgs),
    Sense(sense::SenseArgs),
    FitBeam(fit_beam::FitBeamArgs),
    Study(study::StudyArgs),
    Completions(generate::CompletionsArgs),
    Man(generate::ManArgs),
}

impl Cli {
    /// Executes the command line.
    ///
    /// # Errors
    /// Any error, to be printed in one line.
    pub fn execute(&self) -> anyhow::Result<()> {
        if !matches!(self.command, Some(Command::Study(_))) {
            // A study keeps finished runs and has a handler of its own.
            console::handle_interrupts()?;
        }
        match &self.command {
            None => run::run(&run::RunArgs::default(), &self.global),
            Some(Command::List(args)) => run::list(args, &self.global),
            Some(Command::Run(args)) => run::run(args, &self.global),
            Some(Command::Replay(args)) => replay::replay(args, &self.global),
            Some(Command::Info(args)) => info::info(args, &self.global),
            Some(Command::Convert(args)) => convert::convert(args, &self.global),
            Some(Command::Eval(args)) => eval::run(args, &self.global),
            Some(Command::Map(args)) => map::map(args, &self.global),
            Some(Command::Sense(args)) => sense::sense(args, &self.global),
            Some(Command::FitBeam(args)) => fit_beam::fit_beam(args, &self.global),
            Some(Command::Study(args)) => study::study(args, &self.global),
            Some(Command::Completions(args)) => generate::completions(args),
            Some(Command::Man(_)) => generate::man(),
        }
    }
}

/// The exit code of a command that Ctrl-C has ended: 128 and the number of the signal.
const INTERRUPTED: u8 = 130;

/// The exit code that an error stands for.
pub fn exit_code(error: &anyhow::Error) -> u8 {
    if error.is::<study::Interrupted>() { INTERRUPTED } else { 1 }
}

/// Writes a text and a line break to standard output, in the width of the terminal.
///
/// A closed pipe (`loc-sim .. | head -1`) is not an error.
///
/// # Errors
/// Other errors of the operating system.
pub fn print(text: &str) -> anyhow::Result<()> {
    let text = console::width().map_or(text.into(), |width| console::narrow(text, width));
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result?),
    }
}

/// The text of a configuration, and below it all settings of the methods in effect, as comments.
///
/// # Errors
/// A number that TOML has no form for.
pub fn with_effective(text: &str, settings: &MethodSettings) -> Result<String> {
    let all = settings.to_toml()?;
    let comments = all.lines().map(|line| format!("# {line}").trim_end().to_owned());
    let comments: Vec<String> = comments.collect();
    let text = text.trim_end();
    Ok(format!("{text}\n\n# All settings of the methods in effect:\n#\n{}", comments.join("\n")))
}

/// An error with its chain of causes in one line; a cause that the line contains already is left out.
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

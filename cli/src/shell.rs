//! Shell completions and man pages.

use crate::failure::{Failure, Result, print};
use clap::{Args, Command};
use clap_complete::Shell;

#[derive(Args, Debug)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

#[derive(Args, Debug)]
pub(crate) struct ManArgs {
    /// A command, such as segment; the program itself if left out
    command: Option<String>,
}

/// Prints completions of the program for a shell.
pub(crate) fn completions(args: &CompletionsArgs, mut program: Command) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "tracecut", &mut script);
    print(String::from_utf8_lossy(&script).trim_end())
}

/// Prints a man page of the program or of one of its commands.
pub(crate) fn man(args: &ManArgs, mut program: Command) -> Result<()> {
    program.build();
    let command = match &args.command {
        None => program,
        Some(name) => {
            let subcommand = program.find_subcommand(name).cloned();
            subcommand
                .ok_or_else(|| Failure::usage(format!("there is no command \"{name}\" (tracecut --help lists them)")))?
        }
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page).map_err(|e| Failure::new(format!("man page: {e}")))?;
    print(String::from_utf8_lossy(&page).trim_end())
}

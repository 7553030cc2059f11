//! `tracecut`: the command line.

fn main() -> std::process::ExitCode {
    tracecut_cli::run_program(std::env::args_os()).into()
}

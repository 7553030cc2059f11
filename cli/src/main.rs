//! `tracecut`: the command line.

fn main() -> std::process::ExitCode {
    tracecut_cli::main()
}

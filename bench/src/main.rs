//! `bench`: scores against ground truth.

fn main() -> std::process::ExitCode {
    tracecut_bench::main()
}

//! wasm-pack, wasm-bindgen and its test runner as one program, which acts as the one that its file name says: their shared
//! dependencies are compiled once. `scripts/tools.mjs` compiles it.

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let program = std::env::args_os().next().unwrap_or_default();
    let name = Path::new(&program).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let outcome = match name.as_str() {
        "wasm-bindgen" => wasm_bindgen_cli::wasm_bindgen::run_cli_with_args(std::env::args_os()),
        "wasm-bindgen-test-runner" => {
            wasm_bindgen_cli::wasm_bindgen_test_runner::run_cli_with_args(std::env::args_os())
        }
        "wasm-pack" => wasm_pack::command::run_wasm_pack(wasm_pack::Cli::parse().cmd),
        _ => {
            println!("{name} {}", env!("CARGO_PKG_VERSION"));
            Ok(())
        }
    };
    outcome.map_or_else(
        |error| {
            eprintln!("{error:?}");
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}

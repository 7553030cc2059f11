//! wasm-bindgen for the build: the library of its command line tool, without the tool's test runner and network code. `scripts/tools.mjs` compiles it.

use wasm_bindgen_cli_support::Bindgen;

const USAGE: &str = "usage: bindgen --version | WASM FOLDER NAME";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["--version"] => println!("bindgen {}", env!("CARGO_PKG_VERSION")),
        [wasm, folder, name] => {
            let mut bindgen = Bindgen::new();
            bindgen.input_path(wasm).out_name(name).typescript(true).omit_default_module_path(false);
            // The reset function lets the package start again after a panic.
            let made = bindgen.reset_state_function(true).web(true).and_then(|bindgen| bindgen.generate(folder));
            if let Err(error) = made {
                eprintln!("{error:?}");
                std::process::exit(1);
            }
        }
        _ => {
            eprintln!("{USAGE}");
            std::process::exit(2);
        }
    }
}

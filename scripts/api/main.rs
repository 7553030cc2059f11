//! Prints the public items of a crate from rustdoc's JSON. That format is unstable, so rustdoc must act as a nightly one;
//! cargo calls it through this program, or it would build all dependencies again.
//! `scripts/tools.mjs` compiles it.

use std::process::{Command, exit};

use public_api::Builder;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["--version"] => println!("api {}", env!("CARGO_PKG_VERSION")),
        [json] if json.ends_with(".json") => {
            let api = Builder::from_rustdoc_json(json).omit_auto_trait_impls(true).omit_blanket_impls(true);
            print!("{}", api.omit_auto_derived_impls(true).build().expect("JSON of a rustdoc that public-api knows"));
        }
        _ => {
            let rustdoc = Command::new("rustdoc").args(&arguments).env("RUSTC_BOOTSTRAP", "1").status();
            exit(rustdoc.ok().and_then(|status| status.code()).unwrap_or(1));
        }
    }
}

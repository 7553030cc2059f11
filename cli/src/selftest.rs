//! `selftest`: whether this machine computes what every other does.

mod checks;

use crate::failure::{Failure, Result, print};
use checks::{Check, Checks};
use clap::Args;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};

/// What every machine and engine should give; the npm package is built with the same file.
const EXPECTED: &str = include_str!("selftest/expected.json");
const VERSION: &str = env!("CARGO_PKG_VERSION");
const REPORT: &str = "please report this machine and this list at https://github.com/tracecut/tracecut/issues";

#[derive(Args, Debug)]
pub(crate) struct SelftestArgs {
    /// Threads to work on; the hashes are the same for any number
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

#[derive(Deserialize, Debug)]
struct Expected {
    version: String,
    hashes: BTreeMap<String, String>,
}

/// How many of the checks that were told are as expected.
#[derive(Debug)]
struct Tally {
    expected: Expected,
    same: usize,
    different: usize,
}

impl Tally {
    fn of(expected: &str) -> Result<Self> {
        let expected = serde_json::from_str(expected).map_err(|e| Failure::new(format!("the expected hashes: {e}")))?;
        Ok(Self { expected, same: 0, different: 0 })
    }

    /// Counts a check, and gives what is printed of it.
    fn count(&mut self, Check { name, what, hash }: &Check) -> String {
        let wanted = self.expected.hashes.get(*name).map_or("nothing", String::as_str);
        if wanted == hash {
            self.same += 1;
            return format!("{name:16} {hash}  same  ({what})");
        }
        self.different += 1;
        format!("{name:16} {hash}  DIFFERENT from {wanted}  ({what})")
    }

    /// The last line.
    fn verdict(&self) -> Result<String> {
        let (all, version) = (self.expected.hashes.len(), &self.expected.version);
        if version != VERSION {
            return Err(Failure::new(format!(
                "the hashes are those of version {version}, this is {VERSION}: {REPORT}"
            )));
        }
        if self.same == all && self.different == 0 {
            return Ok(format!("All {all} hashes are those of every other machine and engine."));
        }
        Err(Failure::new(format!("{} of {all} hashes differ: {REPORT}", all - self.same)))
    }
}

/// Prints each hash and whether it is the expected one.
pub(crate) fn selftest(args: &SelftestArgs) -> Result<()> {
    let mut tally = Tally::of(EXPECTED)?;
    print(format_args!("tracecut {VERSION}, native on {OS} {ARCH}"))?;
    Checks::new(args.threads.into()).all(|check| print(tally.count(&check)))?;
    print(tally.verdict()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(hash: &str) -> Tally {
        let expected = format!(r#"{{"version": "{VERSION}", "hashes": {{"masks": "0a", "png": "0b"}}}}"#);
        let mut tally = Tally::of(&expected).unwrap();
        tally.count(&Check { name: "masks", what: "", hash: hash.to_owned() });
        tally
    }

    #[test]
    fn a_hash_that_differs_fails_and_so_does_one_that_is_missing() {
        let png = |hash: &str| Check { name: "png", what: "files", hash: hash.to_owned() };
        let mut good = tally("0a");
        assert!(good.verdict().unwrap_err().reason.starts_with("1 of 2 hashes differ: please report"));
        assert!(good.count(&png("0b")).ends_with("0b  same  (files)"));
        assert!(good.verdict().is_ok());
        good.expected.version = "0.0.1".to_owned();
        assert!(good.verdict().is_err());
        let mut bad = tally("0a");
        assert!(bad.count(&png("0c")).ends_with("0c  DIFFERENT from 0b  (files)"));
        assert_eq!(bad.verdict().unwrap_err().kind as u8, 1);
    }
}

//! Tests of the measures against recorded results, of the program and of what reads files: one program, so that what
//! they share is compiled and linked once.

mod bench;
mod benchmark;
#[allow(unreachable_pub, dead_code, reason = "shared with the tests of the command line")]
#[path = "../../cli/tests/helpers.rs"]
mod helpers;
#[allow(unreachable_pub, dead_code, reason = "fuzz targets, of another crate, call the same modules")]
mod readers;

//! Tests of the program and of what reads files: one program, so that what they share is compiled and linked once.

mod cli;
#[allow(unreachable_pub, dead_code, reason = "shared with other tests")]
mod helpers;
mod long;
#[allow(unreachable_pub, dead_code, reason = "fuzz targets, of another crate, call the same modules")]
mod readers;
mod videos;

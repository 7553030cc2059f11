//! The files that fuzzing begins with, with faults in them. The tests of `bench/` read such files too.

#[path = "../../../tests/rust/made/choices.rs"]
mod choices;
#[path = "../../../tests/rust/made/mutate.rs"]
mod mutate;
#[path = "../../../tests/rust/made/seeds.rs"]
mod seeds;

use choices::Choices;
use std::ops::Range;

/// A reader, and the target whose seeds it reads.
pub type Reader = (&'static str, fn(&[u8]));

/// The seeds of a fuzz target, by name.
pub fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    seeds::all().into_iter().filter(|seed| seed.0 == target).map(|(_, name, bytes)| (name, bytes)).collect()
}

/// Has each reader read its seeds with faults of each of these kinds.
pub fn read_faulty(readers: &[Reader], seeds_of: Range<u64>) {
    for &(target, reader) in readers {
        let files = seeds(target);
        for seed in seeds_of.clone() {
            let mut choices = Choices::of_seed(seed, target);
            let (file, other) = (choices.below(files.len()), choices.below(files.len()));
            let bytes = mutate::mutated(&mut choices, &files[file].1, &files[other].1);
            let outcome = std::panic::catch_unwind(|| reader(&bytes));
            assert!(outcome.is_ok(), "{target}, seed {seed}: {bytes:?}");
        }
    }
}

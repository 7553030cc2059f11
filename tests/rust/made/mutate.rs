//! Files with a few faults: what property tests have in place of a fuzzer.

use super::choices::Choices;

/// Numbers at which readers stumble.
const ODD: [u32; 10] = [0, 1, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff];

/// `bytes` with one to six faults; parts of `other` may come in.
pub fn mutated(choices: &mut Choices<'_>, bytes: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + choices.below(6) {
        fault(choices, &mut bytes, other);
    }
    bytes
}

fn fault(choices: &mut Choices<'_>, bytes: &mut Vec<u8>, other: &[u8]) {
    let length = bytes.len();
    let at = choices.below(length + 1);
    let end = (at + 1 + choices.below(24)).min(length);
    match choices.below(8) {
        0 => bytes.truncate(at),
        1 if at < length => bytes[at] ^= 1 << choices.below(8),
        2 if at < length => bytes[at] = choices.below(256) as u8,
        3 => drop(bytes.drain(at..end.max(at))),
        4 => {
            let part = bytes[at..end.max(at)].to_vec();
            bytes.splice(at..at, part);
        }
        5 => {
            let from = choices.below(other.len() + 1);
            let part = other[from..(from + choices.below(64)).min(other.len())].to_vec();
            bytes.splice(at..end.max(at), part);
        }
        6 => number(choices, bytes, at),
        _ => digit(choices, bytes, at),
    }
}

/// An odd number in place of what stands there, in either order of bytes.
fn number(choices: &mut Choices<'_>, bytes: &mut [u8], at: usize) {
    let number = choices.pick(&ODD);
    let mut word = if choices.once_in(2) { number.to_le_bytes() } else { number.to_be_bytes() };
    word.rotate_left(choices.below(4));
    let width = choices.pick(&[1, 2, 4]);
    bytes.iter_mut().skip(at).zip(word).take(width).for_each(|(byte, value)| *byte = value);
}

/// Another digit or sign in place of the next one: a fault in a file of text.
fn digit(choices: &mut Choices<'_>, bytes: &mut [u8], at: usize) {
    if let Some(byte) = bytes.iter_mut().skip(at).find(|byte| byte.is_ascii_digit()) {
        *byte = choices.pick(b"0123456789-.eEnN \n");
    }
}

//! Pieces of work that any thread or worker can do.

mod ledger;
mod pair;
mod piece;
#[cfg(any(feature = "wasm", test))]
mod wire;

pub(crate) use ledger::Ledger;
pub(crate) use pair::{Forward, PairFlow, Seen};
pub(crate) use piece::{Made, Piece, PieceId, PieceKind, Work};

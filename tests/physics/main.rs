//! Physics with a closed answer.

mod channels;
mod column;
mod ledger;
mod needle;
mod scenes;
mod waves;

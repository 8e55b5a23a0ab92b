//! Physics with a closed answer.

mod channels;
mod column;
mod dam;
mod ledger;
mod needle;
mod scenes;
mod waves;

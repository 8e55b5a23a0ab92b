//! Physics with a closed answer.
#![allow(clippy::unwrap_used)]

mod barrier;
mod channels;
mod column;
mod dam;
mod energy;
mod ledger;
mod movers;
mod needle;
mod room;
mod scenes;
mod steady;
mod stretched;
mod waves;

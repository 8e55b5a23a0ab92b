//! Physics with a closed answer.

mod channels;
mod column;
mod scenes;
mod waves;
mod needle;

//! Physics with a closed answer.

mod channels;
mod column;
mod needle;
mod scenes;
mod waves;

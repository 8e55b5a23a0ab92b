//! Lines and letters on pictures, with a font drawn for this project.

mod font;
mod pen;

pub use pen::{Pen, blend, draw_lines};

//! Lines and letters on pictures, with a font drawn for this project, and pictures as files.

mod font;
mod pen;

pub use pen::{Pen, blend, draw_lines};

use image::{ImageFormat, ImageResult, RgbImage};
use std::io::Cursor;

/// A picture as the bytes of a PNG file. A picture of no size is an error.
pub fn png(picture: &RgbImage) -> ImageResult<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

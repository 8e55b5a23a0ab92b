//! Many pictures on one: rows of scenes or views, columns of times; and pictures that move.

use crate::ink::Pen;
use crate::math::Real;
use image::{Rgb, RgbImage};
use std::io;

/// A row of a contact sheet.
#[derive(Clone, Debug)]
pub struct Row {
    /// What it shows.
    pub title: String,
    /// Its pictures, all of one size, each with the sRGB colour of its frame: how it went.
    pub pictures: Vec<(RgbImage, [u8; 3])>,
}

/// sRGB of the frame around a picture of what went well.
pub const WELL: [u8; 3] = [70, 140, 90];
/// sRGB of the frame around the last picture of what ended with cement outside of the bone.
pub const LEAKED: [u8; 3] = [222, 160, 40];
/// sRGB of the frame around the last picture of what fell over.
pub const FELL_OVER: [u8; 3] = [190, 60, 50];

const MARGIN: u32 = 6;
const FRAME: u32 = 3;
const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [38, 44, 54];

/// The rows below each other.
pub fn contact_sheet(rows: &[Row]) -> RgbImage {
    let all = || rows.iter().flat_map(|row| &row.pictures);
    let width = all().map(|(p, _)| p.width()).max().unwrap_or(1);
    let height = all().map(|(p, _)| p.height()).max().unwrap_or(1);
    let columns = rows.iter().map(|row| row.pictures.len()).max().unwrap_or(0) as u32;
    let text = (height / 14).clamp(10, 28);
    let step = [
        width + 2 * FRAME + MARGIN,
        height + 2 * FRAME + MARGIN + 2 * text,
    ];
    let size = [
        MARGIN + columns * step[0],
        MARGIN + rows.len() as u32 * step[1],
    ];
    let mut sheet = RgbImage::from_pixel(size[0].max(1), size[1].max(1), Rgb(PAPER));
    let pen = Pen {
        size: text.into(),
        ink: INK,
        halo: PAPER,
    };
    for (r, row) in (0..).zip(rows) {
        let top = MARGIN + r * step[1];
        pen.write(
            &mut sheet,
            &row.title,
            MARGIN.into(),
            Real::from(top) + 1.4 * Real::from(text),
        );
        for (c, (picture, frame)) in (0..).zip(&row.pictures) {
            let (left, top) = (MARGIN + c * step[0], top + 2 * text);
            for y in 0..picture.height() + 2 * FRAME {
                for x in 0..picture.width() + 2 * FRAME {
                    let inside = (x.wrapping_sub(FRAME), y.wrapping_sub(FRAME));
                    let pixel = picture.get_pixel_checked(inside.0, inside.1).copied();
                    sheet.put_pixel(left + x, top + y, pixel.unwrap_or(Rgb(*frame)));
                }
            }
        }
    }
    sheet
}

/// A picture a whole number of times smaller, each pixel the mean of those that it stands for.
pub fn shrunk(picture: &RgbImage, times: u32) -> RgbImage {
    let times = times.max(1);
    let size = [picture.width() / times, picture.height() / times].map(|s| s.max(1));
    RgbImage::from_fn(size[0], size[1], |x, y| {
        let mut sums = [0_u32; 3];
        let mut count = 0;
        for row in y * times..((y + 1) * times).min(picture.height()) {
            for column in x * times..((x + 1) * times).min(picture.width()) {
                let pixel = picture.get_pixel(column, row);
                count += 1;
                for k in 0..3 {
                    sums[k] += u32::from(pixel[k]);
                }
            }
        }
        Rgb(sums.map(|sum| ((sum + count / 2) / count) as u8))
    })
}

/// An animated PNG that plays for ever; all pictures of one size.
pub fn animation(pictures: &[&RgbImage], frames_per_second: Real) -> io::Result<Vec<u8>> {
    let Some(first) = pictures.first() else {
        return Err(io::Error::other("an animation of no pictures"));
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, first.width(), first.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder
        .set_animated(pictures.len() as u32, 0)
        .map_err(io::Error::other)?;
    let delay = (1000.0 / frames_per_second).round().clamp(1.0, 60_000.0) as u16;
    encoder
        .set_frame_delay(delay, 1000)
        .map_err(io::Error::other)?;
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    for picture in pictures {
        writer.write_image_data(picture).map_err(io::Error::other)?;
    }
    writer.finish().map_err(io::Error::other)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_in_rows_with_their_frames() {
        let picture = |v: u8| RgbImage::from_pixel(40, 30, Rgb([v; 3]));
        let row = |title: &str| Row {
            title: title.to_owned(),
            pictures: vec![(picture(10), WELL), (picture(20), FELL_OVER)],
        };
        let sheet = contact_sheet(&[row("one"), row("two")]);
        let count = |colour: [u8; 3]| sheet.pixels().filter(|p| p.0 == colour).count();
        assert_eq!((count([10; 3]), count([20; 3])), (2400, 2400));
        assert_eq!((count(WELL), count(FELL_OVER)), (2 * 456, 2 * 456));
        assert_eq!(contact_sheet(&[]).dimensions(), (6, 6));
    }

    #[test]
    fn an_animation_holds_its_pictures_and_their_pace() {
        let pictures: Vec<_> = (0..3)
            .map(|n| RgbImage::from_pixel(5, 4, Rgb([n * 40, 0, 9])))
            .collect();
        let bytes = animation(&pictures.iter().collect::<Vec<_>>(), 8.0).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        for picture in &pictures {
            let mut pixels = vec![0; 5 * 4 * 3];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(&pixels, picture.as_raw());
            assert_eq!(reader.info().frame_control().unwrap().delay_num, 125);
        }
        assert!(animation(&[], 8.0).is_err());
        let small = shrunk(&RgbImage::from_fn(4, 4, |x, _| Rgb([x as u8 * 10; 3])), 2);
        assert_eq!(small.get_pixel(1, 0), &Rgb([25; 3]));
    }
}

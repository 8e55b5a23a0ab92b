//! The map of a stress matrix: a square a run, its colour says how it ended.

use super::trial::{End, Family, Fate, Mode, Trial};
use crate::ink::{self, Pen};
use crate::math::Real;
use crate::study::StudyError;
use crate::study::watch::Collapse;
use image::{Rgb, RgbImage};

const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [40; 3];
const STABLE: [u8; 3] = [205, 225, 215];
const REFUSED: [u8; 3] = [170; 3];
/// One a reason, in the order of `Collapse::ALL`; told apart by those who see few colours as well.
const COLOURS: [[u8; 3]; 9] = [
    [0, 0, 0],
    [213, 94, 0],
    [230, 159, 0],
    [0, 114, 178],
    [204, 121, 167],
    [240, 228, 66],
    [130, 0, 40],
    [90, 60, 150],
    [86, 180, 233],
];
/// Edge of a square, and distance of two [pixels].
const SQUARE: Real = 12.0;
const PITCH: Real = 15.0;
/// Squares begin beside the names of the modes [pixels].
const NAMES: Real = 130.0;
/// Blocks begin below the title and the key; so wide is one, and so high with its title [pixels].
const TOP: Real = 118.0;
const WIDTH: Real = 340.0;
const HEIGHT: Real = 34.0 + PITCH * Mode::ALL.len() as Real;
/// Blocks side by side.
const ACROSS: usize = 4;

fn colour(end: &End) -> [u8; 3] {
    match end {
        End::Stable => STABLE,
        End::Refused(_) => REFUSED,
        End::Collapsed(why) => {
            let known = Collapse::ALL.iter().position(|c| c == why);
            COLOURS[known.unwrap_or_default()]
        }
    }
}

/// PNG: a block for each viscosity ratio of the stirred pots and each family, a row a mode.
pub fn draw(fates: &[(Trial, Fate)]) -> Result<Vec<u8>, StudyError> {
    let mut blocks: Vec<(String, Vec<&(Trial, Fate)>)> = Vec::new();
    for fate in fates {
        let title = match fate.0.family {
            Family::Stirred => format!("stirred, viscosities 1:{}", fate.0.ratio),
            other => other.name(),
        };
        match blocks.iter_mut().find(|(name, _)| *name == title) {
            Some((_, members)) => members.push(fate),
            None => blocks.push((title, vec![fate])),
        }
    }
    let rows = blocks.len().div_ceil(ACROSS);
    let size = [
        WIDTH * ACROSS as Real + 20.0,
        TOP + HEIGHT * rows as Real + 10.0,
    ];
    let mut image = RgbImage::from_pixel(size[0] as u32, size[1] as u32, Rgb(PAPER));
    let pen = |size: Real| Pen {
        size,
        ink: INK,
        halo: PAPER,
    };
    pen(14.0).write(&mut image, "Runs that ask for trouble", 20.0, 30.0);
    key(&mut image, &pen(10.0));
    for (n, (title, members)) in blocks.iter().enumerate() {
        let left = 20.0 + WIDTH * (n % ACROSS) as Real;
        let top = TOP + HEIGHT * (n / ACROSS) as Real;
        pen(10.5).write(&mut image, title, left, top);
        for (row, mode) in Mode::ALL.into_iter().enumerate() {
            let y = top + 12.0 + PITCH * row as Real;
            pen(8.0).write(&mut image, &mode.name(), left, y + 9.5);
            let of_mode = members.iter().filter(|(trial, _)| trial.mode == mode);
            for (column, (_, fate)) in of_mode.enumerate() {
                let x = left + NAMES + PITCH * column as Real;
                square(&mut image, x, y, colour(&fate.end));
            }
        }
    }
    ink::png(&image).map_err(|error| StudyError::Scene(error.to_string()))
}

fn key(image: &mut RgbImage, pen: &Pen) {
    let ends = [End::Stable, End::Refused(String::new())].into_iter();
    let ends = ends.chain(Collapse::ALL.map(End::Collapsed));
    let (mut x, mut y) = (20.0, 48.0);
    for end in ends {
        let word = match &end {
            End::Stable => "stable".to_owned(),
            End::Refused(_) => "refused".to_owned(),
            End::Collapsed(why) => why.to_string(),
        };
        let width = pen.width(&word) + 44.0;
        if x + width > f64::from(image.width()) {
            (x, y) = (20.0, y + 20.0);
        }
        square(image, x, y, colour(&end));
        pen.write(image, &word, x + 19.0, y + 11.0);
        x += width;
    }
}

fn square(image: &mut RgbImage, x: Real, y: Real, colour: [u8; 3]) {
    for row in y as u32..(y + SQUARE) as u32 {
        for column in x as u32..(x + SQUARE) as u32 {
            image.put_pixel(column, row, Rgb(colour));
        }
    }
}

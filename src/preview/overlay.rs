//! What is written over a picture: a label, a key to the colours, a bar that shows the size.

use super::{Background, Colour, camera::View, colour::to_srgb};
use crate::ink::{Pen, blend};
use crate::math::Real;
use image::RgbImage;

/// What is written over a picture.
#[derive(Clone, Debug, Default)]
pub struct Lettering {
    /// A line of text at the top left, for example the time.
    pub label: Option<String>,
    /// The key to the colours, at the right.
    pub legend: Option<Legend>,
    /// Whether to draw a bar of a rounded length, true at the distance of the camera's target.
    pub scale_bar: bool,
}

/// A key to the colours.
#[derive(Clone, Debug)]
pub struct Legend {
    /// What the colours mean, with its unit.
    pub title: String,
    /// Value of the first colour.
    pub low: Real,
    /// Value of the last colour.
    pub high: Real,
    /// Colour of a position from 0 to 1.
    pub map: fn(Real) -> Colour,
    /// Position of a share of the way from low to high, both from 0 to 1.
    pub position: fn(Real) -> Real,
}

impl Legend {
    /// Position of a value.
    fn place(&self, value: Real) -> Real {
        (self.position)((value - self.low) / (self.high - self.low))
    }
}

/// Lowest ticks stand closer together than this share of the legend, whatever its scale.
const WIDEST_GAP: Real = 0.36;

pub(super) fn draw(
    image: &mut RgbImage,
    lettering: &Lettering,
    view: &View,
    background: Background,
) {
    let shorter = Real::from(image.width().min(image.height()));
    let (ink, halo) = background.ink();
    let pen = Pen {
        size: (shorter / 42.0).max(6.0),
        ink,
        halo,
    };
    if let Some(label) = &lettering.label {
        let large = Pen {
            size: 1.35 * pen.size,
            ..pen
        };
        let (x, y) = (2.0 * pen.size, 3.2 * pen.size);
        let bounds = [x, y - large.size, x + large.width(label), y];
        lay_plate(image, &large, bounds);
        large.write(image, label, x, y);
    }
    if let Some(legend) = &lettering.legend {
        draw_legend(image, legend, &pen);
    }
    if lettering.scale_bar {
        draw_scale_bar(image, view, &pen);
    }
}

/// A column of colour with ticks on its left, at the lower right: needles come from above.
fn draw_legend(image: &mut RgbImage, legend: &Legend, pen: &Pen) {
    let (width, height) = (Real::from(image.width()), Real::from(image.height()));
    let (thick, long) = (1.5 * pen.size, 0.42 * height);
    let (left, top) = (
        width - 2.0 * pen.size - thick,
        height - long - 2.0 * pen.size,
    );
    let (values, digits) = ticks(legend);
    // Adding 0 turns −0 into 0.
    let ticks: Vec<(String, Real)> = (values.into_iter())
        .map(|value| (format!("{:.digits$}", value + 0.0), legend.place(value)))
        .collect();
    let widest = ticks.iter().map(|(text, _)| pen.width(text));
    let side = left - 0.9 * pen.size - widest.fold(0.0, Real::max);
    let title = [
        width - 1.7 * pen.size - pen.width(&legend.title),
        top - 1.4 * pen.size,
    ];
    let above = [title[0], title[1] - pen.size, left + thick, title[1]];
    lay_plate(image, pen, above);
    lay_plate(image, pen, [side, top, left + thick, top + long]);
    for (text, place) in &ticks {
        let y = top + long * (1.0 - place);
        let x = left - 0.9 * pen.size - pen.width(text);
        pen.write(image, text, x, y + 0.5 * pen.size);
        pen.stroke(image, &[vec![[left - 0.45 * pen.size, y], [left, y]]]);
    }

    for row in 0..long as u32 {
        let colour = to_srgb(&(legend.map)(1.0 - (Real::from(row) + 0.5) / long));
        for column in 0..thick as u32 {
            let (x, y) = (left as u32 + column, top as u32 + row);
            if x < image.width() && y < image.height() {
                blend(image, x, y, colour, 1.0);
            }
        }
    }

    pen.write(image, &legend.title, title[0], title[1]);
}

/// Opacity of a plate, and how far it fades out, in sizes of the pen.
const PLATE: Real = 0.6;
const FADE: Real = 1.2;

/// Lays a plate of the halo's colour under what is to stand between left, top, right and bottom [pixels]: bone full of pores
/// is as restless as letters are.
fn lay_plate(image: &mut RgbImage, pen: &Pen, [left, top, right, bottom]: [Real; 4]) {
    let reach = FADE * pen.size;
    let pixels = |from: Real, to: Real, end: u32| {
        let [from, to] = [from - reach, to + reach].map(|v| v.clamp(0.0, Real::from(end)) as u32);
        from..to
    };
    for row in pixels(top, bottom, image.height()) {
        for column in pixels(left, right, image.width()) {
            let (x, y) = (Real::from(column) + 0.5, Real::from(row) + 0.5);
            let beside = (left - x).max(x - right).max(0.0);
            let beyond = (top - y).max(y - bottom).max(0.0);
            let outside = (beside * beside + beyond * beyond).sqrt();
            let share = (1.0 - outside / reach).max(0.0);
            blend(
                image,
                column,
                row,
                pen.halo,
                PLATE * share * share * (3.0 - 2.0 * share),
            );
        }
    }
}

/// At the bottom left; true for what is as far away as the target.
fn draw_scale_bar(image: &mut RgbImage, view: &View, pen: &Pen) {
    let pixels_a_metre = view.focal / view.distance;
    let longest = 0.22 * Real::from(image.width()) / pixels_a_metre;
    if !(longest.is_finite() && longest > 0.0) {
        return;
    }
    let (length, text) = scale_length(longest);
    let (left, y) = (2.0 * pen.size, Real::from(image.height()) - 2.2 * pen.size);
    let (right, end) = (left + length * pixels_a_metre, 0.4 * pen.size);
    let bar = [
        vec![[left, y], [right, y]],
        vec![[left, y - end], [left, y + end]],
        vec![[right, y - end], [right, y + end]],
    ];
    let x = (0.5 * (left + right - pen.width(&text))).max(left);
    let widest = right.max(x + pen.width(&text));
    lay_plate(image, pen, [left, y - 2.1 * pen.size, widest, y + end]);
    pen.stroke(image, &bar);
    pen.write(image, &text, x, y - 1.1 * pen.size);
}

/// The largest 1, 2 or 5 times a power of ten that is not above `limit`, and the power.
fn round_below(limit: Real) -> (Real, i32) {
    let power = libm::floor(libm::log10(limit) + 1e-12) as i32;
    let ten = libm::pow(10.0, Real::from(power));
    let leading = [5.0, 2.0]
        .into_iter()
        .find(|k| k * ten <= limit * (1.0 + 1e-12));
    (leading.unwrap_or(1.0) * ten, power)
}

/// Distance of ticks that cuts `range` into three to seven or so, and the decimals that it needs.
fn tick_step(range: Real) -> (Real, usize) {
    if !(range.is_finite() && range > 0.0) {
        return (1.0, 0);
    }
    let (step, power) = round_below(range / 3.0);
    (step, (-power).clamp(0, 9) as usize)
}

/// Values to be written beside a legend, and the decimals that they need: even steps, and where the scale spreads its
/// lower end out, smaller round ones between the lowest two.
fn ticks(legend: &Legend) -> (Vec<Real>, usize) {
    let (step, mut digits) = tick_step(legend.high - legend.low);
    let first = (legend.low / step - 1e-9).ceil();
    let mut ticks: Vec<Real> = (0..12)
        .map(|k| (first + Real::from(k)) * step)
        .take_while(|value| *value <= legend.high + 1e-9 * step)
        .collect();
    while let Some(&[low, next]) = ticks.first_chunk()
        && low == 0.0
        && legend.place(next) - legend.place(low) > WIDEST_GAP
    {
        let (between, power) = round_below(0.7 * next);
        ticks.insert(1, between);
        digits = digits.max((-power).clamp(0, 9) as usize);
    }
    (ticks, digits)
}

/// A rounded length [m] not above `limit` [m], and how to write it.
fn scale_length(limit: Real) -> (Real, String) {
    let (length, _) = round_below(limit);
    let (unit, name) = if length > 0.999 {
        (1.0, "m")
    } else if length > 0.999e-3 {
        (1e-3, "mm")
    } else {
        (1e-6, "µm")
    };
    let number = (length / unit * 1e6).round() / 1e6;
    (length, format!("{number} {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_ticks_are_round() {
        let written = |limit| scale_length(limit).1;
        assert_eq!(written(0.0137), "10 mm");
        assert_eq!(written(0.010), "10 mm");
        assert_eq!(written(0.0099), "5 mm");
        assert_eq!(written(0.000_31), "200 µm");
        assert_eq!(written(0.7), "500 mm");
        assert_eq!(written(2.3), "2 m");
        assert_eq!(tick_step(1.0), (0.2, 1));
        assert_eq!(tick_step(0.3), (0.1, 1));
        assert_eq!(tick_step(60.0), (20.0, 0));
    }

    #[test]
    fn a_scale_of_roots_has_ticks_in_its_lower_half() {
        let ticks = |high, position| {
            ticks(&Legend {
                title: String::new(),
                low: 0.0,
                high,
                map: |_| Colour::zeros(),
                position,
            })
        };
        let even = |share: Real| share;
        assert_eq!(ticks(60.0, even), (vec![0.0, 20.0, 40.0, 60.0], 0));
        let (at, digits) = ticks(3.4, Real::sqrt);
        assert_eq!((at, digits), (vec![0.0, 0.2, 0.5, 1.0, 2.0, 3.0], 1));
        let (at, _) = ticks(70.0, Real::sqrt);
        assert_eq!(at, [0.0, 5.0, 10.0, 20.0, 40.0, 60.0]);
        for high in [1.0, 1.7, 2.9, 4.2, 5.5, 9.9] {
            let (at, _) = ticks(high, Real::sqrt);
            let places: Vec<Real> = at.iter().map(|v| (v / high).sqrt()).collect();
            let apart = places.windows(2).map(|pair| pair[1] - pair[0]);
            assert!(apart.clone().fold(0.0, Real::max) < 0.4, "{at:?}");
            assert!(apart.fold(1.0, Real::min) > 0.06, "{at:?}");
        }
        assert_eq!(ticks(Real::NAN, even).0, Vec::<Real>::new());
    }
}

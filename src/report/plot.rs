//! Plots: points over curves, on linear or logarithmic axes, as a picture.

use super::axis::{Axis, Scale, TickLabel};
use crate::ink::{self, Pen, draw_lines};
use crate::math::Real;
use image::{Rgb, RgbImage};

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line through the points: something exact.
    Curve,
    /// A thin broken line: a target or a limit.
    Dashes,
    /// Dots: something computed.
    Dots,
    /// Dots joined by a thin line.
    Chain,
    /// Large rings: what is to be noticed.
    Rings,
}

/// Points that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What the key says; empty: not in the key.
    pub name: String,
    /// x and y; what is not finite is left out.
    pub points: Vec<[Real; 2]>,
    /// How it is drawn.
    pub look: Look,
    /// Which of the colours; series that belong together share one.
    pub colour: usize,
}

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// The axis to the right.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// Drawn in this order.
    pub series: Vec<Series>,
}

const WIDTH: u32 = 1080;
const HEIGHT: u32 = 720;
/// Height of a capital [pixels].
const LETTER: Real = 13.0;
const PAPER: [u8; 3] = [255; 3];
const INK: [u8; 3] = [40; 3];
const GRID: [u8; 3] = [222; 3];
const FAINT: [u8; 3] = [241; 3];
/// Told apart by those who see few colours as well (Okabe and Ito).
const COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [90, 60, 150],
    [80, 80, 80],
];

/// The field between the axes [pixels], y downwards.
struct Frame {
    left: Real,
    right: Real,
    top: Real,
    bottom: Real,
    x: Scale,
    y: Scale,
}

impl Frame {
    fn place(&self, point: &[Real; 2]) -> Option<[Real; 2]> {
        let (u, v) = (self.x.at(point[0])?, self.y.at(point[1])?);
        // Far outside is as good as just outside, and keeps the arithmetic sane.
        let (u, v) = (u.clamp(-3.0, 4.0), v.clamp(-3.0, 4.0));
        Some([
            self.left + u * (self.right - self.left),
            self.bottom - v * (self.bottom - self.top),
        ])
    }

    fn holds(&self, p: &[Real; 2]) -> bool {
        (self.left - 1.0..=self.right + 1.0).contains(&p[0])
            && (self.top - 1.0..=self.bottom + 1.0).contains(&p[1])
    }

    /// The part of a segment inside (Liang and Barsky).
    fn clipped(&self, a: [Real; 2], b: [Real; 2]) -> Option<Vec<[Real; 2]>> {
        let d = [b[0] - a[0], b[1] - a[1]];
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (step, room) in [
            (-d[0], a[0] - self.left),
            (d[0], self.right - a[0]),
            (-d[1], a[1] - self.top),
            (d[1], self.bottom - a[1]),
        ] {
            if step == 0.0 && room < 0.0 {
                return None;
            } else if step < 0.0 {
                from = from.max(room / step);
            } else if step > 0.0 {
                to = to.min(room / step);
            }
        }
        let at = |t: Real| [a[0] + d[0] * t, a[1] + d[1] * t];
        (from <= to).then(|| vec![at(from), at(to)])
    }
}

impl Plot {
    /// The picture.
    pub fn draw(&self) -> RgbImage {
        let mut image = RgbImage::from_pixel(WIDTH, HEIGHT, Rgb(PAPER));
        let pen = Pen {
            size: LETTER,
            ink: INK,
            halo: PAPER,
        };
        let (width, height) = (Real::from(WIDTH), Real::from(HEIGHT));
        let named = || self.series.iter().filter(|s| !s.name.is_empty());
        let key = named().map(|s| pen.width(&s.name)).fold(0.0, Real::max);
        let key = if key > 0.0 { key + 60.0 } else { 20.0 };
        let points = || self.series.iter().flat_map(|s| &s.points);
        let frame = Frame {
            left: 110.0,
            right: width - key - 15.0,
            top: 92.0,
            bottom: height - 80.0,
            x: self.x.fitted(points().map(|p| p[0])),
            y: self.y.fitted(points().map(|p| p[1])),
        };
        let title = Pen {
            size: 1.2 * LETTER,
            ..pen
        };
        title.write(&mut image, &self.title, frame.left, 34.0);
        draw_axes(&mut image, &frame, &pen, &self.x.label, &self.y.label);
        for series in &self.series {
            draw_series(&mut image, &frame, series);
        }
        for (row, series) in named().enumerate() {
            let y = frame.top + 14.0 + 26.0 * row as Real;
            let x = frame.right + 14.0;
            let sample = vec![[x, y - 5.0], [x + 30.0, y - 5.0]];
            let colour = COLOURS[series.colour % COLOURS.len()];
            match series.look {
                Look::Curve => draw_lines(&mut image, &[sample], 2.2, colour),
                Look::Dashes => draw_lines(&mut image, &dashes(&sample), 1.4, colour),
                Look::Chain => {
                    draw_lines(&mut image, &[sample], 1.2, colour);
                    dot(&mut image, [x + 15.0, y - 5.0], colour);
                }
                Look::Dots => dot(&mut image, [x + 15.0, y - 5.0], colour),
                Look::Rings => ring(&mut image, [x + 15.0, y - 5.0], colour),
            }
            pen.write(&mut image, &series.name, x + 40.0, y);
        }
        image
    }

    /// The picture as the bytes of a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        ink::png(&self.draw()).expect("a picture of this size fits into memory")
    }
}

fn draw_axes(image: &mut RgbImage, frame: &Frame, pen: &Pen, x_label: &str, y_label: &str) {
    let (left, right, top, bottom) = (frame.left, frame.right, frame.top, frame.bottom);
    for tick in frame.x.ticks() {
        let x = left + tick.at * (right - left);
        let faint = tick.label == TickLabel::Minor;
        draw_lines(
            image,
            &[vec![[x, top], [x, bottom]]],
            1.0,
            if faint { FAINT } else { GRID },
        );
        let width = label_width(pen, &tick.label);
        write_label(image, pen, &tick.label, x - 0.5 * width, bottom + 24.0);
    }
    for tick in frame.y.ticks() {
        let y = bottom - tick.at * (bottom - top);
        let faint = tick.label == TickLabel::Minor;
        draw_lines(
            image,
            &[vec![[left, y], [right, y]]],
            1.0,
            if faint { FAINT } else { GRID },
        );
        let width = label_width(pen, &tick.label);
        write_label(
            image,
            pen,
            &tick.label,
            left - 10.0 - width,
            y + 0.5 * LETTER,
        );
    }
    let corners = [
        [left, top],
        [right, top],
        [right, bottom],
        [left, bottom],
        [left, top],
    ];
    draw_lines(image, &[corners.to_vec()], 1.2, INK);
    let middle = 0.5 * (left + right);
    pen.write(
        image,
        x_label,
        middle - 0.5 * pen.width(x_label),
        bottom + 54.0,
    );
    // Upright lettering above the axis is read without turning the head.
    pen.write(image, y_label, 12.0, top - 14.0);
}

fn label_width(pen: &Pen, label: &TickLabel) -> Real {
    match label {
        TickLabel::Number(text) => pen.width(text),
        TickLabel::PowerOfTen(power) => pen.width("10") + raised(pen).width(&power.to_string()),
        TickLabel::Minor => 0.0,
    }
}

fn raised(pen: &Pen) -> Pen {
    Pen {
        size: 0.72 * pen.size,
        ..*pen
    }
}

fn write_label(image: &mut RgbImage, pen: &Pen, label: &TickLabel, x: Real, y: Real) {
    match label {
        TickLabel::Number(text) => pen.write(image, text, x, y),
        TickLabel::PowerOfTen(power) => {
            pen.write(image, "10", x, y);
            let shifted = x + pen.width("10");
            raised(pen).write(image, &power.to_string(), shifted, y - 0.6 * pen.size);
        }
        TickLabel::Minor => {}
    }
}

fn draw_series(image: &mut RgbImage, frame: &Frame, series: &Series) {
    let colour = COLOURS[series.colour % COLOURS.len()];
    let places: Vec<Option<[Real; 2]>> = series.points.iter().map(|p| frame.place(p)).collect();
    if !matches!(series.look, Look::Dots | Look::Rings) {
        let segments = places
            .windows(2)
            .filter_map(|w| frame.clipped(w[0]?, w[1]?));
        let lines: Vec<_> = segments.collect();
        match series.look {
            Look::Dashes => {
                let broken: Vec<_> = lines.iter().flat_map(|line| dashes(line)).collect();
                draw_lines(image, &broken, 1.4, colour);
            }
            Look::Chain => draw_lines(image, &lines, 1.2, colour),
            _ => draw_lines(image, &lines, 2.2, colour),
        }
    }
    for place in places.into_iter().flatten().filter(|p| frame.holds(p)) {
        match series.look {
            Look::Dots | Look::Chain => dot(image, place, colour),
            Look::Rings => ring(image, place, colour),
            Look::Curve | Look::Dashes => {}
        }
    }
}

fn dot(image: &mut RgbImage, at: [Real; 2], colour: [u8; 3]) {
    draw_lines(image, &[vec![at, at]], 9.0, PAPER);
    draw_lines(image, &[vec![at, at]], 7.0, colour);
}

fn ring(image: &mut RgbImage, at: [Real; 2], colour: [u8; 3]) {
    let turn = |k: i32| {
        let angle = Real::from(k) * std::f64::consts::TAU / 24.0;
        [
            at[0] + 8.0 * libm::cos(angle),
            at[1] + 8.0 * libm::sin(angle),
        ]
    };
    draw_lines(image, &[(0..=24).map(turn).collect()], 1.8, colour);
}

/// A segment as dashes of eight pixels.
fn dashes(line: &[[Real; 2]]) -> Vec<Vec<[Real; 2]>> {
    let (Some(a), Some(b)) = (line.first(), line.last()) else {
        return Vec::new();
    };
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let count = ((length / 16.0).round() as usize).max(1);
    let at = |t: Real| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
    (0..count)
        .map(|k| {
            let k = k as Real;
            vec![at(k / count as Real), at((k + 0.5) / count as Real)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(look: Look, points: Vec<[Real; 2]>) -> Plot {
        Plot {
            title: "A line".into(),
            x: Axis::linear("x").between(0.0, 1.0),
            y: Axis::log("y").between(0.1, 10.0),
            series: vec![Series {
                name: String::new(),
                points,
                look,
                colour: 1,
            }],
        }
    }

    fn coloured(image: &RgbImage) -> Vec<(u32, u32)> {
        let all = image.enumerate_pixels();
        all.filter(|(_, _, p)| p.0 == COLOURS[1])
            .map(|(x, y, _)| (x, y))
            .collect()
    }

    #[test]
    fn a_dot_stands_where_its_value_says() {
        // The middle of both axes: 0.5, and the geometric mean of 0.1 and 10.
        let pixels = coloured(&plot(Look::Dots, vec![[0.5, 1.0]]).draw());
        let n = pixels.len() as Real;
        let mean = |pick: fn(&(u32, u32)) -> u32| {
            pixels
                .iter()
                .map(|p| Real::from(pick(p)) + 0.5)
                .sum::<Real>()
                / n
        };
        let (right, bottom) = (1080.0 - 35.0, 640.0);
        assert!((mean(|p| p.0) - 0.5 * (110.0 + right)).abs() < 0.6);
        assert!((mean(|p| p.1) - 0.5 * (92.0 + bottom)).abs() < 0.6);
    }

    #[test]
    fn what_leaves_the_frame_is_cut_and_nan_is_passed_over() {
        for look in [
            Look::Curve,
            Look::Dashes,
            Look::Chain,
            Look::Dots,
            Look::Rings,
        ] {
            let wild = vec![
                [-5.0, 1e-9],
                [0.5, 1.0],
                [2.0, 1e300],
                [0.2, -1.0],
                [Real::NAN, 1.0],
            ];
            for (x, y) in coloured(&plot(look, wild).draw()) {
                assert!(
                    (108..=1048).contains(&x) && (58..=642).contains(&y),
                    "{look:?} {x} {y}"
                );
            }
        }
        plot(Look::Curve, Vec::new()).draw();
    }
}

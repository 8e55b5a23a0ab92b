//! Colours: linear RGB inside, sRGB outside, and the map for what the cement carries.

use crate::math::{Real, Vec3};
use std::sync::LazyLock;

/// Linear RGB, 1 is the brightest that a picture can show.
pub type Colour = Vec3;

/// Warm bone, as sRGB: the colour of a dried cortex.
pub const BONE: [u8; 3] = [232, 220, 198];
/// Bone where it is cut, as sRGB: darker and redder, so that a cut reads as one.
pub const CUT_BONE: [u8; 3] = [192, 132, 106];

/// Linear RGB of an sRGB colour.
pub fn from_srgb(colour: [u8; 3]) -> Colour {
    Vec3::from(colour.map(|byte| linear(Real::from(byte) / 255.0)))
}

/// sRGB of a linear colour, rounded to the nearest byte; what cannot be shown is cut off.
pub fn to_srgb(colour: &Colour) -> [u8; 3] {
    /// Linear values half way between bytes: a search among them is several times faster than a power.
    static BETWEEN: LazyLock<[Real; 255]> =
        LazyLock::new(|| core::array::from_fn(|byte| linear((byte as Real + 0.5) / 255.0)));
    let byte = |v: Real| BETWEEN.partition_point(|limit| *limit <= v) as u8;
    [byte(colour.x), byte(colour.y), byte(colour.z)]
}

fn linear(srgb: Real) -> Real {
    if srgb <= 0.04045 {
        srgb / 12.92
    } else {
        libm::pow((srgb + 0.055) / 1.055, 2.4)
    }
}

/// The colour of a fraction from 0 to 1: indigo, blue, teal, green, pale lime.
///
/// A helix in OKLab: lightness rises evenly while the hue turns evenly at one chroma. So equal steps of the fraction look
/// equally large, it reads the same in grey and for the colour-blind, and no part of it is the colour of bone.
pub fn scale(fraction: Real) -> Colour {
    const CHROMA: Real = 0.104;
    let t = if fraction.is_nan() {
        0.0
    } else {
        fraction.clamp(0.0, 1.0)
    };
    let hue = (285.0 - 155.0 * t).to_radians();
    from_oklab([
        0.36 + 0.52 * t,
        CHROMA * libm::cos(hue),
        CHROMA * libm::sin(hue),
    ])
}

/// Björn Ottosson's perceptual space: lightness, green to red, blue to yellow.
fn from_oklab([lightness, a, b]: [Real; 3]) -> Colour {
    let l = lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b;
    let m = lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b;
    let s = lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b;
    let (l, m, s) = (l * l * l, m * m * m, s * s * s);
    Colour::new(
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn to_oklab(c: &Colour) -> Vec3 {
        let l = libm::cbrt(0.412_221_470_8 * c.x + 0.536_332_536_3 * c.y + 0.051_445_992_9 * c.z);
        let m = libm::cbrt(0.211_903_498_2 * c.x + 0.680_699_545_1 * c.y + 0.107_396_956_6 * c.z);
        let s = libm::cbrt(0.088_302_461_9 * c.x + 0.281_718_837_6 * c.y + 0.629_978_700_5 * c.z);
        Vec3::new(
            0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
            1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
            0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
        )
    }

    #[test]
    fn srgb_bytes_survive_a_round_trip() {
        for byte in 0..=255 {
            assert_eq!(to_srgb(&from_srgb([byte; 3])), [byte; 3]);
        }
        assert_eq!(to_srgb(&Colour::repeat(-1.0)), [0; 3]);
        assert_eq!(to_srgb(&Colour::repeat(9.0)), [255; 3]);
        assert_eq!(to_srgb(&Colour::repeat(Real::NAN)), [0; 3]);
    }

    #[test]
    fn equal_steps_of_the_scale_look_equal_even_to_the_colour_blind() {
        // Deuteranopia (Machado, Oliveira, Fernandes 2009), in linear RGB.
        let blind = crate::math::Mat3::new(
            0.367_322, 0.860_646, -0.227_968, 0.280_085, 0.672_501, 0.047_413, -0.011_820,
            0.042_940, 0.968_881,
        );
        let steps = 50;
        let colour = |i: i32| scale(f64::from(i) / f64::from(steps));
        let apart = |a: Colour, b: Colour| (to_oklab(&a) - to_oklab(&b)).norm();
        let mean = (0..steps)
            .map(|i| apart(colour(i), colour(i + 1)))
            .sum::<f64>()
            / f64::from(steps);
        for i in 0..steps {
            let (here, next) = (colour(i), colour(i + 1));
            assert!(here.iter().all(|v| (0.0..=1.0).contains(v)), "{i}: {here}");
            assert!((apart(here, next) / mean - 1.0).abs() < 0.02);
            assert!(to_oklab(&next).x > to_oklab(&here).x);
            assert!(apart(blind * here, blind * next) > 0.6 * mean, "{i}");
        }
    }
}

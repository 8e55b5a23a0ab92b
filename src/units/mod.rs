//! Quantities as people write them, `"8 Pa.s"`, turned into SI at the door; a bare number is an error.
//!
//! One type a dimension; each reads from text only, and prints text that reads back to the same bits.

use crate::math::Real;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

mod dimension;
mod parse;

use dimension::Dimension;
pub use parse::UnitError;

/// One newtype a dimension: its noun, the SI unit that it prints, its exponents of m, kg, s, rad, an example.
macro_rules! quantities {
    ($($name:ident, $noun:literal, $si:literal, $exponents:expr, $example:literal;)*) => {
        $(
            #[doc = concat!("Holds ", $noun, " [", $si, "], written such as `\"", $example, "\"`.")]
            #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
            pub struct $name(Real);

            impl $name {
                const EXPECTED: &'static str =
                    concat!("expected ", $noun, " such as \"", $example, "\"");

                #[doc = concat!("From SI [", $si, "].")]
                pub const fn from_si(value: Real) -> Self {
                    Self(value)
                }

                #[doc = concat!("In SI [", $si, "].")]
                pub const fn si(self) -> Real {
                    self.0
                }
            }

            impl FromStr for $name {
                type Err = UnitError;

                fn from_str(text: &str) -> Result<Self, UnitError> {
                    parse::quantity(text, Dimension($exponents), $noun, Self::EXPECTED).map(Self)
                }
            }

            impl fmt::Display for $name {
                fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    write_si(f, self.0, $si)
                }
            }

            impl JsonSchema for $name {
                fn schema_name() -> Cow<'static, str> {
                    stringify!($name).into()
                }

                fn json_schema(_: &mut SchemaGenerator) -> Schema {
                    json_schema!({
                        "type": "string",
                        "description": concat!($noun, " with its unit"),
                        "examples": [$example],
                    })
                }
            }

            impl Serialize for $name {
                fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                    serializer.collect_str(self)
                }
            }

            impl<'de> Deserialize<'de> for $name {
                fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                    deserializer.deserialize_any(Quoted(Self::EXPECTED))?.parse().map_err(de::Error::custom)
                }
            }
        )*

        /// The dimensions that have a name, for messages.
        const NAMED: &[(Dimension, &str)] = &[$((Dimension($exponents), $noun)),*];
    };
}

quantities! {
    Length, "a length", "m", [1, 0, 0, 0], "0.5 mm";
    Time, "a time", "s", [0, 0, 1, 0], "0.05 s";
    Volume, "a volume", "m3", [3, 0, 0, 0], "2 ml";
    FlowRate, "a flow rate", "m3/s", [3, 0, -1, 0], "4 ml/min";
    Velocity, "a velocity", "m/s", [1, 0, -1, 0], "20 mm/s";
    Acceleration, "an acceleration", "m/s2", [1, 0, -2, 0], "9.81 m/s2";
    Density, "a density", "kg/m3", [-3, 1, 0, 0], "940 kg/m3";
    Viscosity, "a viscosity", "Pa.s", [-1, 1, -1, 0], "8 Pa.s";
    Diffusion, "a diffusion coefficient", "m2/s", [2, 0, -1, 0], "1e-7 m2/s";
    Pressure, "a pressure", "Pa", [-1, 1, -2, 0], "20 kPa";
    Angle, "an angle", "rad", [0, 0, 0, 1], "10 deg";
    Frequency, "a frequency", "1/s", [0, 0, -1, 0], "24 1/s";
    Rate, "a rate", "1/s", [0, 0, -1, 0], "0.5 1/s";
}

/// The shortest digits that read back to the same bits, with an exponent where zeros would pile up.
fn write_si(f: &mut fmt::Formatter<'_>, value: Real, unit: &str) -> fmt::Result {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        write!(f, "{value} {unit}")
    } else {
        write!(f, "{value:e} {unit}")
    }
}

/// Accepts text only, so that a number without a unit is refused with an example of what to write.
pub(crate) struct Quoted(pub &'static str);

impl de::Visitor<'_> for Quoted {
    type Value = String;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<String, E> {
        Ok(text.to_owned())
    }

    fn visit_i64<E: de::Error>(self, found: i64) -> Result<String, E> {
        Err(E::custom(format_args!("{}, found {found}", self.0)))
    }

    fn visit_u64<E: de::Error>(self, found: u64) -> Result<String, E> {
        Err(E::custom(format_args!("{}, found {found}", self.0)))
    }

    fn visit_f64<E: de::Error>(self, found: f64) -> Result<String, E> {
        Err(E::custom(format_args!("{}, found {found}", self.0)))
    }

    fn visit_bool<E: de::Error>(self, found: bool) -> Result<String, E> {
        Err(E::custom(format_args!("{}, found {found}", self.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn si<Q: FromStr<Err = UnitError>>(text: &str) -> Q {
        text.parse().unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn everyday_quantities_are_exact_in_si() {
        assert_eq!(si::<Length>("0.5 mm").si(), 0.5e-3);
        assert_eq!(si::<Length>("2.39mm").si(), 2.39e-3);
        assert_eq!(si::<Length>("12 µm").si(), 12e-6);
        assert_eq!(si::<Length>("12 μm").si(), 12e-6);
        assert_eq!(si::<Length>("12um").si(), 12e-6);
        assert_eq!(si::<Time>("0.05 s").si(), 0.05);
        assert_eq!(si::<Time>("1.5 min").si(), 90.0);
        assert_eq!(si::<Volume>("1.3 ml").si(), 1.3e-6);
        assert_eq!(si::<Volume>("8.06e-5 m³").si(), 8.06e-5);
        assert_eq!(si::<FlowRate>("0.2 ml/s").si(), 0.2e-6);
        assert_eq!(si::<FlowRate>("4 ml/min").si(), 4e-6 / 60.0);
        assert_eq!(si::<Velocity>("-20 mm/s").si(), -0.02);
        assert_eq!(si::<Acceleration>("-9.81 m/s2").si(), -9.81);
        assert_eq!(si::<Acceleration>("9.81 m/s^2").si(), 9.81);
        assert_eq!(si::<Acceleration>("9.81 m s-2").si(), 9.81);
        assert_eq!(si::<Density>("1.18 g/cm3").si(), 1180.0);
        assert_eq!(si::<Viscosity>("8 Pa.s").si(), 8.0);
        assert_eq!(si::<Viscosity>("8 Pa·s").si(), 8.0);
        assert_eq!(si::<Viscosity>("8 Pa s").si(), 8.0);
        assert_eq!(si::<Viscosity>("10 mPa*s").si(), 0.01);
        assert_eq!(si::<Viscosity>("1 cP").si(), 1e-3);
        assert_eq!(si::<Diffusion>("1e-7 m²/s").si(), 1e-7);
        assert_eq!(si::<Pressure>("20 kPa").si(), 20e3);
        assert_eq!(si::<Angle>("180 deg").si(), std::f64::consts::PI);
        assert_eq!(si::<Angle>("90°").si(), std::f64::consts::FRAC_PI_2);
        assert_eq!(si::<Frequency>("24 1/s").si(), 24.0);
        assert_eq!(si::<Frequency>("24 Hz").si(), 24.0);
        assert_eq!(si::<Rate>("0.5 /s").si(), 0.5);
    }

    #[test]
    fn errors_say_what_was_expected_and_what_was_found() {
        let message = |text: &str| text.parse::<Length>().unwrap_err().to_string();
        assert_eq!(
            message("4"),
            r#"expected a length such as "0.5 mm", found 4"#
        );
        assert_eq!(message("3 s"), r#""3 s" is a time, a length belongs here"#);
        assert_eq!(
            message("3 m2"),
            r#""3 m2" has the unit m2, a length belongs here"#
        );
        assert_eq!(message("3 parsec"), r#""3 parsec": unknown unit `parsec`"#);
        assert_eq!(
            message("mm"),
            r#"expected a length such as "0.5 mm", found "mm""#
        );
        assert!(message("1e400 mm").contains("too large"));
        for refused in [
            "nan m",
            "inf m",
            "",
            " ",
            "1 m/",
            "1 //s",
            "1 m0",
            "0x1 m",
            "1 m^99999",
        ] {
            assert!(refused.parse::<Length>().is_err(), "{refused}");
        }
    }

    #[test]
    fn only_text_is_read() {
        let error = serde_json::from_str::<Length>("4").unwrap_err().to_string();
        assert!(
            error.starts_with(r#"expected a length such as "0.5 mm", found 4"#),
            "{error}"
        );
        let error = serde_json::from_str::<Viscosity>("[1]")
            .unwrap_err()
            .to_string();
        assert!(error.contains("expected a viscosity such as"), "{error}");
    }

    proptest! {
        #[test]
        fn printed_quantities_read_back_to_the_same_bits(value in proptest::num::f64::NORMAL) {
            prop_assert_eq!(si::<Length>(&Length(value).to_string()).si().to_bits(), value.to_bits());
            prop_assert_eq!(si::<Viscosity>(&Viscosity(value).to_string()).si().to_bits(), value.to_bits());
            prop_assert_eq!(si::<FlowRate>(&FlowRate(value).to_string()).si().to_bits(), value.to_bits());
            prop_assert_eq!(si::<Rate>(&Rate(value).to_string()).si().to_bits(), value.to_bits());
        }

        #[test]
        fn no_text_panics_and_what_is_read_is_finite(text in ".*") {
            if let Ok(length) = text.parse::<Length>() {
                prop_assert!(length.si().is_finite());
            }
        }

        #[test]
        fn near_misses_do_not_panic(text in "[-+0-9.eE]{0,6} ?[µa-zA-Z0-9./*·²^ -]{0,8}") {
            if let Ok(rate) = text.parse::<FlowRate>() {
                prop_assert!(rate.si().is_finite());
            }
        }
    }
}

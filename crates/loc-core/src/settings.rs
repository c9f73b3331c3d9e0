//! Settings: one declaration gives a struct its fields, defaults, allowed values, builder functions
//! and form in a file.
//!
//! All numbers are in SI units and radians (REP 103), without a unit in the name. In a file an angle
//! may also be a text with its unit, `"6 deg"`; it is written back that way where that is exact.
//!
//! ```
//! loc_core::settings! {
//!     /// Settings of an example.
//!     #[derive(Copy)]
//!     pub struct TurnSettings {
//!         /// Largest turn \[rad\].
//!         #[serde(with = "loc_core::settings::angle")]
//!         pub turn: f64 = 0.1 => positive;
//!         /// Number of steps.
//!         pub steps: usize = 3 => at_least(1);
//!     }
//! }
//! let settings: TurnSettings = toml::from_str("turn = '90 deg'")?;
//! assert_eq!(settings, TurnSettings::default().turn(std::f64::consts::FRAC_PI_2));
//! assert_eq!(toml::to_string(&settings)?, "turn = \"90 deg\"\nsteps = 3\n");
//! assert!(settings.steps(0).check().is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

/// Declares a struct of settings.
///
/// Each field is `pub name: Type = default => rule;`. The struct gets [`Default`], a builder
/// function for every field, and `check`, which applies the rules in order. It is
/// `#[non_exhaustive]`: a new setting is no breaking change. With the crate's feature `serde` it can be read
/// and written; unknown keys are errors and missing ones have their defaults.
///
/// | rule | allowed |
/// |---|---|
/// | `any` | everything |
/// | `finite`, `positive`, `non_negative`, `probability` | numbers as by [`crate::error`] |
/// | `share` | above 0 and up to 1 |
/// | `at_least(n)` | numbers from n on |
/// | `within(a, b)` | numbers from a to b |
/// | `holds(text, test)` | what the test of the whole struct says, in words `text` |
/// | `check` | a value whose own `check` passes |
/// | `each` | the same for every value of an option |
/// | `each_positive` | no value, or one above 0 |
#[macro_export]
macro_rules! settings {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $(
                $(#[doc = $doc:literal])*
                $(#[serde($($serde:tt)*)])?
                pub $field:ident: $type:ty = $default:expr => $rule:ident $(($($arg:tt)*))?;
            )*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
        #[non_exhaustive]
        pub struct $name {
            $(
                $(#[doc = $doc])*
                $(#[cfg_attr(feature = "serde", serde($($serde)*))])?
                pub $field: $type,
            )*
        }

        impl Default for $name {
            fn default() -> Self {
                $name { $($field: $default,)* }
            }
        }

        impl $name {
            $(
                $(#[doc = $doc])*
                #[must_use]
                pub fn $field(mut self, $field: $type) -> Self {
                    self.$field = $field;
                    self
                }
            )*

            /// Checks every value.
            ///
            /// # Errors
            /// `loc_core::Error` with the name of the first setting that is not allowed.
            pub fn check(&self) -> $crate::Result<()> {
                $(
                    $crate::settings!(
                        @ $rule, self, self.$field,
                        concat!(stringify!($name), ".", stringify!($field)) $(, $($arg)*)?
                    );
                )*
                Ok(())
            }
        }
    };
    (@ any, $s:expr, $v:expr, $w:expr) => {};
    (@ finite, $s:expr, $v:expr, $w:expr) => { $crate::error::finite($w, $v)?; };
    (@ positive, $s:expr, $v:expr, $w:expr) => { $crate::error::positive($w, $v)?; };
    (@ non_negative, $s:expr, $v:expr, $w:expr) => { $crate::error::non_negative($w, $v)?; };
    (@ probability, $s:expr, $v:expr, $w:expr) => { $crate::error::probability($w, $v)?; };
    (@ share, $s:expr, $v:expr, $w:expr) => {
        $crate::error::in_range($w, "a number above 0 and up to 1", $v, |v| v > 0.0 && v <= 1.0)?;
    };
    (@ at_least, $s:expr, $v:expr, $w:expr, $min:expr) => {
        let expected = concat!("a number >= ", stringify!($min));
        $crate::error::in_range($w, expected, $crate::settings::number($v), |_| {
            $v >= $min && $crate::settings::number($v).is_finite()
        })?;
    };
    (@ within, $s:expr, $v:expr, $w:expr, $min:expr, $max:expr) => {
        let expected = concat!("a number from ", stringify!($min), " to ", stringify!($max));
        $crate::error::in_range($w, expected, $crate::settings::number($v), |_| {
            ($min..=$max).contains(&$v)
        })?;
    };
    (@ holds, $s:expr, $v:expr, $w:expr, $expected:expr, $test:expr) => {
        let test: fn(&Self) -> bool = $test;
        $crate::error::in_range($w, $expected, $crate::settings::number($v), |_| test($s))?;
    };
    (@ check, $s:expr, $v:expr, $w:expr) => { $v.check()?; };
    (@ each, $s:expr, $v:expr, $w:expr) => {
        if let Some(value) = &$v {
            value.check()?;
        }
    };
    (@ each_positive, $s:expr, $v:expr, $w:expr) => {
        if let Some(value) = $v {
            $crate::error::positive($w, value)?;
        }
    };
}

/// A number of any kind, for an error.
#[doc(hidden)]
pub fn number(value: impl Number) -> f64 {
    value.number()
}

/// The kinds of numbers that settings have.
#[doc(hidden)]
pub trait Number {
    fn number(self) -> f64;
}

macro_rules! numbers {
    ($($type:ty)*) => {
        $(impl Number for $type {
            fn number(self) -> f64 {
                self as f64
            }
        })*
    };
}
numbers!(f64 usize u32);

#[cfg(feature = "serde")]
pub use text::{angle, angle_per_m, angle_per_s, angle_per_s2, angle_per_sqrt_s, pose};

#[cfg(feature = "serde")]
mod text {
    use crate::Pose2;
    use serde::de::{Error, Unexpected, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::fmt;

    /// A setting that is an angle, or one divided by something.
    pub trait Angle: Sized {
        /// Writes it in the readable form.
        ///
        /// # Errors
        /// Those of the serializer.
        fn write<S: Serializer>(&self, per: &'static str, serializer: S)
        -> Result<S::Ok, S::Error>;

        /// Reads a number \[rad\] or a text.
        ///
        /// # Errors
        /// Another unit, and what the deserializer says.
        fn read<'de, D: Deserializer<'de>>(per: &'static str, from: D) -> Result<Self, D::Error>;
    }

    impl Angle for f64 {
        fn write<S: Serializer>(
            &self,
            per: &'static str,
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            match degrees(*self).filter(|_| serializer.is_human_readable()) {
                Some(degrees) => serializer.collect_str(&format_args!("{degrees} deg{per}")),
                None => serializer.serialize_f64(*self),
            }
        }

        fn read<'de, D: Deserializer<'de>>(per: &'static str, from: D) -> Result<Self, D::Error> {
            from.deserialize_any(Number { per })
        }
    }

    impl Angle for Option<f64> {
        fn write<S: Serializer>(
            &self,
            per: &'static str,
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            match self {
                Some(angle) => angle.write(per, serializer),
                None => serializer.serialize_none(),
            }
        }

        fn read<'de, D: Deserializer<'de>>(per: &'static str, from: D) -> Result<Self, D::Error> {
            f64::read(per, from).map(Some)
        }
    }

    /// An angle \[rad\] as a short number of degrees, where that is exact.
    fn degrees(angle: f64) -> Option<String> {
        let degrees = Some(angle.to_degrees()).filter(|degrees| degrees.is_finite())?;
        let texts = (0..=4).map(|digits| format!("{degrees:.digits$}"));
        texts.into_iter().find(|text| {
            text.parse().is_ok_and(|d: f64| d.to_radians().to_bits() == angle.to_bits())
        })
    }

    struct Number {
        per: &'static str,
    }

    impl Number {
        fn parse(&self, text: &str) -> Option<f64> {
            let unit = text.find(|c: char| c.is_ascii_alphabetic() && c != 'e' && c != 'E')?;
            let (number, unit) = text.split_at(unit);
            let number: f64 = number.trim().parse().ok()?;
            match unit.trim().strip_suffix(self.per)? {
                "deg" => Some(number.to_radians()),
                "rad" => Some(number),
                _ => None,
            }
        }
    }

    impl Visitor<'_> for Number {
        type Value = f64;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            let per = self.per;
            write!(formatter, "a number [rad{per}] or a text such as \"6 deg{per}\"")
        }

        fn visit_f64<E: Error>(self, angle: f64) -> Result<f64, E> {
            Ok(angle)
        }

        fn visit_i64<E: Error>(self, angle: i64) -> Result<f64, E> {
            Ok(angle as f64)
        }

        fn visit_u64<E: Error>(self, angle: u64) -> Result<f64, E> {
            Ok(angle as f64)
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<f64, E> {
            self.parse(text).ok_or_else(|| E::invalid_value(Unexpected::Str(text), &self))
        }
    }

    macro_rules! angles {
        ($($(#[$doc:meta])* $name:ident $per:literal;)*) => {
            $(
                $(#[$doc])*
                pub mod $name {
                    use super::Angle;
                    use serde::{Deserializer, Serializer};

                    /// Writes degrees as a text where that is exact, else radians.
                    ///
                    /// # Errors
                    /// Those of the serializer.
                    pub fn serialize<T: Angle, S: Serializer>(
                        angle: &T,
                        serializer: S,
                    ) -> Result<S::Ok, S::Error> {
                        angle.write($per, serializer)
                    }

                    /// Reads a number in radians, or a text with its unit.
                    ///
                    /// # Errors
                    /// Another unit, and what the deserializer says.
                    pub fn deserialize<'de, T: Angle, D: Deserializer<'de>>(
                        deserializer: D,
                    ) -> Result<T, D::Error> {
                        T::read($per, deserializer)
                    }
                }
            )*
        };
    }

    angles! {
        /// An angle, `"6 deg"`.
        angle "";
        /// A turn rate, `"6 deg/s"`.
        angle_per_s "/s";
        /// A turn acceleration, `"6 deg/s^2"`.
        angle_per_s2 "/s^2";
        /// A random walk of an angle, `"6 deg/sqrt(s)"`.
        angle_per_sqrt_s "/sqrt(s)";
        /// An angle for each metre, `"6 deg/m"`.
        angle_per_m "/m";
    }

    /// A pose or mounting, `{ x = 0.1, y = 0.0, theta = "90 deg" }`; what is left out is 0.
    pub mod pose {
        use super::{Deserialize, Deserializer, Pose2, Serialize, Serializer};

        /// A setting that is a pose, or may be one.
        pub trait Pose: Sized {
            /// The pose, if there is one.
            fn pose(&self) -> Option<Pose2>;

            /// The setting of a pose.
            fn of(pose: Pose2) -> Self;
        }

        impl Pose for Pose2 {
            fn pose(&self) -> Option<Pose2> {
                Some(*self)
            }

            fn of(pose: Pose2) -> Self {
                pose
            }
        }

        impl Pose for Option<Pose2> {
            fn pose(&self) -> Option<Pose2> {
                *self
            }

            fn of(pose: Pose2) -> Self {
                Some(pose)
            }
        }

        #[derive(Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Text {
            #[serde(default)]
            x: f64,
            #[serde(default)]
            y: f64,
            #[serde(default, with = "super::angle")]
            theta: f64,
        }

        /// Writes the heading as a text where that is exact.
        ///
        /// # Errors
        /// Those of the serializer.
        pub fn serialize<T: Pose, S: Serializer>(
            pose: &T,
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            match pose.pose() {
                Some(Pose2 { x, y, theta }) => Text { x, y, theta }.serialize(serializer),
                None => serializer.serialize_none(),
            }
        }

        /// Reads a pose; the heading is brought to (-pi, pi].
        ///
        /// # Errors
        /// Unknown keys, another unit, and what the deserializer says.
        pub fn deserialize<'de, T: Pose, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
            let Text { x, y, theta } = Text::deserialize(from)?;
            Ok(T::of(Pose2::new(x, y, theta)))
        }
    }
}

//! Parts of the filter that can be switched off in a settings file: `tempering = false`.
//!
//! TOML has no word for "none", and a key that is left out means the default. So such a part is
//! written as its table, or as `false` (also `"off"`) for none; `true` (also `"on"`) is the part
//! with its defaults.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;

pub(super) fn serialize<T, S>(part: &Option<T>, serializer: S) -> Result<S::Ok, S::Error>
where
    T: Serialize,
    S: Serializer,
{
    match part {
        Some(part) => part.serialize(serializer),
        None => serializer.serialize_bool(false),
    }
}

pub(super) fn deserialize<'de, T, D>(deserializer: D) -> Result<Option<T>, D::Error>
where
    T: Deserialize<'de> + Default,
    D: Deserializer<'de>,
{
    deserializer.deserialize_any(Part(PhantomData))
}

struct Part<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Default> Visitor<'de> for Part<T> {
    type Value = Option<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a table of settings, false (off) or true (the defaults)")
    }

    fn visit_bool<E: Error>(self, is_on: bool) -> Result<Option<T>, E> {
        Ok(is_on.then(T::default))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Option<T>, E> {
        match text {
            "off" => Ok(None),
            "on" => Ok(Some(T::default())),
            _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }

    /// What other formats than TOML write for nothing.
    fn visit_unit<E: Error>(self) -> Result<Option<T>, E> {
        Ok(None)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Option<T>, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map)).map(Some)
    }
}

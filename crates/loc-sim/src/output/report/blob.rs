//! Long lists of numbers inside a page: little-endian, deflated, in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write;

/// A list of numbers, as the page's script reads it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Blob {
    /// Type of a number: `u8`, `u16`, `i16`, `u32` or `f32`.
    kind: &'static str,
    /// The numbers.
    data: String,
}

impl Blob {
    pub(super) fn u8(numbers: &[u8]) -> Self {
        Blob::new("u8", numbers)
    }

    pub(super) fn u16(numbers: &[u16]) -> Self {
        Blob::new("u16", &bytes(numbers, u16::to_le_bytes))
    }

    pub(super) fn i16(numbers: &[i16]) -> Self {
        Blob::new("i16", &bytes(numbers, i16::to_le_bytes))
    }

    pub(super) fn u32(numbers: &[u32]) -> Self {
        Blob::new("u32", &bytes(numbers, u32::to_le_bytes))
    }

    pub(super) fn f32(numbers: &[f32]) -> Self {
        Blob::new("f32", &bytes(numbers, f32::to_le_bytes))
    }

    fn new(kind: &'static str, bytes: &[u8]) -> Self {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        // Writing to memory cannot fail.
        let _ = encoder.write_all(bytes);
        Blob { kind, data: STANDARD.encode(encoder.finish().unwrap_or_default()) }
    }
}

fn bytes<T: Copy, const N: usize>(numbers: &[T], to: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|number| to(*number)).collect()
}

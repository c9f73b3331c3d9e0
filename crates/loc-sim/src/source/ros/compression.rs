//! Chunks and messages that were packed: bz2 and lz4 in ROS 1, lz4 and zstd in ROS 2.

use super::input::MAX_BYTES;
use std::io::Read;

/// How a chunk is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Bz2,
    Lz4,
    Zstd,
}

/// What came out of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unpacked {
    /// All of it.
    Whole,
    /// What lies before the place at which the packed bytes make no sense or end.
    Part,
    /// More than was announced: the chunk is not what it claims.
    TooMuch,
}

impl Compression {
    /// By its name in a bag.
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "" | "none" => Some(Compression::None),
            "bz2" => Some(Compression::Bz2),
            "lz4" => Some(Compression::Lz4),
            "zstd" => Some(Compression::Zstd),
            _ => None,
        }
    }

    /// Unpacks bytes that announce `size` bytes of content; no more than that is held.
    pub(super) fn unpack(self, packed: &[u8], size: u64, into: &mut Vec<u8>) -> Unpacked {
        into.clear();
        if size > MAX_BYTES {
            return Unpacked::TooMuch;
        }
        match self {
            Compression::None => copy(packed, size, into),
            Compression::Bz2 => copy(bzip2::read::BzDecoder::new(packed), size, into),
            Compression::Lz4 => copy(lz4_flex::frame::FrameDecoder::new(packed), size, into),
            Compression::Zstd => match ruzstd::decoding::StreamingDecoder::new(packed) {
                Ok(decoder) => copy(decoder, size, into),
                Err(_) => Unpacked::Part,
            },
        }
    }
}

/// Copies at most `size` bytes and looks whether there are more.
fn copy(mut bytes: impl Read, size: u64, into: &mut Vec<u8>) -> Unpacked {
    // What was read before an error stays in the vector.
    if bytes.by_ref().take(size).read_to_end(into).is_err() || (into.len() as u64) < size {
        return Unpacked::Part;
    }
    match bytes.read(&mut [0]) {
        Ok(0) | Err(_) => Unpacked::Whole,
        Ok(_) => Unpacked::TooMuch,
    }
}

//! Chunks and messages that were packed: bz2 and lz4 in ROS 1, lz4 and zstd in ROS 2.

use crate::bytes::MAX_BYTES;
use std::io::Read;

/// How a chunk is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compression {
    None,
    Bz2,
    Lz4,
    Zstd,
}

/// What came out of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unpacked {
    /// All of it.
    Whole,
    /// What lies before the place at which the packed bytes make no sense or end.
    Part,
    /// More than was announced: the chunk is not what it claims.
    TooMuch,
}

impl Compression {
    /// By its name in a bag; none for one whose feature is off.
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "" | "none" => Some(Compression::None),
            "bz2" if cfg!(feature = "bz2") => Some(Compression::Bz2),
            "lz4" if cfg!(feature = "lz4") => Some(Compression::Lz4),
            "zstd" if cfg!(feature = "zstd") => Some(Compression::Zstd),
            _ => None,
        }
    }

    /// Unpacks bytes that announce `size` bytes of content; no more than that is kept.
    pub(crate) fn unpack(self, packed: &[u8], size: u64, into: &mut Vec<u8>) -> Unpacked {
        into.clear();
        if size > MAX_BYTES {
            return Unpacked::TooMuch;
        }
        match self {
            Compression::None => copy(packed, size, into),
            #[cfg(feature = "bz2")]
            Compression::Bz2 => copy(bzip2::read::BzDecoder::new(packed), size, into),
            #[cfg(feature = "lz4")]
            Compression::Lz4 => copy(lz4_flex::frame::FrameDecoder::new(packed), size, into),
            #[cfg(feature = "zstd")]
            Compression::Zstd => match ruzstd::decoding::StreamingDecoder::new(packed) {
                Ok(decoder) => copy(decoder, size, into),
                Err(_) => Unpacked::Part,
            },
            #[allow(unreachable_patterns, reason = "only without a feature")]
            _ => Unpacked::Part,
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

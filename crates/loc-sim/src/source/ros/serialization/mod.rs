//! The bytes of a message: the serialisation of ROS 1, and the CDR of ROS 2 in both byte orders.
//!
//! Both write the fields one after the other, a text or a sequence behind its length. CDR starts
//! with four bytes that say the byte order, aligns every number to its size and ends a text with a
//! zero byte; ROS 1 does neither, and its numbers are little-endian.

mod decode;
mod encode;

pub use decode::Decoder;
pub use encode::Encoder;

/// How bytes are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// Of ROS 1.
    Ros1,
    /// Of ROS 2, little-endian.
    Cdr,
    /// Of ROS 2, big-endian.
    CdrBigEndian,
}

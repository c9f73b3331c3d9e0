//! The bytes of a message: the serialisation of ROS 1, and the CDR of ROS 2 in both byte orders.
//!
//! Both write the fields one after the other, a text or a sequence behind its length. CDR starts
//! with four bytes that say the byte order, aligns every number to its size and ends a text with a
//! zero byte; ROS 1 does neither, and its numbers are little-endian.

use crate::bag::Encoding;
use crate::{Error, Result};

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

/// Takes fields from the front of a message. Nothing is believed: a length beyond the message is
/// an error, and no more is held than the message's own bytes.
///
/// ```
/// use loc_ros::{Decoder, Encoding};
/// // Little-endian CDR: one byte, three to align, a float, a text.
/// let bytes = [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0x80, 0x3f, 3, 0, 0, 0, b'o', b'k', 0];
/// let mut decoder = Decoder::new(&bytes, &Encoding::Cdr)?;
/// assert_eq!((decoder.u8("flag")?, decoder.f32("length")?), (7, 1.0));
/// assert_eq!(decoder.text("word")?, "ok");
/// # Ok::<(), loc_ros::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Decoder<'a> {
    bytes: &'a [u8],
    position: usize,
    dialect: Dialect,
}

impl<'a> Decoder<'a> {
    /// A decoder at the start of a message.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a representation other than plain CDR, and for an encoding that is
    /// neither CDR nor of ROS 1.
    pub fn new(bytes: &'a [u8], encoding: &Encoding) -> Result<Self> {
        let (bytes, dialect) = match encoding {
            Encoding::Ros1 => (bytes, Dialect::Ros1),
            Encoding::Other(name) => {
                return Err(malformed("encoding", "cdr or ros1", format!("`{name}`")));
            }
            Encoding::Cdr => match bytes.split_at_checked(4) {
                Some(([0, 0, ..], rest)) => (rest, Dialect::CdrBigEndian),
                Some(([0, 1, ..], rest)) => (rest, Dialect::Cdr),
                Some((head, _)) => {
                    let expected = "plain CDR, 00 00 or 00 01";
                    return Err(malformed("representation", expected, format!("{head:02x?}")));
                }
                None => {
                    let found = format!("{} bytes", bytes.len());
                    return Err(malformed("representation", "4 bytes", found));
                }
            },
        };
        Ok(Decoder { bytes, position: 0, dialect })
    }

    /// How the bytes are laid out.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Number of bytes that are left.
    pub fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.position)
    }

    fn align(&mut self, size: usize) {
        if self.dialect != Dialect::Ros1 {
            self.position = self.position.next_multiple_of(size);
        }
    }

    fn take(&mut self, what: &str, count: usize) -> Result<&'a [u8]> {
        let end = self.position.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.position..end));
        let taken = taken.ok_or_else(|| {
            malformed(
                what,
                &format!("{count} bytes"),
                format!("{} left in the message", self.left()),
            )
        })?;
        self.position += count;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        self.align(N);
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(what, N)?);
        if self.dialect == Dialect::CdrBigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// A byte.
    ///
    /// # Errors
    /// [`Error::Malformed`] where the message ends before; so for all that follow.
    pub fn u8(&mut self, what: &str) -> Result<u8> {
        self.number::<1>(what).map(|[byte]| byte)
    }

    /// A signed byte.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn i8(&mut self, what: &str) -> Result<i8> {
        self.number(what).map(i8::from_le_bytes)
    }

    /// A number of 16 bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u16(&mut self, what: &str) -> Result<u16> {
        self.number(what).map(u16::from_le_bytes)
    }

    /// A number of 32 bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn u32(&mut self, what: &str) -> Result<u32> {
        self.number(what).map(u32::from_le_bytes)
    }

    /// A signed number of 32 bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn i32(&mut self, what: &str) -> Result<i32> {
        self.number(what).map(i32::from_le_bytes)
    }

    /// A float of 32 bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f32(&mut self, what: &str) -> Result<f32> {
        self.number(what).map(f32::from_le_bytes)
    }

    /// A float of 64 bits.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f64(&mut self, what: &str) -> Result<f64> {
        self.number(what).map(f64::from_le_bytes)
    }

    /// `N` floats of 64 bits without a length.
    ///
    /// # Errors
    /// As [`Decoder::u8`].
    pub fn f64s<const N: usize>(&mut self, what: &str) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.f64(what)?;
        }
        Ok(numbers)
    }

    /// The length of a sequence whose elements have at least `size` bytes each.
    ///
    /// # Errors
    /// [`Error::Malformed`] where that is more than is left of the message.
    pub fn length(&mut self, what: &str, size: usize) -> Result<usize> {
        let count = self.u32(what)?;
        let fits = usize::try_from(count)
            .ok()
            .filter(|count| count.checked_mul(size).is_some_and(|bytes| bytes <= self.left()));
        fits.ok_or_else(|| {
            let left = self.left();
            malformed(what, &format!("elements that fit into {left} bytes"), format!("{count}"))
        })
    }

    /// Bytes behind their number.
    ///
    /// # Errors
    /// As [`Decoder::length`].
    pub fn bytes(&mut self, what: &str) -> Result<&'a [u8]> {
        let count = self.length(what, 1)?;
        self.take(what, count)
    }

    /// Floats of 32 bits behind their number.
    ///
    /// # Errors
    /// As [`Decoder::length`].
    pub fn f32s(&mut self, what: &str) -> Result<Vec<f32>> {
        let count = self.length(what, 4)?;
        if count > 0 {
            self.align(4);
        }
        let bytes = self.take(what, 4 * count)?;
        let (words, _) = bytes.as_chunks::<4>();
        Ok(match self.dialect {
            Dialect::CdrBigEndian => words.iter().map(|word| f32::from_be_bytes(*word)).collect(),
            _ => words.iter().map(|word| f32::from_le_bytes(*word)).collect(),
        })
    }

    /// A text; what is no UTF-8 in it is replaced.
    ///
    /// # Errors
    /// As [`Decoder::length`].
    pub fn text(&mut self, what: &str) -> Result<String> {
        let bytes = self.bytes(what)?;
        let bytes = match self.dialect {
            Dialect::Ros1 => bytes,
            _ => bytes.strip_suffix(&[0]).unwrap_or(bytes),
        };
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    /// A sequence, each element by `element`, which takes at least `size` bytes.
    ///
    /// # Errors
    /// As [`Decoder::length`], and what an element reports.
    pub fn sequence<T>(
        &mut self,
        what: &str,
        size: usize,
        mut element: impl FnMut(&mut Self) -> Result<T>,
    ) -> Result<Vec<T>> {
        let count = self.length(what, size)?;
        (0..count).map(|_| element(self)).collect()
    }
}

fn malformed(what: &str, expected: &str, found: String) -> Error {
    Error::Malformed { what: what.into(), expected: expected.into(), found }
}

/// Puts fields one after the other; the counterpart of [`Decoder`](super::Decoder).
///
/// ```
/// use loc_ros::{Dialect, Encoder};
/// let mut encoder = Encoder::new(Dialect::Cdr);
/// encoder.u8(7);
/// encoder.f32(1.0);
/// assert_eq!(encoder.finish(), [0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0x80, 0x3f]);
/// ```
#[derive(Debug, Clone)]
pub struct Encoder {
    bytes: Vec<u8>,
    /// Bytes before the first that counts for alignment.
    head: usize,
    dialect: Dialect,
}

impl Encoder {
    /// An empty message.
    pub fn new(dialect: Dialect) -> Self {
        let bytes = match dialect {
            Dialect::Ros1 => Vec::new(),
            Dialect::Cdr => vec![0, 1, 0, 0],
            Dialect::CdrBigEndian => vec![0, 0, 0, 0],
        };
        Encoder { head: bytes.len(), bytes, dialect }
    }

    /// How the bytes are laid out.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// The message.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    fn number<const N: usize>(&mut self, mut bytes: [u8; N]) {
        if self.dialect != Dialect::Ros1 {
            let aligned = (self.bytes.len() - self.head).next_multiple_of(N) + self.head;
            self.bytes.resize(aligned, 0);
        }
        if self.dialect == Dialect::CdrBigEndian {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    /// A byte.
    pub fn u8(&mut self, value: u8) {
        self.number([value]);
    }

    /// A signed byte.
    pub fn i8(&mut self, value: i8) {
        self.number(value.to_le_bytes());
    }

    /// A number of 16 bits.
    pub fn u16(&mut self, value: u16) {
        self.number(value.to_le_bytes());
    }

    /// A number of 32 bits.
    pub fn u32(&mut self, value: u32) {
        self.number(value.to_le_bytes());
    }

    /// A signed number of 32 bits.
    pub fn i32(&mut self, value: i32) {
        self.number(value.to_le_bytes());
    }

    /// A float of 32 bits.
    pub fn f32(&mut self, value: f32) {
        self.number(value.to_le_bytes());
    }

    /// A float of 64 bits.
    pub fn f64(&mut self, value: f64) {
        self.number(value.to_le_bytes());
    }

    /// Floats of 64 bits without a length.
    pub fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.f64(*value));
    }

    /// The length of a sequence; longer ones than fit into 32 bits no message has.
    pub fn length(&mut self, count: usize) {
        self.u32(u32::try_from(count).unwrap_or(u32::MAX));
    }

    /// Bytes behind their number.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.length(bytes.len());
        self.bytes.extend(bytes);
    }

    /// Floats of 32 bits behind their number.
    pub fn f32s(&mut self, values: &[f32]) {
        self.length(values.len());
        values.iter().for_each(|value| self.f32(*value));
    }

    /// A text.
    pub fn text(&mut self, text: &str) {
        match self.dialect {
            Dialect::Ros1 => self.bytes(text.as_bytes()),
            _ => {
                self.length(text.len() + 1);
                self.bytes.extend(text.as_bytes());
                self.bytes.push(0);
            }
        }
    }

    /// A sequence, each element by `element`.
    pub fn sequence<T>(&mut self, values: &[T], mut element: impl FnMut(&mut Self, &T)) {
        self.length(values.len());
        values.iter().for_each(|value| element(self, value));
    }
}

//! Writing fields.

use super::Dialect;

/// Puts fields one after the other; the counterpart of [`Decoder`](super::Decoder).
///
/// ```
/// use loc_sim::source::ros::{Dialect, Encoder};
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

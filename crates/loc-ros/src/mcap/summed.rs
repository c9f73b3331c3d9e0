//! A file whose bytes are summed as they are read, where its end says what they sum up to.

use super::MAGIC;
use super::closing::Closing;
use super::record::operation;
use crate::Result;
use crate::bytes::Fields;
use crate::bytes::Input;

/// Records that nobody needs are summed in pieces of so many bytes.
const PIECE: u64 = 1 << 16;

/// The file behind its magic number, record by record.
#[derive(Debug)]
pub(super) struct Summed {
    pub(super) input: Input,
    /// The checksum so far, and what it has to be at the end of the data.
    sum: Option<(crc32fast::Hasher, u32)>,
}

impl Summed {
    pub(super) fn new(input: Input, closing: &Closing) -> Self {
        let mut sum = crc32fast::Hasher::new();
        sum.update(&MAGIC);
        Summed { input, sum: closing.data_crc.map(|crc| (sum, crc)) }
    }

    /// Kind and length of the next record; `None` where the file ends before.
    pub(super) fn head(&mut self) -> Result<Option<(u8, u64)>> {
        let Some(head) = self.input.fixed::<9>()? else { return Ok(None) };
        let mut fields = Fields::new(&head);
        let kind = fields.u8().unwrap_or(0);
        if kind != operation::DATA_END {
            self.add(&head);
        }
        Ok(Some((kind, fields.u64().unwrap_or(0))))
    }

    /// Reads the content of a record, or what is there of it.
    pub(super) fn read(&mut self, what: &str, length: u64, into: &mut Vec<u8>) -> Result<usize> {
        let read = self.input.read(what, length, into)?;
        self.add(into);
        Ok(read)
    }

    /// Passes over the content of a record; false where the file ends before.
    pub(super) fn skip(&mut self, length: u64) -> Result<bool> {
        if self.sum.is_none() {
            return self.input.skip(length);
        }
        let (mut left, mut piece) = (length, Vec::new());
        while left > 0 {
            let read = self.read("a record", left.min(PIECE), &mut piece)?;
            if read == 0 {
                return Ok(false);
            }
            left -= read as u64;
        }
        Ok(true)
    }

    /// Whether the data, at their end, sum up to something else than they should.
    pub(super) fn is_damaged(&mut self) -> bool {
        self.sum.take().is_some_and(|(sum, crc)| sum.finalize() != crc)
    }

    fn add(&mut self, bytes: &[u8]) {
        if let Some((sum, _)) = &mut self.sum {
            sum.update(bytes);
        }
    }
}

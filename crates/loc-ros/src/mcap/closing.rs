//! What the end of a file says: the checksums of its data and of its summary.

use super::MAGIC;
use super::record::operation;
use crate::Result;
use crate::bytes::Fields;
use crate::bytes::Input;

/// Bytes of the footer record with the magic number behind it, and of the record before the
/// summary.
const FOOTER: usize = 9 + 20 + MAGIC.len();
const DATA_END: usize = 9 + 4;

/// Read in pieces of so many bytes.
const PIECE: u64 = 1 << 16;

/// The end of a file that was closed; nothing for another one.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Closing {
    /// Checksum of everything before the record that ends the data, where there is one.
    pub(super) data_crc: Option<u32>,
    /// Whether the summary is not the one that was written.
    pub(super) summary_is_damaged: bool,
}

impl Closing {
    /// Looks at the end of a file and comes back to where the input was.
    pub(super) fn of(input: &mut Input) -> Result<Self> {
        let here = input.position();
        let closing = look(input)?.unwrap_or_default();
        input.seek(here)?;
        Ok(closing)
    }
}

fn look(input: &mut Input) -> Result<Option<Closing>> {
    let length = input.length();
    let Some(footer) = length.checked_sub(FOOTER as u64) else { return Ok(None) };
    input.seek(footer)?;
    let Some(bytes) = input.fixed::<FOOTER>()? else { return Ok(None) };
    let mut fields = Fields::new(&bytes);
    let head = (fields.u8(), fields.u64());
    let (Some(summary), Some(_), Some(crc)) = (fields.u64(), fields.u64(), fields.u32()) else {
        return Ok(None);
    };
    if head != (Some(operation::FOOTER), Some(20)) || !bytes.ends_with(&MAGIC) {
        return Ok(None);
    }
    let summary = if summary == 0 { footer } else { summary };
    // The checksum ends before itself.
    let until = length - MAGIC.len() as u64 - 4;
    let summary_is_damaged = crc != 0 && checksum(input, summary, until)? != Some(crc);
    let data_crc = data_end(input, summary)?.filter(|crc| *crc != 0);
    Ok(Some(Closing { data_crc, summary_is_damaged }))
}

/// The checksum in the record that ends right before the summary.
fn data_end(input: &mut Input, summary: u64) -> Result<Option<u32>> {
    let start = summary.checked_sub(DATA_END as u64).filter(|_| summary <= input.length());
    let Some(start) = start else { return Ok(None) };
    input.seek(start)?;
    let Some(bytes) = input.fixed::<DATA_END>()? else { return Ok(None) };
    let mut fields = Fields::new(&bytes);
    let head = (fields.u8(), fields.u64());
    Ok(fields.u32().filter(|_| head == (Some(operation::DATA_END), Some(4))))
}

/// The checksum of a part of the file; `None` for one that is not there.
fn checksum(input: &mut Input, from: u64, until: u64) -> Result<Option<u32>> {
    if from > until {
        return Ok(None);
    }
    input.seek(from)?;
    let (mut sum, mut piece) = (crc32fast::Hasher::new(), Vec::new());
    while input.position() < until {
        let count = PIECE.min(until - input.position());
        if input.read("the summary", count, &mut piece)? == 0 {
            return Ok(None);
        }
        sum.update(&piece);
    }
    Ok(Some(sum.finalize()))
}

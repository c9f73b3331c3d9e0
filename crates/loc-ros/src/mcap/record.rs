//! The records of an MCAP file.

use crate::bag::{Channel, Encoding};
use crate::bytes::Fields;
use std::collections::BTreeMap;
use std::ops::Range;

/// Kinds of records.
pub(super) mod operation {
    pub(in super::super) const HEADER: u8 = 0x01;
    pub(in super::super) const FOOTER: u8 = 0x02;
    pub(in super::super) const SCHEMA: u8 = 0x03;
    pub(in super::super) const CHANNEL: u8 = 0x04;
    pub(in super::super) const MESSAGE: u8 = 0x05;
    pub(in super::super) const CHUNK: u8 = 0x06;
    pub(in super::super) const MESSAGE_INDEX: u8 = 0x07;
    pub(in super::super) const CHUNK_INDEX: u8 = 0x08;
    pub(in super::super) const STATISTICS: u8 = 0x0B;
    pub(in super::super) const SUMMARY_OFFSET: u8 = 0x0E;
    pub(in super::super) const DATA_END: u8 = 0x0F;
}

/// The record at the front: its kind and its content.
pub(super) fn record<'a>(fields: &mut Fields<'a>) -> Option<(u8, &'a [u8])> {
    let kind = fields.u8()?;
    let length = fields.u64()?;
    Some((kind, fields.take(length)?))
}

/// The head of a chunk.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chunk {
    /// Length of its records, unpacked.
    pub(super) size: u64,
    /// Checksum of its records, unpacked; 0 where there is none.
    pub(super) crc: u32,
    pub(super) compression: String,
    /// Where its records lie in the chunk; those that are there of a chunk that is cut off.
    pub(super) records: Range<usize>,
}

impl Chunk {
    pub(super) fn parse(content: &[u8]) -> Option<Self> {
        let mut fields = Fields::new(content);
        let (_start, _end) = (fields.u64()?, fields.u64()?);
        let (size, crc, compression) = (fields.u64()?, fields.u32()?, fields.text()?);
        let length = usize::try_from(fields.u64()?).ok()?;
        let start = content.len() - fields.len();
        let end = start.saturating_add(length).min(content.len());
        Some(Chunk { size, crc, compression, records: start..end })
    }
}

/// The schemas and channels of a file so far.
#[derive(Debug, Default)]
pub(super) struct Schemas {
    types: BTreeMap<u16, String>,
    channels: Vec<Channel>,
    indices: BTreeMap<u16, usize>,
    without_channel: u64,
}

impl Schemas {
    pub(super) fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// How many messages had no channel.
    pub(super) fn without_channel(&self) -> u64 {
        self.without_channel
    }

    /// Takes a record in. Of a message it gives the channel, the time and the length of its data,
    /// which are the last part of the record.
    pub(super) fn take(&mut self, kind: u8, content: &[u8]) -> Option<(usize, i64, usize)> {
        let mut fields = Fields::new(content);
        match kind {
            operation::MESSAGE => {
                let known = fields.u16().and_then(|id| self.indices.get(&id).copied());
                let _sequence = fields.u32()?;
                let (log_time, _publish_time) = (fields.u64()?, fields.u64()?);
                let Some(channel) = known else {
                    self.without_channel += 1;
                    return None;
                };
                return Some((channel, i64::try_from(log_time).ok()?, fields.len()));
            }
            operation::SCHEMA => {
                let (id, name) = (fields.u16()?, fields.text()?);
                self.types.insert(id, name);
            }
            operation::CHANNEL => {
                let (id, schema, topic) = (fields.u16()?, fields.u16()?, fields.text()?);
                let encoding = Encoding::named(&fields.text()?);
                let type_name = self.types.get(&schema).cloned().unwrap_or_default();
                let channel = Channel { topic, type_name, encoding };
                let known = self.channels.iter().position(|known| *known == channel);
                self.indices.insert(id, known.unwrap_or(self.channels.len()));
                if known.is_none() {
                    self.channels.push(channel);
                }
            }
            _ => {}
        }
        None
    }
}

//! MCAP files (<https://mcap.dev/spec>), read and written.
//!
//! Between two magic numbers the file is a row of records, each with its kind and its length.
//! Messages lie in chunks, packed or not, or directly in the file; schemas and channels say what
//! type and topic a message has. The reader takes the records as they come and needs no index, so
//! that it also reads a file that was never closed.

mod closing;
mod framing;
mod record;
mod summed;
mod write;

pub use write::McapWriter;

use crate::Result;
use crate::bag::{Channel, MessageReader, RawMessage};
use crate::bytes::Fields;
use crate::bytes::Input;
use crate::compression::{Compression, Unpacked};
use closing::Closing;
use record::{Chunk, Schemas, operation};
use std::io::{Read, Seek};
use std::ops::Range;
use std::path::Path;
use summed::Summed;

/// What an MCAP file starts and ends with.
pub(crate) const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];

/// An MCAP file, read from front to back.
#[derive(Debug)]
pub struct McapReader {
    file: Summed,
    schemas: Schemas,
    /// The record read last.
    record: Vec<u8>,
    /// The records of a chunk, unpacked; those of one that was not packed stay in `record`.
    unpacked: Vec<u8>,
    within: Within,
    ended: bool,
    bad_chunks: u64,
    notes: Vec<String>,
}

/// Where the records of the chunk that is being read lie.
#[derive(Debug, Clone, PartialEq)]
enum Within {
    Nothing,
    Record(Range<usize>),
    Unpacked(Range<usize>),
}

impl McapReader {
    /// Opens a file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`crate::Error::Recording`] for a file that is no MCAP.
    pub fn open(path: &Path) -> Result<Self> {
        McapReader::new(Input::open(path)?)
    }

    /// A file from anything that can be read; `path` is only named in errors.
    ///
    /// # Errors
    /// As [`McapReader::open`].
    pub fn read(path: &Path, bytes: impl Read + Seek + 'static) -> Result<Self> {
        McapReader::new(Input::new(path, bytes)?)
    }

    fn new(mut input: Input) -> Result<Self> {
        let magic: Option<[u8; 8]> = input.fixed()?;
        if magic.is_none_or(|magic| magic != MAGIC) {
            let found =
                magic.map_or("less".into(), |m| format!("{:?}", String::from_utf8_lossy(&m)));
            return Err(input.error_at(0, "the magic number of an MCAP file", found));
        }
        let closing = Closing::of(&mut input)?;
        let mut reader = McapReader {
            file: Summed::new(input, &closing),
            schemas: Schemas::default(),
            record: Vec::new(),
            unpacked: Vec::new(),
            within: Within::Nothing,
            ended: false,
            bad_chunks: 0,
            notes: Vec::new(),
        };
        if closing.summary_is_damaged {
            reader.note("its summary has a wrong CRC: it is damaged, and not needed".into());
        }
        Ok(reader)
    }

    /// The next message: its channel, its time and where its data lie.
    fn advance(&mut self) -> Result<Option<(usize, i64, Place)>> {
        loop {
            let (bytes, range, is_unpacked) = match &self.within {
                Within::Record(range) => (&self.record, range.clone(), false),
                Within::Unpacked(range) => (&self.unpacked, range.clone(), true),
                Within::Nothing => {
                    if self.ended {
                        return Ok(None);
                    }
                    if let Some(message) = self.next_of_file()? {
                        return Ok(Some(message));
                    }
                    continue;
                }
            };
            let Some(records) = bytes.get(range.clone()).filter(|records| !records.is_empty())
            else {
                self.within = Within::Nothing;
                continue;
            };
            let mut fields = Fields::new(records);
            let Some((kind, content)) = record::record(&mut fields) else {
                let left = records.len();
                self.within = Within::Nothing;
                self.note(format!("a chunk ends within a record: {left} bytes are left out"));
                continue;
            };
            let next = range.end - fields.len()..range.end;
            let message = self.schemas.take(kind, content);
            let end = next.start;
            self.within = if is_unpacked { Within::Unpacked(next) } else { Within::Record(next) };
            if let Some((channel, time, length)) = message {
                return Ok(Some((channel, time, Place { is_unpacked, range: end - length..end })));
            }
        }
    }

    /// Takes the next record of the file, which may be a message itself or open a chunk.
    fn next_of_file(&mut self) -> Result<Option<(usize, i64, Place)>> {
        let start = self.file.input.position();
        let Some((kind, length)) = self.file.head()? else {
            self.breaks_off(start);
            return Ok(None);
        };
        match kind {
            operation::DATA_END | operation::FOOTER => self.end_of_data(),
            operation::CHUNK => self.chunk(start, length)?,
            operation::SCHEMA | operation::CHANNEL | operation::MESSAGE => {
                let read = self.file.read("a record", length, &mut self.record)?;
                if (read as u64) < length {
                    self.breaks_off(start);
                    return Ok(None);
                }
                let message = self.schemas.take(kind, &self.record);
                let end = self.record.len();
                return Ok(message.map(|(channel, time, length)| {
                    let place = Place { is_unpacked: false, range: end - length..end };
                    (channel, time, place)
                }));
            }
            _ => {
                if !self.file.skip(length)? {
                    self.breaks_off(start);
                }
            }
        }
        Ok(None)
    }

    fn end_of_data(&mut self) {
        self.ended = true;
        // A chunk that is damaged says so itself.
        if self.file.is_damaged() && self.bad_chunks == 0 {
            self.note("its data have a wrong CRC: something in them is damaged".into());
        }
    }

    /// Reads a chunk and unpacks it.
    fn chunk(&mut self, start: u64, length: u64) -> Result<()> {
        let read = self.file.read("a chunk", length, &mut self.record)?;
        let is_whole = read as u64 == length;
        if !is_whole {
            self.breaks_off(start);
        }
        let Some(chunk) = Chunk::parse(&self.record) else {
            if !is_whole {
                return Ok(());
            }
            return Err(self.file.input.error_at(start, "a chunk", "fields that overrun it"));
        };
        let Some(compression) =
            Compression::named(&chunk.compression).filter(|c| *c != Compression::Bz2)
        else {
            let found = format!("`{}`", chunk.compression);
            return Err(self.file.input.error_at(
                start,
                "a chunk packed by lz4, zstd or not",
                found,
            ));
        };
        if compression == Compression::None {
            self.within = Within::Record(chunk.records.clone());
        } else {
            let packed = self.record.get(chunk.records.clone()).unwrap_or_default();
            match compression.unpack(packed, chunk.size, &mut self.unpacked) {
                Unpacked::Part if is_whole => {
                    let (got, size) = (self.unpacked.len(), chunk.size);
                    self.note(format!(
                        "the chunk at byte {start} unpacks to {got} of its {size} bytes"
                    ));
                }
                Unpacked::TooMuch => {
                    let found = format!("more than the {} that it claims", chunk.size);
                    let expected = "a chunk of the length in its header, at most 2^30 bytes";
                    return Err(self.file.input.error_at(start, expected, found));
                }
                Unpacked::Part | Unpacked::Whole => {}
            }
            self.within = Within::Unpacked(0..self.unpacked.len());
        }
        if is_whole && chunk.crc != 0 && crc32fast::hash(self.records()) != chunk.crc {
            self.bad_chunks += 1;
            self.within = Within::Nothing;
        }
        Ok(())
    }

    /// The records of the chunk that is being read.
    fn records(&self) -> &[u8] {
        match &self.within {
            Within::Nothing => &[],
            Within::Record(range) => self.record.get(range.clone()).unwrap_or_default(),
            Within::Unpacked(range) => self.unpacked.get(range.clone()).unwrap_or_default(),
        }
    }

    fn breaks_off(&mut self, start: u64) {
        let length = self.file.input.length();
        self.ended = true;
        self.note(match start {
            _ if start == length => format!("was not closed: read up to its end at byte {length}"),
            _ => format!(
                "breaks off within the record at byte {start} of {length}: read up to there"
            ),
        });
    }

    fn note(&mut self, note: String) {
        if !self.notes.contains(&note) && self.notes.len() < 20 {
            self.notes.push(note);
        }
    }
}

/// Where the data of a message lie.
#[derive(Debug, Clone, PartialEq)]
struct Place {
    is_unpacked: bool,
    range: Range<usize>,
}

impl MessageReader for McapReader {
    fn path(&self) -> &Path {
        self.file.input.path()
    }

    fn channels(&self) -> &[Channel] {
        self.schemas.channels()
    }

    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>> {
        let Some((channel, log_time, place)) = self.advance()? else { return Ok(None) };
        let bytes = if place.is_unpacked { &self.unpacked } else { &self.record };
        let data = bytes.get(place.range).unwrap_or_default();
        Ok(Some(RawMessage { channel, log_time, data }))
    }

    fn progress(&self) -> f64 {
        self.file.input.progress()
    }

    fn notes(&self) -> Vec<String> {
        let chunks = (self.bad_chunks > 0).then(|| {
            format!("{} chunks with a wrong CRC passed over: they are damaged", self.bad_chunks)
        });
        let count = self.schemas.without_channel();
        let messages = (count > 0)
            .then(|| format!("{count} messages of channels without a record passed over"));
        self.notes.iter().cloned().chain(chunks).chain(messages).collect()
    }
}

//! MCAP files (<https://mcap.dev/spec>), read and written through the crate [`mcap`](::mcap).
//!
//! Between two magic numbers the file is a row of records, each with its kind and its length.
//! Messages lie in chunks, packed or not, or directly in the file; schemas and channels say what
//! type and topic a message has. The reader takes the records as they come and needs no index, so
//! that it also reads a file that was never closed.

use crate::bag::{Channel, Encoding, MessageReader, RawMessage};
use crate::bytes::{Fields, Input, MAX_BYTES};
use crate::compression::{Compression, Unpacked};
use crate::messages::{Message, definition};
use crate::serialization::{Dialect, Encoder};
use crate::{Error, Result};
use mcap::records::{MessageHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, WriteOptions, Writer, parse_record};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// What an MCAP file starts and ends with.
pub(crate) const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];

/// Kind and length of a record \[bytes\].
const HEAD: u64 = 9;

/// The file is read in pieces of so many bytes, or of one record where that is longer.
const PIECE: usize = 1 << 16;

/// A record without messages that is longer than this is not read into memory \[bytes\].
const MAX_UNUSED: usize = 1 << 20;

/// An MCAP file, read from front to back.
///
/// Chunks whose checksum is wrong are passed over; of a file that breaks off, the last chunk is
/// read up to the break. Checksums of the data and of the summary are checked at the end.
pub struct McapReader {
    input: Input,
    records: LinearReader,
    /// Where the next record of the file starts.
    position: u64,
    channels: Channels,
    /// The record read last.
    record: Vec<u8>,
    /// The records of a chunk, unpacked; those of one that was not packed stay in `record`.
    unpacked: Vec<u8>,
    chunk: OpenChunk,
    /// The rest of the file is its summary.
    data_ended: bool,
    ended: bool,
    bad_chunks: u64,
    notes: Vec<String>,
}

/// Where the records of the chunk that is being read lie.
#[derive(Debug, Clone, PartialEq)]
enum OpenChunk {
    None,
    InRecord(Range<usize>),
    Unpacked(Range<usize>),
}

/// Where the data of a message lie.
#[derive(Debug, Clone, PartialEq)]
struct Place {
    is_unpacked: bool,
    range: Range<usize>,
}

impl McapReader {
    /// Opens a file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`Error::Recording`] for a file that is no MCAP.
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
        input.seek(0)?;
        let options = options().with_validate_data_section_crc(true);
        Ok(McapReader {
            input,
            records: LinearReader::new_with_options(options),
            position: MAGIC.len() as u64,
            channels: Channels::default(),
            record: Vec::new(),
            unpacked: Vec::new(),
            chunk: OpenChunk::None,
            data_ended: false,
            ended: false,
            bad_chunks: 0,
            notes: Vec::new(),
        })
    }

    /// The next message: its channel, its time and where its data lie.
    fn advance(&mut self) -> Result<Option<(usize, i64, Place)>> {
        loop {
            let (bytes, range, is_unpacked) = match &self.chunk {
                OpenChunk::InRecord(range) => (&self.record, range.clone(), false),
                OpenChunk::Unpacked(range) => (&self.unpacked, range.clone(), true),
                OpenChunk::None => {
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
                self.chunk = OpenChunk::None;
                continue;
            };
            let mut fields = Fields::new(records);
            let Some((kind, content)) = record(&mut fields) else {
                let left = records.len();
                self.chunk = OpenChunk::None;
                self.note(format!("a chunk ends within a record: {left} bytes are left out"));
                continue;
            };
            let next = range.end - fields.len()..range.end;
            let message = self.channels.update(kind, content);
            let end = next.start;
            self.chunk =
                if is_unpacked { OpenChunk::Unpacked(next) } else { OpenChunk::InRecord(next) };
            if let Some((channel, time, length)) = message {
                return Ok(Some((channel, time, Place { is_unpacked, range: end - length..end })));
            }
        }
    }

    /// Takes the next record of the file, which may be a message itself or open a chunk.
    fn next_of_file(&mut self) -> Result<Option<(usize, i64, Place)>> {
        let kind = match self.records.next_event() {
            Some(Ok(LinearReadEvent::ReadRequest(count))) => {
                if count > MAX_UNUSED && self.skip_unused()? {
                    return Ok(None);
                }
                // No more room than the file has bytes for, whatever a record claims.
                let left = usize::try_from(self.input.left()).unwrap_or(usize::MAX);
                let count = count.max(PIECE).min(left);
                let read = self.input.fill(self.records.insert(count))?;
                self.records.notify_read(read);
                return Ok(None);
            }
            Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                let start = self.position;
                self.position += HEAD + data.len() as u64;
                match opcode {
                    op::FOOTER => self.ended = true,
                    op::DATA_END => self.data_ended = true,
                    op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE if !self.data_ended => {
                        self.record.clear();
                        self.record.extend_from_slice(data);
                    }
                    _ => return Ok(None),
                }
                if opcode == op::CHUNK && !self.data_ended {
                    self.open_chunk(start, true)?;
                }
                opcode
            }
            Some(Err(error)) => {
                self.failed(&error)?;
                return Ok(None);
            }
            None => {
                self.ended = true;
                return Ok(None);
            }
        };
        if self.data_ended || !matches!(kind, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return Ok(None);
        }
        let message = self.channels.update(kind, &self.record);
        let end = self.record.len();
        Ok(message.map(|(channel, time, length)| {
            (channel, time, Place { is_unpacked: false, range: end - length..end })
        }))
    }

    /// What becomes of the file where its next record cannot be read.
    fn failed(&mut self, error: &McapError) -> Result<()> {
        match error {
            McapError::UnexpectedEof => self.breaks_off()?,
            McapError::BadDataCrc { .. } => {
                // A chunk that is damaged says so itself.
                if self.bad_chunks == 0 {
                    self.note("its data have a wrong CRC: something in them is damaged".into());
                }
                self.restart(self.position)?;
            }
            McapError::BadSummaryCrc { .. } => {
                self.note("its summary has a wrong CRC: it is damaged, and not needed".into());
                self.ended = true;
            }
            McapError::RecordTooLarge { .. } if self.data_ended => self.ended = true,
            McapError::RecordTooLarge { opcode, len } => match *opcode {
                op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE => {
                    let at = self.position + HEAD;
                    let expected = format!("a record of at most {MAX_BYTES} bytes");
                    return Err(self.input.error_at(at, expected, format!("{len} bytes")));
                }
                _ if self.skip_unused()? => {}
                _ => self.breaks_off()?,
            },
            _ => {
                if !self.data_ended {
                    let position = self.position;
                    self.note(format!("cannot be read from byte {position} on: {error}"));
                }
                self.ended = true;
            }
        }
        Ok(())
    }

    /// Jumps over the next record where it holds no messages (an attachment, as a rule) and the
    /// file has all of it.
    fn skip_unused(&mut self) -> Result<bool> {
        let here = self.input.position();
        self.input.seek(self.position)?;
        let head = self.input.fixed::<{ HEAD as usize }>()?;
        if let Some([kind, length @ ..]) = head {
            let next = (self.position + HEAD).checked_add(u64::from_le_bytes(length));
            let next = next.filter(|next| *next <= self.input.length());
            let is_used = matches!(
                kind,
                op::CHUNK | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::DATA_END | op::FOOTER
            );
            if let Some(next) = next.filter(|_| !is_used) {
                self.restart(next)?;
                return Ok(true);
            }
        }
        self.input.seek(here)?;
        Ok(false)
    }

    /// Goes on with the record at a place, without the checksum of the data.
    fn restart(&mut self, position: u64) -> Result<()> {
        self.input.seek(position)?;
        self.position = position;
        self.records = LinearReader::new_with_options(options().with_skip_start_magic(true));
        Ok(())
    }

    /// Notes that the file ends before its data do, and opens what there is of its last chunk.
    fn breaks_off(&mut self) -> Result<()> {
        self.ended = true;
        let (start, length) = (self.position, self.input.length());
        if self.data_ended {
            return Ok(());
        }
        if start == length {
            self.note(format!("was not closed: read up to its end at byte {length}"));
            return Ok(());
        }
        self.input.seek(start)?;
        let kind = self.input.fixed::<{ HEAD as usize }>()?.map(|[kind, ..]| kind);
        if matches!(kind, Some(op::DATA_END | op::FOOTER)) {
            return Ok(());
        }
        self.note(format!(
            "breaks off within the record at byte {start} of {length}: read up to there"
        ));
        if kind == Some(op::CHUNK) {
            let mut rest = std::mem::take(&mut self.record);
            self.input.read("a chunk", self.input.left(), &mut rest)?;
            self.record = rest;
            self.open_chunk(start, false)?;
        }
        Ok(())
    }

    /// Unpacks the chunk in `record`.
    fn open_chunk(&mut self, start: u64, is_whole: bool) -> Result<()> {
        let Some(chunk) = Chunk::parse(&self.record) else {
            if !is_whole {
                return Ok(());
            }
            return Err(self.input.error_at(start, "a chunk", "fields that overrun it"));
        };
        let Some(compression) =
            Compression::named(&chunk.compression).filter(|c| *c != Compression::Bz2)
        else {
            let found = format!("`{}`", chunk.compression);
            return Err(self.input.error_at(start, "a chunk packed by lz4, zstd or not", found));
        };
        if compression == Compression::None {
            self.chunk = OpenChunk::InRecord(chunk.records.clone());
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
                    return Err(self.input.error_at(start, expected, found));
                }
                Unpacked::Part | Unpacked::Whole => {}
            }
            self.chunk = OpenChunk::Unpacked(0..self.unpacked.len());
        }
        if is_whole && chunk.crc != 0 && crc32fast::hash(self.chunk_records()) != chunk.crc {
            self.bad_chunks += 1;
            self.chunk = OpenChunk::None;
        }
        Ok(())
    }

    /// The records of the chunk that is being read.
    fn chunk_records(&self) -> &[u8] {
        match &self.chunk {
            OpenChunk::None => &[],
            OpenChunk::InRecord(range) => self.record.get(range.clone()).unwrap_or_default(),
            OpenChunk::Unpacked(range) => self.unpacked.get(range.clone()).unwrap_or_default(),
        }
    }

    fn note(&mut self, note: String) {
        if !self.notes.contains(&note) && self.notes.len() < 20 {
            self.notes.push(note);
        }
    }
}

impl MessageReader for McapReader {
    fn path(&self) -> &Path {
        self.input.path()
    }

    fn channels(&self) -> &[Channel] {
        &self.channels.channels
    }

    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>> {
        let Some((channel, log_time, place)) = self.advance()? else { return Ok(None) };
        let bytes = if place.is_unpacked { &self.unpacked } else { &self.record };
        let data = bytes.get(place.range).unwrap_or_default();
        Ok(Some(RawMessage { channel, log_time, data }))
    }

    fn progress(&self) -> f64 {
        self.input.progress()
    }

    fn notes(&self) -> Vec<String> {
        let chunks = (self.bad_chunks > 0).then(|| {
            format!("{} chunks with a wrong CRC passed over: they are damaged", self.bad_chunks)
        });
        let count = self.channels.without_channel;
        let messages = (count > 0)
            .then(|| format!("{count} messages of channels without a record passed over"));
        self.notes.iter().cloned().chain(chunks).chain(messages).collect()
    }
}

impl std::fmt::Debug for McapReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (input, channels) = (&self.input, &self.channels.channels);
        f.debug_struct("McapReader").field("input", input).field("channels", channels).finish()
    }
}

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(MAX_BYTES as usize)
}

/// The record at the front: its kind and its content.
fn record<'a>(fields: &mut Fields<'a>) -> Option<(u8, &'a [u8])> {
    let kind = fields.u8()?;
    let length = fields.u64()?;
    Some((kind, fields.take(length)?))
}

/// The head of a chunk.
#[derive(Debug, Clone, PartialEq)]
struct Chunk {
    /// Length of its records, unpacked.
    size: u64,
    /// Checksum of its records, unpacked; 0 where there is none.
    crc: u32,
    compression: String,
    /// Where its records lie in the chunk; those that are there of a chunk that is cut off.
    records: Range<usize>,
}

impl Chunk {
    fn parse(content: &[u8]) -> Option<Self> {
        let mut fields = Fields::new(content);
        let (_start, _end) = (fields.u64()?, fields.u64()?);
        let (size, crc, compression) = (fields.u64()?, fields.u32()?, fields.text()?);
        let length = usize::try_from(fields.u64()?).ok()?;
        let start = content.len() - fields.len();
        let end = start.saturating_add(length).min(content.len());
        Some(Chunk { size, crc, compression, records: start..end })
    }
}

/// The channels of a file so far.
#[derive(Debug, Default)]
struct Channels {
    /// Names of types by schema.
    types: BTreeMap<u16, String>,
    channels: Vec<Channel>,
    indices: BTreeMap<u16, usize>,
    without_channel: u64,
}

impl Channels {
    /// Adds a schema or a channel. Of a message it gives the channel, the time and the length of
    /// its data, which are the last part of the record.
    fn update(&mut self, kind: u8, content: &[u8]) -> Option<(usize, i64, usize)> {
        if !matches!(kind, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            return None;
        }
        match parse_record(kind, content).ok()? {
            Record::Message { header, data } => {
                let Some(channel) = self.indices.get(&header.channel_id) else {
                    self.without_channel += 1;
                    return None;
                };
                return Some((*channel, i64::try_from(header.log_time).ok()?, data.len()));
            }
            Record::Schema { header, .. } => {
                self.types.insert(header.id, header.name);
            }
            Record::Channel(record) => {
                let type_name = self.types.get(&record.schema_id).cloned().unwrap_or_default();
                let encoding = Encoding::named(&record.message_encoding);
                let channel = Channel { topic: record.topic, type_name, encoding };
                let known = self.channels.iter().position(|known| *known == channel);
                self.indices.insert(record.id, known.unwrap_or(self.channels.len()));
                if known.is_none() {
                    self.channels.push(channel);
                }
            }
            _ => {}
        }
        None
    }
}

/// Writes messages of ROS 2 into an MCAP file of profile `ros2`, indexed and in chunks.
///
/// Every channel brings the definition of its type along, so that a viewer needs nothing else.
/// [`McapWriter::finish`] writes the index; a file without it can still be read.
pub struct McapWriter {
    path: PathBuf,
    file: Writer<BufWriter<File>>,
    /// Number, type and messages so far of each topic.
    channels: BTreeMap<String, (u16, String, u32)>,
    count: u64,
}

impl McapWriter {
    /// Makes a file, or empties the one there is.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).map_err(loc_core::Error::io(path))?;
        let options = WriteOptions::new()
            .compression(None)
            .profile("ros2")
            .library(concat!("loc-ros ", env!("CARGO_PKG_VERSION")))
            // A file that breaks off has whole chunks then, with their lengths.
            .disable_seeking(true);
        let file = options.create(BufWriter::new(file)).map_err(|error| failure(path, error))?;
        Ok(McapWriter { path: path.to_owned(), file, channels: BTreeMap::new(), count: 0 })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a message of a topic, with the time at which it became known \[ns\].
    ///
    /// # Errors
    /// [`loc_core::Error::Io`]; [`Error::Recording`] for a second type on a topic.
    pub fn write<M: Message>(&mut self, topic: &str, log_time: i64, message: &M) -> Result<()> {
        let mut encoder = Encoder::new(Dialect::Cdr);
        message.encode(&mut encoder);
        self.write_bytes(topic, M::NAME, log_time, &encoder.finish())
    }

    /// The same for a message as bytes in the serialization of ROS 2, of any type. The definition
    /// of a type that is not known here stays empty: its name has to do.
    ///
    /// # Errors
    /// As for [`write`](McapWriter::write).
    pub fn write_bytes(
        &mut self,
        topic: &str,
        type_name: &str,
        log_time: i64,
        bytes: &[u8],
    ) -> Result<()> {
        let (channel_id, sequence) = self.channel(topic, type_name)?;
        // Times before 1970 do not exist in the format.
        let log_time = u64::try_from(log_time).unwrap_or(0);
        let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
        let written = self.file.write_to_known_channel(&header, bytes);
        written.map_err(|error| failure(&self.path, error))?;
        self.count += 1;
        Ok(())
    }

    /// The channel of a topic, which is made with its schema where it is new, and the number of
    /// its next message.
    fn channel(&mut self, topic: &str, type_name: &str) -> Result<(u16, u32)> {
        if let Some((id, known, count)) = self.channels.get_mut(topic) {
            if known == type_name {
                let sequence = *count;
                *count = count.saturating_add(1);
                return Ok((*id, sequence));
            }
            return Err(Error::Recording {
                path: self.path.clone(),
                expected: format!("one type on {topic}, {known}"),
                found: type_name.into(),
            });
        }
        let schema = self.file.add_schema(type_name, "ros2msg", definition(type_name).as_bytes());
        let added =
            schema.and_then(|schema| self.file.add_channel(schema, topic, "cdr", &BTreeMap::new()));
        let id = added.map_err(|error| failure(&self.path, error))?;
        self.channels.insert(topic.to_owned(), (id, type_name.to_owned(), 1));
        Ok((id, 0))
    }

    /// Writes the index and closes the file; gives the number of messages.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn finish(mut self) -> Result<u64> {
        self.file.finish().map_err(|error| failure(&self.path, error))?;
        Ok(self.count)
    }
}

impl std::fmt::Debug for McapWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (path, channels) = (&self.path, &self.channels);
        f.debug_struct("McapWriter").field("path", path).field("channels", channels).finish()
    }
}

/// What went wrong while a file was written.
fn failure(path: &Path, error: McapError) -> Error {
    match error {
        McapError::Io(cause) => loc_core::Error::io(path)(cause).into(),
        other => Error::Recording {
            path: path.to_owned(),
            expected: "messages that fit into an MCAP file".into(),
            found: other.to_string(),
        },
    }
}

//! Bags of ROS 1, format 2.0 (<http://wiki.ros.org/Bags/Format/2.0>).
//!
//! After one line of text the file is a row of records, each a header of named fields and data.
//! Messages lie in chunks, packed or not; connections say which topic and type a message has. The
//! reader takes the records as they come and needs no index, so that it also reads a bag that was
//! never closed.

use crate::Result;
use crate::bag::{Channel, Encoding, MessageReader, RawMessage};
use crate::bytes::{Fields, Input, MAX_BYTES};
use crate::compression::{Compression, Unpacked};
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::ops::Range;
use std::path::Path;

/// The first line of a bag.
pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

mod operation {
    pub(super) const MESSAGE: u8 = 0x02;
    pub(super) const CHUNK: u8 = 0x05;
    pub(super) const CONNECTION: u8 = 0x07;
}

/// A bag of ROS 1, read from front to back.
#[derive(Debug)]
pub struct Bag1 {
    input: Input,
    channels: Vec<Channel>,
    /// Index of the channel of each connection.
    connections: BTreeMap<u32, usize>,
    /// Data of the record read last, and a chunk unpacked.
    packed: Vec<u8>,
    chunk: Vec<u8>,
    next_in_chunk: usize,
    ended: bool,
    without_header: u64,
    notes: Vec<String>,
}

impl Bag1 {
    /// Opens a bag.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`crate::Error::Recording`] for a file that is none.
    pub fn open(path: &Path) -> Result<Self> {
        Bag1::new(Input::open(path)?)
    }

    /// A bag from anything that can be read; `path` is only named in errors.
    ///
    /// # Errors
    /// As [`Bag1::open`].
    pub fn read(path: &Path, bytes: impl Read + Seek + 'static) -> Result<Self> {
        Bag1::new(Input::new(path, bytes)?)
    }

    fn new(mut input: Input) -> Result<Self> {
        let magic: Option<[u8; MAGIC.len()]> = input.fixed()?;
        if magic.is_none_or(|magic| magic != MAGIC) {
            let found =
                magic.map_or("less".into(), |m| format!("{:?}", String::from_utf8_lossy(&m)));
            return Err(input.error_at(0, "\"#ROSBAG V2.0\", a bag of ROS 1", found));
        }
        Ok(Bag1 {
            input,
            channels: Vec::new(),
            connections: BTreeMap::new(),
            packed: Vec::new(),
            chunk: Vec::new(),
            next_in_chunk: 0,
            ended: false,
            without_header: 0,
            notes: Vec::new(),
        })
    }

    /// Where the data of the next message lie in the chunk.
    fn advance(&mut self) -> Result<Option<(usize, i64, Range<usize>)>> {
        loop {
            while let Some((header, data)) = self.next_record_of_chunk() {
                match header.operation() {
                    Some(operation::MESSAGE) => {
                        let (connection, time) = (header.u32("conn"), header.time("time"));
                        let channel = connection.and_then(|c| self.connections.get(&c).copied());
                        match channel.zip(time) {
                            Some((channel, time)) => return Ok(Some((channel, time, data))),
                            None => self.without_header += 1,
                        }
                    }
                    Some(operation::CONNECTION) => {
                        let data = self.chunk.get(data).unwrap_or_default().to_vec();
                        self.connection(&header, &data);
                    }
                    _ => {}
                }
            }
            if self.ended || !self.next_chunk()? {
                self.ended = true;
                return Ok(None);
            }
        }
    }

    /// The record at the place in the chunk that is read next, and where its data lie.
    fn next_record_of_chunk(&mut self) -> Option<(Header, Range<usize>)> {
        let mut fields = Fields::new(self.chunk.get(self.next_in_chunk..)?);
        if fields.is_empty() {
            return None;
        }
        let Some((header, data)) = record(&mut fields) else {
            let left = self.chunk.len() - self.next_in_chunk;
            self.note(format!("a chunk ends within a record: its last {left} bytes are left out"));
            self.next_in_chunk = self.chunk.len();
            return None;
        };
        let end = self.chunk.len() - fields.len();
        self.next_in_chunk = end;
        Some((header, end - data.len()..end))
    }

    /// Reads records until there is a chunk; false at the end of the bag.
    fn next_chunk(&mut self) -> Result<bool> {
        loop {
            let start = self.input.position();
            if self.input.left() == 0 {
                return Ok(false);
            }
            let Some(header) = self.header()? else { return Ok(self.breaks_off(start)) };
            let Some(length) = self.input.fixed()?.map(u32::from_le_bytes) else {
                return Ok(self.breaks_off(start));
            };
            let wanted =
                matches!(header.operation(), Some(operation::CHUNK | operation::CONNECTION));
            if !wanted {
                if !self.input.skip(length.into())? {
                    return Ok(self.breaks_off(start));
                }
                continue;
            }
            let mut data = std::mem::take(&mut self.packed);
            let read = self.input.read("a record", length.into(), &mut data)?;
            let is_whole = read as u64 == u64::from(length);
            if header.operation() == Some(operation::CONNECTION) {
                self.connection(&header, &data);
            }
            self.packed = data;
            if !is_whole {
                self.breaks_off(start);
            }
            if header.operation() == Some(operation::CHUNK) {
                self.unpack(&header, start, is_whole)?;
                return Ok(true);
            }
            if !is_whole {
                return Ok(false);
            }
        }
    }

    /// The header of the next record; `None` where the file ends before.
    fn header(&mut self) -> Result<Option<Header>> {
        let start = self.input.position();
        let Some(length) = self.input.fixed()?.map(u32::from_le_bytes) else { return Ok(None) };
        if u64::from(length) > self.input.left() {
            return Ok(None);
        }
        let mut bytes = Vec::new();
        self.input.read("the header of a record", length.into(), &mut bytes)?;
        let header = Header::parse(&bytes);
        header.map(Some).ok_or_else(|| {
            self.input.error_at(start, "the header of a record", "fields that overrun it")
        })
    }

    fn unpack(&mut self, header: &Header, start: u64, is_whole: bool) -> Result<()> {
        self.next_in_chunk = 0;
        let name = header.text("compression").unwrap_or_default();
        let Some(compression) = Compression::named(&name).filter(|c| *c != Compression::Zstd)
        else {
            let found = format!("`{name}`");
            return Err(self.input.error_at(start, "a chunk packed by none, bz2 or lz4", found));
        };
        let Some(size) = header.u32("size") else {
            return Err(self.input.error_at(start, "a chunk with its size", "none"));
        };
        match compression.unpack(&self.packed, size.into(), &mut self.chunk) {
            Unpacked::Whole => {}
            Unpacked::Part if !is_whole => {}
            Unpacked::Part => {
                let got = self.chunk.len();
                self.note(format!(
                    "the {name} chunk at byte {start} unpacks to {got} of its {size} bytes"
                ));
            }
            Unpacked::TooMuch => {
                let [expected, found] = match u64::from(size) > MAX_BYTES {
                    true => [format!("a chunk of at most {MAX_BYTES} bytes"), size.to_string()],
                    false => {
                        [format!("a chunk of {size} bytes, as its header says"), "more".into()]
                    }
                };
                return Err(self.input.error_at(start, expected, found));
            }
        }
        Ok(())
    }

    fn connection(&mut self, header: &Header, data: &[u8]) {
        let Some(number) = header.u32("conn") else { return };
        let own = Header::parse(data);
        let topic = own.as_ref().and_then(|own| own.text("topic")).or(header.text("topic"));
        let type_name = own.as_ref().and_then(|own| own.text("type"));
        let (Some(topic), Some(type_name)) = (topic, type_name) else { return };
        let channel = Channel { topic, type_name, encoding: Encoding::Ros1 };
        let known = self.channels.iter().position(|known| *known == channel);
        let index = known.unwrap_or(self.channels.len());
        if known.is_none() {
            self.channels.push(channel);
        }
        self.connections.entry(number).or_insert(index);
    }

    /// Notes that the file ends within the record that starts here.
    fn breaks_off(&mut self, start: u64) -> bool {
        let length = self.input.length();
        self.note(format!(
            "breaks off within the record at byte {start} of {length}: read up to there"
        ));
        self.ended = true;
        false
    }

    fn note(&mut self, note: String) {
        if !self.notes.contains(&note) && self.notes.len() < 20 {
            self.notes.push(note);
        }
    }
}

impl MessageReader for Bag1 {
    fn path(&self) -> &Path {
        self.input.path()
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>> {
        let Some((channel, log_time, data)) = self.advance()? else { return Ok(None) };
        let data = self.chunk.get(data).unwrap_or_default();
        Ok(Some(RawMessage { channel, log_time, data }))
    }

    fn progress(&self) -> f64 {
        self.input.progress()
    }

    fn notes(&self) -> Vec<String> {
        let count = self.without_header;
        let without = (count > 0)
            .then(|| format!("{count} messages of connections without a header passed over"));
        self.notes.iter().cloned().chain(without).collect()
    }
}

/// The named fields of a record.
#[derive(Debug, Clone, PartialEq, Default)]
struct Header {
    fields: Vec<(Vec<u8>, Vec<u8>)>,
}

impl Header {
    /// Fields of the form `length name=value`; `None` where one overruns the rest.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let (mut rest, mut fields) = (Fields::new(bytes), Vec::new());
        while !rest.is_empty() {
            let field = rest.block()?;
            let equals = field.iter().position(|byte| *byte == b'=')?;
            fields.push((field[..equals].to_vec(), field[equals + 1..].to_vec()));
        }
        Some(Header { fields })
    }

    fn value(&self, name: &str) -> Option<&[u8]> {
        let found = self.fields.iter().find(|(known, _)| known == name.as_bytes());
        found.map(|(_, value)| value.as_slice())
    }

    fn text(&self, name: &str) -> Option<String> {
        self.value(name).map(|value| String::from_utf8_lossy(value).into_owned())
    }

    fn u32(&self, name: &str) -> Option<u32> {
        self.value(name)?.try_into().ok().map(u32::from_le_bytes)
    }

    /// A time as seconds and nanoseconds \[ns\].
    fn time(&self, name: &str) -> Option<i64> {
        let mut fields = Fields::new(self.value(name)?);
        let (seconds, nanoseconds) = (fields.u32()?, fields.u32()?);
        Some(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds))
    }

    /// What kind of record it is.
    fn operation(&self) -> Option<u8> {
        match self.value("op")? {
            [operation] => Some(*operation),
            _ => None,
        }
    }
}

/// The record at the front, header and data.
fn record<'a>(fields: &mut Fields<'a>) -> Option<(Header, &'a [u8])> {
    let header = Header::parse(fields.block()?)?;
    Some((header, fields.block()?))
}

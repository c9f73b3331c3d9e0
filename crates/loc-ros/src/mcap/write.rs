//! Writing an MCAP file, indexed and in chunks.

use super::MAGIC;
use super::framing::{ChunkIndex, framed, map, pairs, text, widen};
use super::record::operation;
use crate::Result;
use crate::messages::{Message, definition};
use crate::serialization::{Dialect, Encoder};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A chunk is closed once it holds this much \[bytes\].
const CHUNK: usize = 1 << 20;

/// Writes messages of ROS 2 into an MCAP file of profile `ros2`.
///
/// Every channel brings the definition of its type along, so that a viewer needs nothing else.
/// [`McapWriter::finish`] writes the index; a file without it can still be read.
#[derive(Debug)]
pub struct McapWriter {
    path: PathBuf,
    file: BufWriter<File>,
    position: u64,
    /// Checksum of what was written since the start, then since the start of the summary.
    crc: crc32fast::Hasher,
    schemas: BTreeMap<String, u16>,
    channels: BTreeMap<String, (u16, String)>,
    /// Schemas and channels, again for the end of the file.
    summary: [Vec<u8>; 2],
    chunk: Vec<u8>,
    chunk_times: Option<(u64, u64)>,
    chunk_index: BTreeMap<u16, Vec<(u64, u64)>>,
    indices: Vec<ChunkIndex>,
    counts: BTreeMap<u16, u64>,
    times: Option<(u64, u64)>,
}

impl McapWriter {
    /// Makes a file, or empties the one there is.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).map_err(loc_core::Error::io(path))?;
        let mut writer = McapWriter {
            path: path.to_owned(),
            file: BufWriter::new(file),
            position: 0,
            crc: crc32fast::Hasher::new(),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            summary: Default::default(),
            chunk: Vec::new(),
            chunk_times: None,
            chunk_index: BTreeMap::new(),
            indices: Vec::new(),
            counts: BTreeMap::new(),
            times: None,
        };
        let mut header = Vec::new();
        text(&mut header, "ros2");
        text(&mut header, concat!("loc-sim ", env!("CARGO_PKG_VERSION")));
        writer.put(&MAGIC)?;
        writer.put(&framed(operation::HEADER, &header))?;
        Ok(writer)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds a message of a topic, with the time at which it became known \[ns\].
    ///
    /// # Errors
    /// [`loc_core::Error::Io`]; [`crate::Error::Recording`] for a second type on a topic.
    pub fn write<M: Message>(&mut self, topic: &str, log_time: i64, message: &M) -> Result<()> {
        let mut encoder = Encoder::new(Dialect::Cdr);
        message.encode(&mut encoder);
        self.write_bytes(topic, M::NAME, log_time, &encoder.finish())
    }

    /// The same for a message as bytes in the serialisation of ROS 2, of any type. The definition
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
        let channel = self.channel(topic, type_name)?;
        // Times before 1970 do not exist in the format.
        let time = u64::try_from(log_time).unwrap_or(0);
        let count = self.counts.entry(channel).or_insert(0);
        let mut content = Vec::new();
        content.extend(channel.to_le_bytes());
        content.extend(u32::try_from(*count).unwrap_or(u32::MAX).to_le_bytes());
        *count += 1;
        content.extend(time.to_le_bytes());
        content.extend(time.to_le_bytes());
        content.extend(bytes);
        self.chunk_index.entry(channel).or_default().push((time, self.chunk.len() as u64));
        self.chunk.extend(framed(operation::MESSAGE, &content));
        widen(&mut self.chunk_times, time);
        widen(&mut self.times, time);
        if self.chunk.len() >= CHUNK { self.close_chunk() } else { Ok(()) }
    }

    /// The channel of a topic, which is made with its schema where it is new.
    fn channel(&mut self, topic: &str, type_name: &str) -> Result<u16> {
        if let Some((id, known)) = self.channels.get(topic) {
            if known == type_name {
                return Ok(*id);
            }
            return Err(crate::Error::Recording {
                path: self.path.clone(),
                expected: format!("one type on {topic}, {known}"),
                found: type_name.into(),
            });
        }
        let schema = match self.schemas.get(type_name) {
            Some(id) => *id,
            None => self.schema(type_name),
        };
        let id = u16::try_from(self.channels.len()).unwrap_or(u16::MAX);
        let mut content = Vec::new();
        content.extend(id.to_le_bytes());
        content.extend(schema.to_le_bytes());
        text(&mut content, topic);
        text(&mut content, "cdr");
        content.extend(0_u32.to_le_bytes());
        let record = framed(operation::CHANNEL, &content);
        self.chunk.extend(&record);
        self.summary[1].extend(record);
        self.channels.insert(topic.to_owned(), (id, type_name.to_owned()));
        Ok(id)
    }

    fn schema(&mut self, type_name: &str) -> u16 {
        // 0 means "no schema".
        let id = u16::try_from(self.schemas.len() + 1).unwrap_or(u16::MAX);
        let mut content = Vec::new();
        content.extend(id.to_le_bytes());
        text(&mut content, type_name);
        text(&mut content, "ros2msg");
        text(&mut content, &definition(type_name));
        let record = framed(operation::SCHEMA, &content);
        self.chunk.extend(&record);
        self.summary[0].extend(record);
        self.schemas.insert(type_name.to_owned(), id);
        id
    }

    fn close_chunk(&mut self) -> Result<()> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        let records = std::mem::take(&mut self.chunk);
        let times = self.chunk_times.take().unwrap_or((0, 0));
        let mut content = Vec::with_capacity(records.len() + 64);
        content.extend(times.0.to_le_bytes());
        content.extend(times.1.to_le_bytes());
        content.extend((records.len() as u64).to_le_bytes());
        content.extend(crc32fast::hash(&records).to_le_bytes());
        text(&mut content, "");
        content.extend((records.len() as u64).to_le_bytes());
        content.extend(&records);
        let start = self.position;
        self.put(&framed(operation::CHUNK, &content))?;
        let length = self.position - start;
        let first_index = self.position;
        let mut message_indices = Vec::new();
        for (channel, entries) in std::mem::take(&mut self.chunk_index) {
            message_indices.push((channel, self.position));
            let mut index = channel.to_le_bytes().to_vec();
            pairs(&mut index, &entries);
            self.put(&framed(operation::MESSAGE_INDEX, &index))?;
        }
        self.indices.push(ChunkIndex {
            times,
            start,
            length,
            message_indices,
            message_index_length: self.position - first_index,
            size: records.len() as u64,
        });
        Ok(())
    }

    /// Writes the index and closes the file; gives the number of messages.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn finish(mut self) -> Result<u64> {
        self.close_chunk()?;
        let crc = std::mem::take(&mut self.crc).finalize();
        self.put(&framed(operation::DATA_END, &crc.to_le_bytes()))?;
        self.crc = crc32fast::Hasher::new();
        let summary_start = self.position;
        let mut groups = Vec::new();
        let [schemas, channels] = std::mem::take(&mut self.summary);
        groups.push((operation::SCHEMA, self.position));
        self.put(&schemas)?;
        groups.push((operation::CHANNEL, self.position));
        self.put(&channels)?;
        groups.push((operation::CHUNK_INDEX, self.position));
        let indices: Vec<_> = self.indices.iter().map(ChunkIndex::content).collect();
        for content in indices {
            self.put(&framed(operation::CHUNK_INDEX, &content))?;
        }
        groups.push((operation::STATISTICS, self.position));
        let statistics = self.statistics();
        self.put(&framed(operation::STATISTICS, &statistics))?;
        let offsets_start = self.position;
        groups.push((0, offsets_start));
        for pair in groups.windows(2) {
            let [(kind, start), (_, end)] = [pair[0], pair[1]];
            if end > start {
                let mut content = vec![kind];
                content.extend(start.to_le_bytes());
                content.extend((end - start).to_le_bytes());
                self.put(&framed(operation::SUMMARY_OFFSET, &content))?;
            }
        }
        let mut footer = Vec::new();
        footer.extend(summary_start.to_le_bytes());
        footer.extend(offsets_start.to_le_bytes());
        // The checksum counts the footer in, up to where it stands itself.
        let mut crc = self.crc.clone();
        footer.extend([0; 4]);
        let record = framed(operation::FOOTER, &footer);
        let (before, _) = record.split_at(record.len() - 4);
        crc.update(before);
        self.put(before)?;
        self.put(&crc.finalize().to_le_bytes())?;
        self.put(&MAGIC)?;
        self.file.flush().map_err(loc_core::Error::io(&self.path))?;
        Ok(self.counts.values().sum())
    }

    fn statistics(&self) -> Vec<u8> {
        let chunks = u32::try_from(self.indices.len()).unwrap_or(u32::MAX);
        let (start, end) = self.times.unwrap_or((0, 0));
        let mut content = Vec::new();
        content.extend(self.counts.values().sum::<u64>().to_le_bytes());
        content.extend(u16::try_from(self.schemas.len()).unwrap_or(u16::MAX).to_le_bytes());
        content.extend(u32::try_from(self.channels.len()).unwrap_or(u32::MAX).to_le_bytes());
        content.extend(0_u32.to_le_bytes());
        content.extend(0_u32.to_le_bytes());
        content.extend(chunks.to_le_bytes());
        content.extend(start.to_le_bytes());
        content.extend(end.to_le_bytes());
        let counts: Vec<(u16, u64)> = self.counts.iter().map(|(id, count)| (*id, *count)).collect();
        map(&mut content, &counts);
        content
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(loc_core::Error::io(&self.path))?;
        self.crc.update(bytes);
        self.position += bytes.len() as u64;
        Ok(())
    }
}

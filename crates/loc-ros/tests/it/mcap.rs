//! MCAP files with every feature of the format, and their checksums: of chunks, of the data, of the
//! summary.

use super::all;
use super::write::{MAGIC, pack, record};
use loc_ros::messages::*;
use loc_ros::{McapReader, McapWriter, MessageReader};
use std::io::Cursor;
use std::path::Path;

/// A file with three chunks of maps, and where its parts are.
fn written() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut writer = McapWriter::create(&path).unwrap();
    for k in 0..3 {
        let map = OccupancyGrid { data: vec![k; 1 << 20], ..OccupancyGrid::default() };
        writer.write("/map", k.into(), &map).unwrap();
    }
    writer.finish().unwrap();
    std::fs::read(path).unwrap()
}

/// The times of the messages, and the notes.
fn read(bytes: Vec<u8>) -> (Vec<i64>, Vec<String>) {
    let (messages, notes) = all(&mut McapReader::read(Path::new("a"), Cursor::new(bytes)).unwrap());
    (messages.iter().map(|message| message.1).collect(), notes)
}

/// Where records of a kind start.
fn records(bytes: &[u8], kind: u8) -> Vec<usize> {
    let (mut at, mut found) = (8, Vec::new());
    while at + 9 <= bytes.len() - 8 {
        if bytes[at] == kind {
            found.push(at);
        }
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    found
}

/// Of the whole by hand: the data from the first byte on, the summary up to its own checksum.
#[test]
fn what_is_written_has_them() {
    let bytes = written();
    let (data_end, footer) = (records(&bytes, 0x0f)[0], records(&bytes, 0x02)[0]);
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(number(data_end + 9), crc32fast::hash(&bytes[..data_end]));
    assert_eq!(number(footer + 25), crc32fast::hash(&bytes[data_end + 13..footer + 25]));
    assert_eq!(read(bytes), (vec![0, 1, 2], vec![]));
}

#[test]
fn damage_is_found_wherever_it_is() {
    let bytes = written();
    let damaged = |place: usize| {
        let mut bytes = bytes.clone();
        bytes[place] ^= 0x10;
        read(bytes)
    };
    let (chunks, indices) = (records(&bytes, 0x06), records(&bytes, 0x07));
    assert_eq!((chunks.len(), indices.len()), (3, 3));
    let (times, notes) = damaged(chunks[1] + 500_000);
    assert_eq!(times, [0, 2]);
    assert_eq!(notes, ["1 chunks with a wrong CRC passed over: they are damaged"]);
    // The index is not read of a chunk, but its bytes count.
    let (times, notes) = damaged(indices[0] + 12);
    assert_eq!(times, [0, 1, 2]);
    assert_eq!(notes, ["its data have a wrong CRC: something in them is damaged"]);
    let (times, notes) = damaged(records(&bytes, 0x0b)[0] + 12);
    assert_eq!(times, [0, 1, 2]);
    assert_eq!(notes, ["its summary has a wrong CRC: it is damaged, and not needed"]);
    // A file that was cut off has no checksums but those of its chunks.
    let (times, notes) = read(bytes[..indices[1]].to_vec());
    assert_eq!(times, [0, 1]);
    assert!(notes[0].starts_with("was not closed"), "{notes:?}");
}

/// What a file of MCAP's conformance suite holds, and what it makes use of. The suite is all
/// combinations that make sense of these; the files here are built record by record.
#[derive(Debug, Clone, Copy)]
struct Features {
    content: Content,
    /// `ch`: messages lie in chunks, packed by this.
    chunks: Option<&'static str>,
    /// `mx`, `chx`, `ax`, `mdx`: indices of messages, chunks, attachments, metadata.
    indices: bool,
    /// `rsh`, `rch`, `st`, `sum`: schemas and channels again, statistics, offsets of the summary.
    summary: [bool; 4],
    /// `pad`: records are longer than their fields.
    padded: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Content {
    NoData,
    OneMessage,
    OneSchemalessMessage,
    TenMessages,
    OneAttachment,
    OneMetadata,
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

impl Features {
    fn all() -> Vec<Self> {
        let contents = [
            Content::NoData,
            Content::OneMessage,
            Content::OneSchemalessMessage,
            Content::TenMessages,
            Content::OneAttachment,
            Content::OneMetadata,
        ];
        let mut all = Vec::new();
        for content in contents {
            for chunks in [None, Some(""), Some("lz4"), Some("zstd")] {
                for bits in 0..64 {
                    let bit = |k: u32| bits >> k & 1 == 1;
                    let summary = [bit(0), bit(1), bit(2), bit(3)];
                    let (indices, padded) = (bit(4), bit(5));
                    all.push(Features { content, chunks, indices, summary, padded });
                }
            }
        }
        all
    }

    /// A record, with bytes behind its fields where that is a feature.
    fn record(&self, kind: u8, content: &[u8]) -> Vec<u8> {
        let padding: &[u8] = if self.padded { &[1, 2, 3] } else { &[] };
        record(kind, &[content, padding].concat())
    }

    fn number_of_messages(&self) -> u64 {
        match self.content {
            Content::OneMessage | Content::OneSchemalessMessage => 1,
            Content::TenMessages => 10,
            _ => 0,
        }
    }

    fn schema(&self) -> Vec<u8> {
        let parts = [&[1, 0][..], &text("Example"), &text("c"), &text("\u{4}\u{5}\u{6}")];
        match self.content {
            Content::OneMessage | Content::TenMessages => self.record(3, &parts.concat()),
            _ => Vec::new(),
        }
    }

    fn channel(&self) -> Vec<u8> {
        if self.number_of_messages() == 0 {
            return Vec::new();
        }
        let schema = u8::from(self.content != Content::OneSchemalessMessage);
        let metadata = [text("foo"), text("bar")].concat();
        let length = (metadata.len() as u32).to_le_bytes();
        let head = [1, 0, schema, 0];
        let parts = [&head[..], &text("example"), &text("cdr"), &length, &metadata];
        self.record(4, &parts.concat())
    }

    /// The file, and where its data end.
    fn file(&self) -> (Vec<u8>, usize) {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(self.record(1, &[text("ros2"), text("")].concat()));
        let mut records = [self.schema(), self.channel()].concat();
        let mut index = Vec::new();
        for k in 0..self.number_of_messages() {
            let (time, sequence) = ((k + 2).to_le_bytes(), (k as u32).to_le_bytes());
            index.extend(time);
            index.extend((records.len() as u64).to_le_bytes());
            let parts = [&[1, 0][..], &sequence, &time, &time, &[k as u8; 5]];
            // What is behind the head of a message is its data.
            records.extend(record(5, &parts.concat()));
        }
        let start = bytes.len();
        let mut chunk_index = Vec::new();
        match self.chunks {
            Some(compression) if !records.is_empty() => {
                let packed = pack(compression, &records);
                let times = [2_u64, self.number_of_messages() + 1].map(u64::to_le_bytes).concat();
                let size = (records.len() as u64).to_le_bytes();
                let packed_size = (packed.len() as u64).to_le_bytes();
                let crc = crc32fast::hash(&records).to_le_bytes();
                let name = text(compression);
                let parts = [&times[..], &size, &crc, &name, &packed_size, &packed];
                let chunk = self.record(6, &parts.concat());
                bytes.extend(&chunk);
                let at = bytes.len();
                if self.indices {
                    let length = (index.len() as u32).to_le_bytes();
                    bytes.extend(self.record(7, &[&[1, 0][..], &length, &index].concat()));
                }
                let index_length = ((bytes.len() - at) as u64).to_le_bytes();
                let place = [start as u64, chunk.len() as u64].map(u64::to_le_bytes).concat();
                let offset = [&10_u32.to_le_bytes()[..], &[1, 0], &(at as u64).to_le_bytes()];
                let offsets = if self.indices { offset.concat() } else { vec![0; 4] };
                let parts =
                    [&times[..], &place, &offsets, &index_length, &name, &packed_size, &size];
                chunk_index = self.record(8, &parts.concat());
            }
            _ => bytes.extend(&records),
        }
        let at = (bytes.len() as u64).to_le_bytes();
        let mut other_index = Vec::new();
        if self.content == Content::OneAttachment {
            let times = [2_u64, 1].map(u64::to_le_bytes).concat();
            let names = [text("myFile"), text("application/octet-stream")].concat();
            let length = 3_u64.to_le_bytes();
            let content = [&times[..], &names, &length, &[1, 2, 3]].concat();
            let crc = crc32fast::hash(&content).to_le_bytes();
            let attachment = self.record(9, &[&content[..], &crc].concat());
            let size = (attachment.len() as u64).to_le_bytes();
            other_index = self.record(10, &[&at[..], &size, &times, &length, &names].concat());
            bytes.extend(attachment);
        }
        if self.content == Content::OneMetadata {
            let map = [text("foo"), text("bar")].concat();
            let length = (map.len() as u32).to_le_bytes();
            let metadata = self.record(12, &[&text("myMetadata")[..], &length, &map].concat());
            let size = (metadata.len() as u64).to_le_bytes();
            other_index = self.record(13, &[&at[..], &size, &text("myMetadata")].concat());
            bytes.extend(metadata);
        }
        // A record of a kind that the format leaves to others.
        bytes.extend(self.record(0x80, b"private"));
        let end = bytes.len();
        bytes.extend(record(15, &crc32fast::hash(&bytes).to_le_bytes()));
        let summary_start = bytes.len();
        let [schemas, channels, statistics, offsets] = self.summary;
        let mut groups = Vec::new();
        let mut group = |bytes: &mut Vec<u8>, is_there: bool, kind: u8, content: Vec<u8>| {
            if is_there && !content.is_empty() {
                let start = (bytes.len() as u64).to_le_bytes();
                let length = (content.len() as u64).to_le_bytes();
                groups.push([&[kind][..], &start, &length].concat());
                bytes.extend(content);
            }
        };
        group(&mut bytes, schemas, 3, self.schema());
        group(&mut bytes, channels, 4, self.channel());
        let count = self.number_of_messages().to_le_bytes();
        let numbers = [&count[..], &[0; 18], &[0; 16], &[0; 4]].concat();
        group(&mut bytes, statistics, 11, self.record(11, &numbers));
        group(&mut bytes, self.indices, 8, chunk_index);
        group(&mut bytes, self.indices, 10, other_index);
        let has_summary = bytes.len() > summary_start;
        let offsets_start = bytes.len();
        if offsets {
            groups.iter().for_each(|group| bytes.extend(self.record(14, group)));
        }
        let place = |is_there: bool, at: usize| if is_there { at as u64 } else { 0 }.to_le_bytes();
        let has_offsets = bytes.len() > offsets_start;
        let footer = [place(has_summary, summary_start), place(has_offsets, offsets_start)];
        let head = [&[2][..], &20_u64.to_le_bytes(), &footer.concat()].concat();
        let crc = crc32fast::hash(&[&bytes[summary_start..], &head].concat());
        bytes.extend([&head[..], &crc.to_le_bytes(), MAGIC].concat());
        (bytes, end)
    }
}

/// All combinations, whole and without their ends.
#[test]
fn every_combination_of_features_is_read() {
    let all_features = Features::all();
    assert_eq!(all_features.len(), 1536);
    for features in all_features {
        let (bytes, end) = features.file();
        let reader = |bytes: &[u8]| {
            let bytes = Cursor::new(bytes.to_vec());
            all(&mut McapReader::read(Path::new("a.mcap"), bytes).unwrap())
        };
        let (messages, notes) = reader(&bytes);
        assert!(notes.is_empty(), "{features:?}: {notes:?}");
        assert_eq!(messages.len() as u64, features.number_of_messages(), "{features:?}");
        for (k, (channel, time, data)) in messages.iter().enumerate() {
            let has_schema = features.content != Content::OneSchemalessMessage;
            assert_eq!(channel.type_name, if has_schema { "Example" } else { "" });
            assert_eq!((channel.topic.as_str(), *time), ("example", k as i64 + 2));
            assert_eq!(data, &[k as u8; 5]);
        }
        // A file that was never closed has the same messages, and says so.
        let (unclosed, notes) = reader(&bytes[..end]);
        assert_eq!(unclosed, messages, "{features:?}");
        assert!(notes.len() == 1 && notes[0].starts_with("was not closed"), "{notes:?}");
        // Damage to the data is found, and the summary is still checked.
        let mut damaged = bytes.clone();
        damaged[end - 1] ^= 1;
        let (damaged, notes) = reader(&damaged);
        assert_eq!(damaged, messages, "{features:?}");
        assert_eq!(notes, ["its data have a wrong CRC: something in them is damaged"]);
    }
}

/// What is no message does not have to fit into memory.
#[test]
fn a_record_that_claims_too_much_ends_the_file_or_is_an_error() {
    let features = Features::all()[64 * 4];
    let (bytes, end) = features.file();
    let with = |kind: u8, length: u64| {
        let head = [&[kind][..], &length.to_le_bytes()].concat();
        let bytes = Cursor::new([&bytes[..end], &head, &bytes[end..]].concat());
        McapReader::read(Path::new("a.mcap"), bytes).unwrap()
    };
    // A long attachment is jumped over, and what follows it is read.
    let attachment = record(9, &vec![7; 5 << 20]);
    let long = [&bytes[..end], &attachment, &super::write::message(1, 9, b"last"), &bytes[end..]];
    let long = Cursor::new(long.concat());
    let (messages, notes) = all(&mut McapReader::read(Path::new("a.mcap"), long).unwrap());
    assert!(messages.len() == 2 && messages[1].2 == b"last" && notes.is_empty(), "{notes:?}");
    let (messages, notes) = all(&mut with(9, 1 << 40));
    assert_eq!(messages.len(), 1);
    assert!(notes[0].contains("read up to there"), "{notes:?}");
    let mut reader = with(5, 1 << 40);
    assert!(reader.next_message().unwrap().is_some());
    let error = reader.next_message().unwrap_err().to_string();
    assert!(error.contains("at most 1073741824 bytes, got 1099511627776 bytes"), "{error}");
}

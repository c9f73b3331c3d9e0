//! Checksums of MCAP files: of chunks, of the data, of the summary.

use super::all;
use loc_ros::messages::*;
use loc_ros::{McapReader, McapWriter};
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
    // Nobody reads the index of a chunk, but its bytes count.
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

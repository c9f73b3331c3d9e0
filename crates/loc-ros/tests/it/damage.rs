//! Bags that break off, lie, or are none.

use super::database::{database, varint};
use super::write::{self, MAGIC};
use super::{Read, all};
use loc_ros::Result;
use loc_ros::{Bag1, Database3, McapReader, MessageReader};
use proptest::prelude::*;
use std::io::Cursor;
use std::path::Path;

fn mcap(bytes: Vec<u8>) -> Result<McapReader> {
    McapReader::read(Path::new("a.mcap"), Cursor::new(bytes))
}

fn bag1(bytes: Vec<u8>) -> Result<Bag1> {
    Bag1::read(Path::new("a.bag"), Cursor::new(bytes))
}

/// Reads to the end or to the error.
fn drain(bag: Result<impl MessageReader>) -> Result<usize> {
    let (mut bag, mut count) = (bag?, 0);
    while bag.next_message()?.is_some() {
        count += 1;
    }
    Ok(count)
}

fn times(messages: &[Read]) -> Vec<i64> {
    messages.iter().map(|message| message.1).collect()
}

/// Ten messages in two chunks.
fn ten(compression: &str) -> Vec<u8> {
    let five = |from: u64| -> Vec<u8> {
        (from..from + 5).flat_map(|k| write::message(1, k, &[k as u8; 100])).collect()
    };
    let first = [write::channel(1, "/a", "std_msgs/msg/String"), five(0)].concat();
    let chunks = [first, five(5)].map(|records| write::chunk(compression, &records, true));
    write::mcap(&chunks)
}

#[test]
fn mcap_is_read_with_every_compression_and_without_chunks() {
    for compression in ["", "lz4", "zstd"] {
        let (messages, notes) = all(&mut mcap(ten(compression)).unwrap());
        assert_eq!(times(&messages), (0..10).collect::<Vec<_>>(), "{compression}");
        assert!(notes.is_empty() && messages[7].2 == [7; 100]);
    }
    let loose = [write::channel(1, "/a", "x/msg/Y"), write::message(1, 3, b"data")].concat();
    let (messages, notes) = all(&mut mcap(write::mcap(&[loose])).unwrap());
    assert!(times(&messages) == [3] && notes.is_empty());
}

/// A killed recorder: everything before the break is read, whatever the byte, and a note says so.
#[test]
fn mcap_that_breaks_off_is_read_up_to_the_break() {
    for compression in ["", "lz4", "zstd"] {
        let whole = ten(compression);
        let end = whole.len() - MAGIC.len() - 29 - 13;
        let mut most = 0;
        for length in MAGIC.len()..whole.len() {
            let (messages, notes) = all(&mut mcap(whole[..length].to_vec()).unwrap());
            let times = times(&messages);
            assert_eq!(times, (0..times.len() as i64).collect::<Vec<_>>());
            assert!(times.len() >= most);
            most = times.len();
            assert_eq!(notes.is_empty(), length >= end + 9, "{length}: {notes:?}");
        }
        assert_eq!(most, 10);
    }
    // An open chunk that is not packed gives what of it was written.
    let cut = ten("");
    let second = cut.len() - MAGIC.len() - 29 - 13 - 5 * 131;
    let (messages, notes) = all(&mut mcap(cut[..second + 300].to_vec()).unwrap());
    assert_eq!(messages.len(), 7);
    assert!(notes.iter().any(|note| note.contains("read up to there")), "{notes:?}");
}

#[test]
fn ros1_that_breaks_off_is_read_up_to_the_break() {
    let messages = |range: std::ops::Range<u32>| -> Vec<u8> {
        range.flat_map(|k| write::message1(4, k, &[k as u8; 50])).collect()
    };
    for compression in ["none", "bz2", "lz4"] {
        let first = [write::connection1(4, "/a", "std_msgs/String"), messages(0..5)].concat();
        let chunks = [first, messages(5..10)].map(|r| write::chunk1(compression, &r));
        let whole = write::bag1(&chunks);
        let (read, notes) = all(&mut bag1(whole.clone()).unwrap());
        assert_eq!(times(&read), (0..10).map(|k| k * 1_000_000_000).collect::<Vec<_>>());
        assert!(notes.is_empty() && read[9].2 == [9; 50]);
        let mut most = 0;
        for length in 13..whole.len() {
            let (read, notes) = all(&mut bag1(whole[..length].to_vec()).unwrap());
            assert!(read.len() >= most);
            most = read.len();
            let is_border = notes.is_empty();
            assert!(!is_border || length == 13 || most % 5 == 0, "{length}");
        }
        assert!(most >= 5);
    }
}

#[test]
fn lies_are_errors_that_say_where() {
    let says = |result: Result<usize>, texts: &[&str]| {
        let error = result.unwrap_err().to_string();
        assert!(texts.iter().all(|text| error.contains(text)), "{error}");
    };
    says(drain(mcap(b"#ROSBAG V2.0\n".to_vec())), &["byte 0", "magic number of an MCAP"]);
    says(drain(mcap(b"abc".to_vec())), &["a.mcap", "got less"]);
    says(drain(bag1(b"#ROSBAG V1.2\n".to_vec())), &["#ROSBAG V2.0", "V1.2"]);
    let database = Database3::read(Path::new("a.db3"), Cursor::new(vec![7; 200]));
    says(drain(database), &["SQLite format 3"]);
    // A chunk that claims 2^60 bytes, of the file and unpacked.
    let mut huge = [MAGIC, &[6]].concat();
    huge.extend((1_u64 << 60).to_le_bytes());
    says(drain(mcap(huge)), &["at byte 17", "1152921504606846976", "at most 1073741824"]);
    let mut lies = write::chunk("lz4", &[1; 500], true);
    lies[9 + 16..9 + 24].copy_from_slice(&(1_u64 << 60).to_le_bytes());
    says(drain(mcap(write::mcap(&[lies]))), &["1152921504606846976"]);
    // A chunk that unpacks to more than it claims.
    let mut bomb = write::chunk("zstd", &vec![1; 100_000], true);
    bomb[9 + 16..9 + 24].copy_from_slice(&1000_u64.to_le_bytes());
    says(drain(mcap(write::mcap(&[bomb]))), &["more than the 1000"]);
    let other = write::chunk("brotli", &[], true);
    says(drain(mcap(write::mcap(&[other]))), &["`brotli`"]);
    says(drain(bag1(write::bag1(&[write::chunk1("zstd", &[])]))), &["`zstd`"]);
}

#[test]
fn damaged_chunks_and_unknown_channels_are_counted() {
    let good = [write::channel(1, "/a", "x/msg/Y"), write::message(1, 1, b"a")].concat();
    let chunks = [
        write::chunk("", &good, true),
        write::chunk("", &write::message(1, 2, b"b"), false),
        write::chunk("lz4", &write::message(9, 3, b"c"), true),
        write::chunk("", &write::message(1, 4, b"d"), true),
    ];
    let (messages, notes) = all(&mut mcap(write::mcap(&chunks)).unwrap());
    assert_eq!(times(&messages), [1, 4]);
    assert!(notes[0].starts_with("1 chunks with a wrong CRC"), "{notes:?}");
    assert!(notes[1].starts_with("1 messages of channels without"), "{notes:?}");
    let records = [
        write::connection1(0, "/a", "x/Y"),
        write::message1(0, 1, b"a"),
        write::message1(5, 2, b"b"),
    ];
    let bag = write::bag1(&[write::chunk1("none", &records.concat())]);
    let (messages, notes) = all(&mut bag1(bag).unwrap());
    assert_eq!(messages.len(), 1);
    assert!(notes[0].contains("1 messages of connections without a header"), "{notes:?}");
}

/// A file that becomes another with any byte: never a panic.
#[test]
fn database_with_any_byte_changed() {
    let whole = super::database::bytes(super::database::DB3);
    for place in (0..whole.len()).step_by(37) {
        let mut changed = whole.clone();
        changed[place] = changed[place].wrapping_add(0x5d);
        let _ = drain(Database3::read(Path::new("a.db3"), Cursor::new(changed)));
        let cut = whole[..place].to_vec();
        let _ = drain(Database3::read(Path::new("a.db3"), Cursor::new(cut)));
    }
    let half = whole[..whole.len() / 2].to_vec();
    let mut bag = Database3::read(Path::new("a.db3"), Cursor::new(half)).unwrap();
    let (messages, notes) = all(&mut bag);
    assert!(messages.len() > 50 && notes[0].contains("breaks off before page"), "{notes:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn nothing_panics(place in 0_usize..1500, byte: u8, length in 0_usize..2000) {
        for compression in ["", "lz4", "zstd"] {
            let mut bytes = ten(compression);
            let end = bytes.len();
            bytes[place % end] = byte;
            bytes.truncate(length.max(place));
            let _ = drain(mcap(bytes));
        }
        let data = write::message1(4, 1, &[3; 50]).repeat(20);
        for compression in ["none", "bz2", "lz4"] {
            let mut bytes = write::bag1(&[write::chunk1(compression, &data)]);
            let end = bytes.len();
            bytes[place % end] = byte;
            let _ = drain(bag1(bytes));
        }
    }
}

/// Lengths that lie, in records of every format.
#[test]
fn lengths_beyond_their_record_are_errors_or_counted() {
    // The topic of a channel claims 4 GB: its messages have no channel.
    let mut channel = write::channel(1, "/a", "x/msg/Y");
    let topic = channel.windows(2).rposition(|pair| pair == b"/a").unwrap();
    channel[topic - 4..topic].copy_from_slice(&u32::MAX.to_le_bytes());
    let records = [channel, write::message(1, 1, b"a")].concat();
    let (messages, notes) = all(&mut mcap(write::mcap(&[records])).unwrap());
    assert!(messages.is_empty() && notes[0].starts_with("1 messages of channels"), "{notes:?}");
    // So of a connection of ROS 1.
    let mut connection = write::connection1(0, "/a", "x/Y");
    let topic = connection.windows(6).rposition(|six| six == b"topic=").unwrap();
    connection[topic - 4..topic].copy_from_slice(&u32::MAX.to_le_bytes());
    let records = [connection, write::message1(0, 1, b"a")].concat();
    let (messages, notes) =
        all(&mut bag1(write::bag1(&[write::chunk1("none", &records)])).unwrap());
    assert!(messages.is_empty() && notes[0].contains("without a header"), "{notes:?}");
    // A chunk of ROS 1 that claims 4 GB unpacked, and a record that claims 4 GB of the file.
    let mut lies = write::bag1(&[write::chunk1("bz2", &[1; 500])]);
    let size = lies.windows(5).rposition(|five| five == b"size=").unwrap() + 5;
    lies[size..size + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = drain(bag1(lies)).unwrap_err().to_string();
    assert!(error.contains("at most 1073741824 bytes, got 4294967295"), "{error}");
    let mut lies = write::bag1(&[]);
    lies.extend([0xff; 4]);
    let (messages, notes) = all(&mut bag1(lies).unwrap());
    assert!(messages.is_empty() && notes[0].contains("breaks off within"), "{notes:?}");
}

#[test]
fn rows_that_lie_or_have_no_topic() {
    let read = |bytes: Vec<u8>| Database3::read(Path::new("a.db3"), Cursor::new(bytes));
    let whole = database(&[(7, "/a", "x/msg/Y")], &[(7, 1, b"first"), (8, 2, b"second")]);
    let (messages, notes) = all(&mut read(whole.clone()).unwrap());
    assert_eq!((messages.len(), messages[0].2.as_slice()), (1, b"first".as_slice()));
    assert_eq!(notes, ["1 messages without a topic passed over"]);
    // A row of 2^55 bytes, at the front of the cell that ends the last page.
    let mut lies = whole;
    let cell = lies.windows(5).rposition(|five| five == b"first").unwrap() + 5;
    let (length, claim) = (lies.len(), varint(1 << 55));
    let start = cell - 40;
    lies[start..start + claim.len()].copy_from_slice(&claim);
    let pointer = length - 8192 + 8;
    lies[pointer..pointer + 2].copy_from_slice(&((start - (length - 8192)) as u16).to_be_bytes());
    let error = drain(read(lies)).unwrap_err().to_string();
    assert!(
        error.contains("no longer than its file, got one of 36028797018963968 bytes"),
        "{error}"
    );
}

/// A recorder that was killed before it wrote anything leaves an empty file in its folder.
#[test]
fn empty_files_of_a_folder_are_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    file("bag_0.mcap", &ten("lz4"));
    file("bag_1.mcap", b"");
    let (messages, notes) = all(&mut loc_ros::Bag2::open(folder.path()).unwrap());
    assert_eq!(messages.len(), 10);
    assert!(notes.contains(&"bag_1.mcap: is empty: passed over".into()), "{notes:?}");
    // Alone it is an error, and so is one that the metadata name and that is not there.
    let error = loc_ros::open(&folder.path().join("bag_1.mcap")).err().unwrap();
    assert!(error.to_string().contains("an empty file"), "{error}");
    file("metadata.yaml", b"rosbag2_bagfile_information:\n  relative_file_paths: [bag_9.mcap]\n");
    let error = drain(loc_ros::Bag2::open(folder.path())).unwrap_err().to_string();
    assert!(error.contains("bag_9.mcap"), "{error}");
}

//! Small bags, written here byte by byte.

use std::io::Write;

/// A record of a bag of ROS 1.
pub(crate) fn record1(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = Vec::new();
    for (name, value) in fields {
        header.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        header.extend(name.as_bytes());
        header.push(b'=');
        header.extend(*value);
    }
    let mut record = (header.len() as u32).to_le_bytes().to_vec();
    record.extend(header);
    record.extend((data.len() as u32).to_le_bytes());
    record.extend(data);
    record
}

/// The connection record of a topic.
pub(crate) fn connection1(number: u32, topic: &str, type_name: &str) -> Vec<u8> {
    let mut data = Vec::new();
    for text in [format!("topic={topic}"), format!("type={type_name}")] {
        data.extend((text.len() as u32).to_le_bytes());
        data.extend(text.as_bytes());
    }
    let fields: [(&str, &[u8]); 3] =
        [("op", &[7]), ("conn", &number.to_le_bytes()), ("topic", topic.as_bytes())];
    record1(&fields, &data)
}

/// A message record.
pub(crate) fn message1(connection: u32, seconds: u32, data: &[u8]) -> Vec<u8> {
    let mut time = seconds.to_le_bytes().to_vec();
    time.extend([0; 4]);
    record1(&[("op", &[2]), ("conn", &connection.to_le_bytes()), ("time", &time)], data)
}

/// A chunk record around records.
pub(crate) fn chunk1(compression: &str, records: &[u8]) -> Vec<u8> {
    let size = (records.len() as u32).to_le_bytes();
    let packed = pack(compression, records);
    let fields: [(&str, &[u8]); 3] =
        [("op", &[5]), ("compression", compression.as_bytes()), ("size", &size)];
    record1(&fields, &packed)
}

/// A bag of ROS 1 around records.
pub(crate) fn bag1(records: &[Vec<u8>]) -> Vec<u8> {
    let mut bag = b"#ROSBAG V2.0\n".to_vec();
    let zero = [0; 8];
    let fields: [(&str, &[u8]); 4] = [
        ("op", &[3]),
        ("index_pos", &zero),
        ("conn_count", &zero[..4]),
        ("chunk_count", &zero[..4]),
    ];
    bag.extend(record1(&fields, &[b' '; 100]));
    bag.extend(records.concat());
    bag
}

pub(crate) fn pack(compression: &str, bytes: &[u8]) -> Vec<u8> {
    match compression {
        "bz2" => {
            let mut encoder =
                bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        "lz4" => {
            let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
        "zstd" => {
            let level = ruzstd::encoding::CompressionLevel::Fastest;
            ruzstd::encoding::compress_to_vec(bytes, level)
        }
        _ => bytes.to_vec(),
    }
}

pub(crate) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// A record of an MCAP file.
pub(crate) fn record(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut record = vec![kind];
    record.extend((content.len() as u64).to_le_bytes());
    record.extend(content);
    record
}

fn text(text: &str) -> Vec<u8> {
    [(text.len() as u32).to_le_bytes().as_slice(), text.as_bytes()].concat()
}

/// Schema and channel of a topic, both with this number.
pub(crate) fn channel(number: u16, topic: &str, type_name: &str) -> Vec<u8> {
    let id = number.to_le_bytes();
    let schema = [id.to_vec(), text(type_name), text("ros2msg"), text("")].concat();
    let channel = [id.to_vec(), id.to_vec(), text(topic), text("cdr"), vec![0; 4]].concat();
    [record(3, &schema), record(4, &channel)].concat()
}

pub(crate) fn message(channel: u16, nanoseconds: u64, data: &[u8]) -> Vec<u8> {
    let time = nanoseconds.to_le_bytes();
    let content = [&channel.to_le_bytes(), [0; 4].as_slice(), &time, &time, data].concat();
    record(5, &content)
}

/// A chunk record around records; its checksum may be made wrong.
pub(crate) fn chunk(compression: &str, records: &[u8], is_right: bool) -> Vec<u8> {
    let crc = crc32fast::hash(records) ^ u32::from(!is_right);
    let packed = pack(compression, records);
    let content = [
        [0; 16].as_slice(),
        &(records.len() as u64).to_le_bytes(),
        &crc.to_le_bytes(),
        &text(compression),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ];
    record(6, &content.concat())
}

/// An MCAP file around records, without an index.
pub(crate) fn mcap(records: &[Vec<u8>]) -> Vec<u8> {
    let header = record(1, &[text("ros2"), text("test")].concat());
    let end = [record(15, &[0; 4]), record(2, &[0; 20]), MAGIC.to_vec()].concat();
    [MAGIC.to_vec(), header, records.concat(), end].concat()
}

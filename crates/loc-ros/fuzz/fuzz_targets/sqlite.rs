//! Bags of ROS 2 in files of SQLite. The first byte says what the rest is: a database, a database
//! with its write-ahead log (the length of the log in front), or the `metadata.yaml` of a folder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_ros::{Bag2, Database3};
use std::io::Cursor;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    match data.split_first() {
        None => {}
        Some((b'M', metadata)) => {
            loc_fuzz::file("metadata.yaml", metadata);
            loc_fuzz::file("bag_0.db3", &[]);
            loc_fuzz::drain(Bag2::open(loc_fuzz::folder()));
        }
        Some((b'L', [low, high, rest @ ..])) => {
            let length = usize::from(u16::from_le_bytes([*low, *high])).min(rest.len());
            let (log, database) = rest.split_at(length);
            loc_fuzz::file("logged.db3-wal", log);
            loc_fuzz::drain(Database3::open(&loc_fuzz::file("logged.db3", database)));
        }
        Some((_, database)) => {
            let database = Cursor::new(database.to_vec());
            loc_fuzz::drain(Database3::read(Path::new("a.db3"), database));
        }
    }
});

//! Pages of a SQLite file, and of the write-ahead log that takes the place of some of them.

use super::MAGIC;
use crate::Result;
use crate::bytes::{Fields, Input};
use std::collections::BTreeMap;
use std::path::Path;

/// Bytes of the log's head, and of the head of each page in it.
const WAL_HEAD: u64 = 32;
const WAL_PAGE_HEAD: u64 = 24;

/// The pages of a database, from its file or from its write-ahead log.
#[derive(Debug)]
pub(super) struct Pager {
    input: Input,
    log: Option<(Input, BTreeMap<u32, u64>)>,
    page_size: u32,
    usable: u32,
    /// Highest page that was read, for the progress.
    reached: u32,
    missing: Option<u32>,
}

impl Pager {
    pub(super) fn new(mut input: Input, log: Option<Input>) -> Result<Self> {
        let head = input.fixed::<100>()?;
        let Some(head) = head.filter(|head| head.starts_with(MAGIC)) else {
            return Err(input.error_at(0, "\"SQLite format 3\"", "something else"));
        };
        let page_size = match u16::from_be_bytes([head[16], head[17]]) {
            1 => 65536,
            size => u32::from(size),
        };
        let usable = page_size.saturating_sub(head[20].into());
        if !page_size.is_power_of_two() || page_size < 512 || usable < 480 {
            let expected = "a page size of 512 to 65536 bytes, a power of 2";
            return Err(input.error_at(16, expected, page_size.to_string()));
        }
        if !matches!(head[59], 0 | 1) {
            return Err(input.error_at(56, "texts in UTF-8", format!("encoding {}", head[59])));
        }
        let log = log.map(|mut log| {
            let (pages, _) = wal_pages(&mut log, page_size)?;
            Ok::<_, crate::Error>((log, pages))
        });
        Ok(Pager { input, log: log.transpose()?, page_size, usable, reached: 0, missing: None })
    }

    pub(super) fn path(&self) -> &Path {
        self.input.path()
    }

    /// Bytes of a page that hold content.
    pub(super) fn usable(&self) -> usize {
        self.usable as usize
    }

    /// Bytes of the file.
    pub(super) fn length(&self) -> u64 {
        self.input.length() + self.log.as_ref().map_or(0, |(log, _)| log.length())
    }

    pub(super) fn missing(&self) -> Option<u32> {
        self.missing
    }

    pub(super) fn progress(&self) -> f64 {
        let pages = (self.input.length() / u64::from(self.page_size)).max(1);
        (f64::from(self.reached) / pages as f64).min(1.0)
    }

    /// Reads a page, counted from 1; false where the file does not have it.
    pub(super) fn page(&mut self, number: u32, into: &mut Vec<u8>) -> Result<bool> {
        self.reached = self.reached.max(number);
        let size = self.page_size;
        if let Some((log, pages)) = &mut self.log
            && let Some(at) = pages.get(&number)
        {
            log.seek(*at)?;
            return Ok(log.read("a page", size.into(), into)? == size as usize);
        }
        let at = u64::from(number.saturating_sub(1)) * u64::from(size);
        if number == 0 || at + u64::from(size) > self.input.length() {
            self.missing.get_or_insert(number);
            return Ok(false);
        }
        self.input.seek(at)?;
        Ok(self.input.read("a page", size.into(), into)? == size as usize)
    }

    pub(super) fn error(&self, expected: &str, found: impl Into<String>) -> crate::Error {
        crate::Error::Recording {
            path: self.path().to_owned(),
            expected: expected.into(),
            found: found.into(),
        }
    }
}

/// Where in the log the newest version of each page lies, and of how many pages the database is
/// with it. Empty for a log that is none, or in which nothing was completed.
fn wal_pages(log: &mut Input, page_size: u32) -> Result<(BTreeMap<u32, u64>, u32)> {
    let (mut pages, mut open, mut count) = (BTreeMap::new(), BTreeMap::new(), 0);
    let Some(head) = log.fixed::<{ WAL_HEAD as usize }>()? else { return Ok((pages, count)) };
    let [magic, _version, size] = words(&head);
    if magic & 0xffff_fffe != 0x377f_0682 || size != page_size {
        return Ok((pages, count));
    }
    let big_endian = magic & 1 == 1;
    let mut sum = checksum((0, 0), &head[..24], big_endian);
    let stored = |bytes: &[u8]| words::<2>(bytes);
    if stored(&head[24..]) != [sum.0, sum.1] {
        return Ok((pages, count));
    }
    let mut content = Vec::new();
    while let Some(frame) = log.fixed::<{ WAL_PAGE_HEAD as usize }>()? {
        let at = log.position();
        if log.read("a page of the log", page_size.into(), &mut content)? < page_size as usize {
            break;
        }
        sum = checksum(sum, &frame[..8], big_endian);
        sum = checksum(sum, &content, big_endian);
        // What follows is left from an earlier log, or was never finished.
        if frame[8..16] != head[16..24] || stored(&frame[16..]) != [sum.0, sum.1] {
            break;
        }
        let [page, size_after] = words(&frame);
        open.insert(page, at);
        if size_after > 0 {
            pages.append(&mut open);
            count = size_after;
        }
    }
    Ok((pages, count))
}

fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut fields = Fields::new(bytes);
    [(); N].map(|()| fields.u32().unwrap_or(0).swap_bytes())
}

/// The log's own checksum over pairs of words.
fn checksum(sum: (u32, u32), bytes: &[u8], big_endian: bool) -> (u32, u32) {
    let (words, _) = bytes.as_chunks::<4>();
    let word = |bytes: [u8; 4]| match big_endian {
        true => u32::from_be_bytes(bytes),
        false => u32::from_le_bytes(bytes),
    };
    let (pairs, _) = words.as_chunks::<2>();
    pairs.iter().fold(sum, |(first, second), pair| {
        let first = first.wrapping_add(word(pair[0])).wrapping_add(second);
        (first, second.wrapping_add(word(pair[1])).wrapping_add(first))
    })
}

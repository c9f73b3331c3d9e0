//! The write-ahead log: pages that take the place of the file's.

use crate::Result;
use crate::source::ros::fields::Fields;
use crate::source::ros::input::Input;
use std::collections::BTreeMap;

/// Bytes of the log's head, and of the head of each page in it.
const HEAD: u64 = 32;
const PAGE_HEAD: u64 = 24;

/// Where in the log the newest version of each page lies, and of how many pages the database is
/// with it. Empty for a log that is none, or in which nothing was completed.
pub(super) fn pages(log: &mut Input, page_size: u32) -> Result<(BTreeMap<u32, u64>, u32)> {
    let (mut pages, mut open, mut count) = (BTreeMap::new(), BTreeMap::new(), 0);
    let Some(head) = log.fixed::<{ HEAD as usize }>()? else { return Ok((pages, count)) };
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
    while let Some(frame) = log.fixed::<{ PAGE_HEAD as usize }>()? {
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

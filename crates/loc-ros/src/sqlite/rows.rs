//! The rows of a table in order of their numbers, and their values.

use super::pages::Pager;
use crate::Result;

/// Deepest tree: with two entries on each page this is more than any file has.
const MAX_DEPTH: usize = 40;

const INTERIOR: u8 = 0x05;
const LEAF: u8 = 0x0d;

/// A walk over the leaves of a table's tree.
#[derive(Debug, Clone)]
pub(crate) struct TableScan {
    root: Option<u32>,
    path: Vec<Page>,
    /// Pages left that the walk may visit, so that a tree with a cycle ends.
    pages_left: Option<u64>,
}

#[derive(Debug, Clone)]
struct Page {
    bytes: Vec<u8>,
    /// Where its head starts: behind the file's on page 1.
    head: usize,
    kind: u8,
    cells: usize,
    next: usize,
}

impl TableScan {
    pub(super) fn new(root: u32) -> Self {
        TableScan { root: Some(root), path: Vec::new(), pages_left: None }
    }

    /// The next row; `None` at the end, or where the file ends before.
    pub(super) fn next(&mut self, pager: &mut Pager) -> Result<Option<Row>> {
        if let Some(root) = self.root.take()
            && !self.open(root, pager)?
        {
            return Ok(None);
        }
        while let Some(page) = self.path.last_mut() {
            let index = page.next;
            page.next += 1;
            if page.kind == LEAF && index < page.cells {
                let cell = page.cell(index).ok_or_else(|| broken(pager))?.to_vec();
                return row(&cell, pager);
            }
            let child = match page.kind {
                INTERIOR if index < page.cells => page.cell(index),
                // The last child stands in the head.
                INTERIOR if index == page.cells => page.bytes.get(page.head + 8..),
                _ => {
                    self.path.pop();
                    continue;
                }
            };
            let child = child.and_then(|bytes| bytes.first_chunk().copied());
            let child = child.ok_or_else(|| broken(pager))?;
            if !self.open(u32::from_be_bytes(child), pager)? {
                self.path.clear();
            }
        }
        Ok(None)
    }

    /// Goes down to a page; false where the file does not have it.
    fn open(&mut self, number: u32, pager: &mut Pager) -> Result<bool> {
        let max = pager.length() / 512 + 1;
        let left = self.pages_left.get_or_insert(max);
        if *left == 0 || self.path.len() >= MAX_DEPTH {
            return Err(broken(pager));
        }
        *left -= 1;
        let mut bytes = Vec::new();
        if !pager.page(number, &mut bytes)? {
            return Ok(false);
        }
        let head = if number == 1 { 100 } else { 0 };
        let kind = bytes.get(head).copied().unwrap_or(0);
        let cells = match bytes.get(head + 3..head + 5) {
            Some([high, low]) => usize::from(u16::from_be_bytes([*high, *low])),
            _ => 0,
        };
        if kind != INTERIOR && kind != LEAF {
            return Err(broken(pager));
        }
        self.path.push(Page { bytes, head, kind, cells, next: 0 });
        Ok(true)
    }
}

impl Page {
    /// The bytes from a cell on.
    fn cell(&self, index: usize) -> Option<&[u8]> {
        let pointers = self.head + if self.kind == LEAF { 8 } else { 12 };
        let pointer = self.bytes.get(pointers + 2 * index..)?.first_chunk()?;
        self.bytes.get(usize::from(u16::from_be_bytes(*pointer))..)
    }
}

/// The row of a cell, with what of it lies on other pages; `None` where the file ends before.
fn row(cell: &[u8], pager: &mut Pager) -> Result<Option<Row>> {
    let parsed = varint(cell).and_then(|(length, first)| {
        let (id, second) = varint(cell.get(first..)?)?;
        Some((length, id.cast_signed(), cell.get(first + second..)?))
    });
    let (length, id, content) = parsed.ok_or_else(|| broken(pager))?;
    // A row is never longer than its file.
    let total = usize::try_from(length).ok().filter(|_| length <= pager.length());
    let total = total.ok_or_else(|| {
        pager.error("a row no longer than its file", format!("one of {length} bytes"))
    })?;
    let local = local_length(total, pager.usable());
    let mut payload = content.get(..local).ok_or_else(|| broken(pager))?.to_vec();
    let mut next = content.get(local..).and_then(|rest| rest.first_chunk().copied());
    let mut page = Vec::new();
    while payload.len() < total {
        let number = next.map(u32::from_be_bytes).ok_or_else(|| broken(pager))?;
        if !pager.page(number, &mut page)? {
            return Ok(None);
        }
        let here = (total - payload.len()).min(pager.usable() - 4);
        payload.extend(page.get(4..4 + here).unwrap_or_default());
        next = page.first_chunk().copied();
    }
    Ok(Some(Row { id, payload }))
}

/// How much of a row's record lies on the page of the tree itself.
fn local_length(total: usize, usable: usize) -> usize {
    let max = usable - 35;
    if total <= max {
        return total;
    }
    let min = (usable - 12) * 32 / 255 - 23;
    let spread = min + (total - min) % (usable - 4);
    if spread <= max { spread } else { min }
}

fn broken(pager: &Pager) -> crate::Error {
    pager.error("a table of SQLite", "a page that cannot be one of its tree")
}

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value<'a> {
    Null,
    Integer(i64),
    Real,
    Text(&'a [u8]),
    Blob(&'a [u8]),
}

/// A row: its number, and its record.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Row {
    pub(crate) id: i64,
    payload: Vec<u8>,
}

impl Row {
    /// The value of a column; null for a column that the row has not, or that overruns it.
    pub(crate) fn value(&self, column: usize) -> Value<'_> {
        self.find(column).unwrap_or(Value::Null)
    }

    fn find(&self, column: usize) -> Option<Value<'_>> {
        let (head, mut at) = varint(&self.payload)?;
        let head = usize::try_from(head).ok()?;
        let mut place = head;
        let mut index = 0;
        while at < head {
            let (kind, length) = varint(self.payload.get(at..head)?)?;
            at += length;
            let size = size(kind)?;
            let bytes = self.payload.get(place..place.checked_add(size)?)?;
            if index == column {
                return Some(value(kind, bytes));
            }
            index += 1;
            place += size;
        }
        None
    }
}

/// Bytes of a value of a kind.
fn size(kind: u64) -> Option<usize> {
    Some(match kind {
        0 | 8 | 9 => 0,
        1..=4 => kind as usize,
        5 => 6,
        6 | 7 => 8,
        10 | 11 => return None,
        _ => usize::try_from((kind - 12) / 2).ok()?,
    })
}

fn value(kind: u64, bytes: &[u8]) -> Value<'_> {
    match kind {
        0 => Value::Null,
        7 => Value::Real,
        8 => Value::Integer(0),
        9 => Value::Integer(1),
        1..=6 => {
            let negative = bytes.first().is_some_and(|first| *first >= 0x80);
            let start = if negative { -1 } else { 0 };
            Value::Integer(bytes.iter().fold(start, |sum, byte| (sum << 8) | i64::from(*byte)))
        }
        _ if kind.is_multiple_of(2) => Value::Blob(bytes),
        _ => Value::Text(bytes),
    }
}

/// A number of one to nine bytes, and how many those were.
fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
    let mut number = 0_u64;
    for (index, byte) in bytes.iter().enumerate().take(9) {
        if index == 8 {
            return Some(((number << 8) | u64::from(*byte), 9));
        }
        number = (number << 7) | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Some((number, index + 1));
        }
    }
    None
}

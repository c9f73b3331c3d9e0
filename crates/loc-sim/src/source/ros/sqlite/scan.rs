//! The rows of a table in order of their numbers.

use super::pager::Pager;
use super::value::{Row, varint};
use crate::Result;

/// Deepest tree: with two entries on each page this is more than any file has.
const DEEPEST: usize = 40;

const INTERIOR: u8 = 0x05;
const LEAF: u8 = 0x0d;

/// A walk over the leaves of a table's tree.
#[derive(Debug, Clone)]
pub(in crate::source::ros) struct TableScan {
    root: Option<u32>,
    path: Vec<Page>,
    /// Pages left that the walk may visit: a tree that bites its tail ends.
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
        let most = pager.length() / 512 + 1;
        let left = self.pages_left.get_or_insert(most);
        if *left == 0 || self.path.len() >= DEEPEST {
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
    let most = usable - 35;
    if total <= most {
        return total;
    }
    let least = (usable - 12) * 32 / 255 - 23;
    let spread = least + (total - least) % (usable - 4);
    if spread <= most { spread } else { least }
}

fn broken(pager: &Pager) -> crate::Error {
    pager.error("a table of SQLite", "a page that cannot be one of its tree")
}

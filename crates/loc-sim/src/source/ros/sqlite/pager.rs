//! Pages of the file.

use super::MAGIC;
use super::wal;
use crate::Result;
use crate::source::ros::input::Input;
use std::collections::BTreeMap;
use std::path::Path;

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
            let (pages, _) = wal::pages(&mut log, page_size)?;
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

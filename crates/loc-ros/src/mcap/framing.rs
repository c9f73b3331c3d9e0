//! How records of an MCAP file are put together.

/// A record: its kind, its length, its content.
pub(super) fn framed(kind: u8, content: &[u8]) -> Vec<u8> {
    let mut record = Vec::with_capacity(content.len() + 9);
    record.push(kind);
    record.extend((content.len() as u64).to_le_bytes());
    record.extend(content);
    record
}

/// A text behind its length.
pub(super) fn text(into: &mut Vec<u8>, text: &str) {
    into.extend(length(text.len()));
    into.extend(text.as_bytes());
}

/// Pairs of numbers behind their length in bytes.
pub(super) fn pairs(into: &mut Vec<u8>, pairs: &[(u64, u64)]) {
    into.extend(length(16 * pairs.len()));
    for (first, second) in pairs {
        into.extend(first.to_le_bytes());
        into.extend(second.to_le_bytes());
    }
}

/// Numbers by channel behind their length in bytes.
pub(super) fn map(into: &mut Vec<u8>, map: &[(u16, u64)]) {
    into.extend(length(10 * map.len()));
    for (key, value) in map {
        into.extend(key.to_le_bytes());
        into.extend(value.to_le_bytes());
    }
}

fn length(bytes: usize) -> [u8; 4] {
    u32::try_from(bytes).unwrap_or(u32::MAX).to_le_bytes()
}

/// Widens a span of time to hold one more.
pub(super) fn widen(span: &mut Option<(u64, u64)>, time: u64) {
    let (first, last) = span.unwrap_or((time, time));
    *span = Some((first.min(time), last.max(time)));
}

/// What the index says about a chunk.
#[derive(Debug, Clone)]
pub(super) struct ChunkIndex {
    /// Times of its first and last message \[ns\].
    pub(super) times: (u64, u64),
    /// Where it starts.
    pub(super) start: u64,
    /// Its length with its head.
    pub(super) length: u64,
    /// Where the index of each channel's messages lies.
    pub(super) message_indices: Vec<(u16, u64)>,
    /// Length of them all.
    pub(super) message_index_length: u64,
    /// Length of its records.
    pub(super) size: u64,
}

impl ChunkIndex {
    /// The content of its record.
    pub(super) fn content(&self) -> Vec<u8> {
        let mut content = Vec::new();
        for number in [self.times.0, self.times.1, self.start, self.length] {
            content.extend(number.to_le_bytes());
        }
        map(&mut content, &self.message_indices);
        content.extend(self.message_index_length.to_le_bytes());
        text(&mut content, "");
        // Nothing is packed: both lengths are the same.
        content.extend(self.size.to_le_bytes());
        content.extend(self.size.to_le_bytes());
        content
    }
}

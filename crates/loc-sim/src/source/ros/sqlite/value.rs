//! Rows and their values.

/// A value of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::source::ros) enum Value<'a> {
    Null,
    Integer(i64),
    Real,
    Text(&'a [u8]),
    Blob(&'a [u8]),
}

/// A row: its number, and its record.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::source::ros) struct Row {
    pub(in crate::source::ros) id: i64,
    pub(super) payload: Vec<u8>,
}

impl Row {
    /// The value of a column; null for a column that the row has not, or that overruns it.
    pub(in crate::source::ros) fn value(&self, column: usize) -> Value<'_> {
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
pub(super) fn varint(bytes: &[u8]) -> Option<(u64, usize)> {
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

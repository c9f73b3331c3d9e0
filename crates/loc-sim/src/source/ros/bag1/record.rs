//! Records: a header of named fields, and data.

use crate::source::ros::fields::Fields;

/// The named fields of a record.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Header {
    fields: Vec<(Vec<u8>, Vec<u8>)>,
}

impl Header {
    /// Fields of the form `length name=value`; `None` where one overruns the rest.
    pub(super) fn parse(bytes: &[u8]) -> Option<Self> {
        let (mut rest, mut fields) = (Fields::new(bytes), Vec::new());
        while !rest.is_empty() {
            let field = rest.block()?;
            let equals = field.iter().position(|byte| *byte == b'=')?;
            fields.push((field[..equals].to_vec(), field[equals + 1..].to_vec()));
        }
        Some(Header { fields })
    }

    fn value(&self, name: &str) -> Option<&[u8]> {
        let found = self.fields.iter().find(|(known, _)| known == name.as_bytes());
        found.map(|(_, value)| value.as_slice())
    }

    pub(super) fn text(&self, name: &str) -> Option<String> {
        self.value(name).map(|value| String::from_utf8_lossy(value).into_owned())
    }

    pub(super) fn u32(&self, name: &str) -> Option<u32> {
        self.value(name)?.try_into().ok().map(u32::from_le_bytes)
    }

    /// A time as seconds and nanoseconds \[ns\].
    pub(super) fn time(&self, name: &str) -> Option<i64> {
        let mut fields = Fields::new(self.value(name)?);
        let (seconds, nanoseconds) = (fields.u32()?, fields.u32()?);
        Some(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds))
    }

    /// What kind of record it is.
    pub(super) fn operation(&self) -> Option<u8> {
        match self.value("op")? {
            [operation] => Some(*operation),
            _ => None,
        }
    }
}

/// The record at the front, header and data.
pub(super) fn record<'a>(fields: &mut Fields<'a>) -> Option<(Header, &'a [u8])> {
    let header = Header::parse(fields.block()?)?;
    Some((header, fields.block()?))
}

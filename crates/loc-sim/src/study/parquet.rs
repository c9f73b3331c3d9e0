//! Tables as Apache Parquet, which pandas, Polars, DuckDB and R read with types and nulls intact.
//!
//! It writes the smallest part of the format that every reader supports: flat columns that may be null, plain
//! encoding, no compression, one page per column and row group. (Specification: `README.md`,
//! `Encodings.md` and `parquet.thrift` of <https://github.com/apache/parquet-format>.)
//!
//! ```
//! use loc_sim::study::parquet::{Column, Kind, Values, Writer};
//! let columns = vec![Column::new("seed", Kind::Unsigned), Column::new("ate_m", Kind::Number)];
//! let mut writer = Writer::new(Vec::new(), columns)?;
//! writer.rows(&[Values::Unsigned(vec![Some(1), Some(2)]), Values::Number(vec![Some(0.1), None])])?;
//! let bytes = writer.finish()?;
//! assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
//! # Ok::<(), std::io::Error>(())
//! ```

use std::io;
use std::io::Write;

const MAGIC: &[u8; 4] = b"PAR1";
/// Numbers of the format's enumerations.
const OPTIONAL: i32 = 1;
const PLAIN: i32 = 0;
const RLE: i32 = 3;
const UNCOMPRESSED: i32 = 0;

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Truth values.
    Bool,
    /// Whole numbers of 64 bits.
    Integer,
    /// Whole numbers of 64 bits that are not negative.
    Unsigned,
    /// Numbers of double precision.
    Number,
    /// Text.
    Text,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// The type of its values.
    pub kind: Kind,
}

/// Some rows of a column, with nulls.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Of [`Kind::Bool`].
    Bool(Vec<Option<bool>>),
    /// Of [`Kind::Integer`].
    Integer(Vec<Option<i64>>),
    /// Of [`Kind::Unsigned`].
    Unsigned(Vec<Option<u64>>),
    /// Of [`Kind::Number`].
    Number(Vec<Option<f64>>),
    /// Of [`Kind::Text`].
    Text(Vec<Option<String>>),
}

impl Kind {
    /// The physical type: BOOLEAN, INT64, DOUBLE, BYTE_ARRAY.
    fn physical(self) -> i32 {
        match self {
            Kind::Bool => 0,
            Kind::Integer | Kind::Unsigned => 2,
            Kind::Number => 5,
            Kind::Text => 6,
        }
    }

    /// The logical type of the physical one: UTF8, UINT_64.
    fn converted(self) -> Option<i32> {
        match self {
            Kind::Text => Some(0),
            Kind::Unsigned => Some(14),
            _ => None,
        }
    }
}

impl Column {
    /// A column of a name and a kind.
    pub fn new(name: impl Into<String>, kind: Kind) -> Self {
        Column { name: name.into(), kind }
    }

    fn schema(&self) -> Struct {
        let element = Struct::new().i32(1, self.kind.physical()).i32(3, OPTIONAL);
        let element = element.text(4, &self.name);
        match self.kind.converted() {
            Some(converted) => element.i32(6, converted),
            None => element,
        }
    }
}

impl Values {
    /// The kind of the values.
    pub fn kind(&self) -> Kind {
        match self {
            Values::Bool(_) => Kind::Bool,
            Values::Integer(_) => Kind::Integer,
            Values::Unsigned(_) => Kind::Unsigned,
            Values::Number(_) => Kind::Number,
            Values::Text(_) => Kind::Text,
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Values::Bool(values) => values.len(),
            Values::Integer(values) => values.len(),
            Values::Unsigned(values) => values.len(),
            Values::Number(values) => values.len(),
            Values::Text(values) => values.len(),
        }
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Writes a Parquet file, row group by row group.
#[derive(Debug)]
pub struct Writer<W: Write> {
    target: W,
    columns: Vec<Column>,
    written: u64,
    rows: u64,
    groups: Vec<RowGroup>,
}

/// The entry of a row group in the footer.
#[derive(Debug)]
struct RowGroup {
    rows: u64,
    /// Begin and length of each column's page.
    chunks: Vec<(u64, u64)>,
}

impl<W: Write> Writer<W> {
    /// Begins a file of these columns.
    ///
    /// # Errors
    /// Those of the target.
    pub fn new(mut target: W, columns: Vec<Column>) -> io::Result<Self> {
        target.write_all(MAGIC)?;
        let written = MAGIC.len() as u64;
        Ok(Writer { target, columns, written, rows: 0, groups: Vec::new() })
    }

    /// Writes some rows, one element of `values` per column; thousands at once are best.
    ///
    /// # Errors
    /// Those of the target; [`io::ErrorKind::InvalidInput`] for values that are not those of the
    /// columns, or of different lengths, or more than 2 GB of one column.
    pub fn rows(&mut self, values: &[Values]) -> io::Result<()> {
        let rows = values.first().map_or(0, Values::len);
        let kinds = self.columns.iter().map(|column| column.kind);
        if !kinds.eq(values.iter().map(Values::kind)) || values.iter().any(|v| v.len() != rows) {
            let message = "values: expected those of each column, as many of one as of the others";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        if rows == 0 {
            return Ok(());
        }
        let mut chunks = Vec::with_capacity(values.len());
        for values in values {
            let page = page(values)?;
            self.target.write_all(&page)?;
            chunks.push((self.written, page.len() as u64));
            self.written += page.len() as u64;
        }
        self.rows += rows as u64;
        self.groups.push(RowGroup { rows: rows as u64, chunks });
        Ok(())
    }

    /// Writes the footer.
    ///
    /// # Errors
    /// Those of the target.
    pub fn finish(mut self) -> io::Result<W> {
        let footer = self.footer().finish();
        self.target.write_all(&footer)?;
        let length = u32::try_from(footer.len())
            .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "too many row groups"))?;
        self.target.write_all(&length.to_le_bytes())?;
        self.target.write_all(MAGIC)?;
        self.target.flush()?;
        Ok(self.target)
    }

    fn footer(&self) -> Struct {
        let root = Struct::new().text(4, "schema").i32(5, self.columns.len() as i32);
        let mut schema = vec![root];
        schema.extend(self.columns.iter().map(Column::schema));
        let groups = self.groups.iter().map(|group| {
            let pairs = self.columns.iter().zip(&group.chunks);
            let chunks: Vec<_> =
                pairs.map(|(column, place)| chunk(column, *place, group.rows)).collect();
            let size: u64 = group.chunks.iter().map(|(_, length)| length).sum();
            Struct::new()
                .structs(1, chunks.into_iter())
                .i64(2, size.cast_signed())
                .i64(3, group.rows.cast_signed())
        });
        Struct::new()
            .i32(1, 1)
            .structs(2, schema.into_iter())
            .i64(3, self.rows.cast_signed())
            .structs(4, groups)
            .text(6, concat!("loc-sim version ", env!("CARGO_PKG_VERSION")))
    }
}

/// A column of a row group.
fn chunk(column: &Column, (begin, length): (u64, u64), rows: u64) -> Struct {
    let (begin, length) = (begin.cast_signed(), length.cast_signed());
    let data = Struct::new()
        .i32(1, column.kind.physical())
        .i32s(2, &[PLAIN, RLE])
        .texts(3, &[&column.name])
        .i32(4, UNCOMPRESSED)
        .i64(5, rows.cast_signed())
        .i64(6, length)
        .i64(7, length)
        .i64(9, begin);
    Struct::new().i64(2, begin).inner(3, data)
}

/// The header and the data of a page.
fn page(values: &Values) -> io::Result<Vec<u8>> {
    let data = data(values);
    let too_large = || io::Error::new(io::ErrorKind::InvalidInput, "a column of more than 2 GB");
    let size = i32::try_from(data.len()).map_err(|_| too_large())?;
    let rows = i32::try_from(values.len()).map_err(|_| too_large())?;
    let about = Struct::new().i32(1, rows).i32(2, PLAIN).i32(3, RLE).i32(4, RLE);
    let header = Struct::new().i32(1, 0).i32(2, size).i32(3, size).inner(5, about);
    let mut page = header.finish();
    page.extend(data);
    Ok(page)
}

fn data(values: &Values) -> Vec<u8> {
    let mut data = Vec::new();
    match values {
        Values::Bool(values) => {
            presence(&mut data, values);
            let mut bits = values.iter().flatten().peekable();
            while bits.peek().is_some() {
                let eight = bits.by_ref().take(8).enumerate();
                data.push(eight.fold(0, |byte, (k, bit)| byte | (u8::from(*bit) << k)));
            }
        }
        Values::Integer(values) => {
            presence(&mut data, values);
            values.iter().flatten().for_each(|value| data.extend(value.to_le_bytes()));
        }
        Values::Unsigned(values) => {
            presence(&mut data, values);
            values.iter().flatten().for_each(|value| data.extend(value.to_le_bytes()));
        }
        Values::Number(values) => {
            presence(&mut data, values);
            values.iter().flatten().for_each(|value| data.extend(value.to_le_bytes()));
        }
        Values::Text(values) => {
            presence(&mut data, values);
            for text in values.iter().flatten() {
                // A page of 2 GB is refused later on.
                data.extend((text.len() as u32).to_le_bytes());
                data.extend(text.as_bytes());
            }
        }
    }
    data
}

/// The definition levels, 1 for a value and 0 for null, as runs with their length in front.
fn presence<T>(data: &mut Vec<u8>, values: &[Option<T>]) {
    let mut runs = Vec::new();
    for run in values.chunk_by(|a, b| a.is_some() == b.is_some()) {
        varint(&mut runs, (run.len() as u64) << 1);
        runs.push(u8::from(run[0].is_some()));
    }
    data.extend((runs.len() as u32).to_le_bytes());
    data.extend(runs);
}

// The compact protocol of Apache Thrift, as far as the headers of Parquet need it.
//
// A structure is its fields in the order of their numbers, each with the distance to the number
// before and its type in one byte; integers are zigzag varints (specification:
// `doc/specs/thrift-compact-protocol.md` of Thrift).

const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A structure that is being written.
#[derive(Debug, Default)]
struct Struct {
    bytes: Vec<u8>,
    last: u8,
}

impl Struct {
    fn new() -> Self {
        Struct::default()
    }

    /// Fields must come in order of their numbers, at most 15 apart.
    fn field(&mut self, number: u8, kind: u8) {
        self.bytes.push(((number - self.last) << 4) | kind);
        self.last = number;
    }

    fn i32(mut self, number: u8, value: i32) -> Self {
        self.field(number, I32);
        zigzag(&mut self.bytes, i64::from(value));
        self
    }

    fn i64(mut self, number: u8, value: i64) -> Self {
        self.field(number, I64);
        zigzag(&mut self.bytes, value);
        self
    }

    fn text(mut self, number: u8, text: &str) -> Self {
        self.field(number, BINARY);
        binary(&mut self.bytes, text);
        self
    }

    fn inner(mut self, number: u8, inner: Struct) -> Self {
        self.field(number, STRUCT);
        self.bytes.extend(inner.finish());
        self
    }

    fn i32s(mut self, number: u8, values: &[i32]) -> Self {
        self.list(number, I32, values.len());
        values.iter().for_each(|value| zigzag(&mut self.bytes, i64::from(*value)));
        self
    }

    fn texts(mut self, number: u8, texts: &[&str]) -> Self {
        self.list(number, BINARY, texts.len());
        texts.iter().for_each(|text| binary(&mut self.bytes, text));
        self
    }

    fn structs(mut self, number: u8, inner: impl ExactSizeIterator<Item = Struct>) -> Self {
        self.list(number, STRUCT, inner.len());
        inner.for_each(|inner| self.bytes.extend(inner.finish()));
        self
    }

    fn list(&mut self, number: u8, kind: u8, count: usize) {
        self.field(number, LIST);
        match u8::try_from(count) {
            Ok(count @ 0..15) => self.bytes.push((count << 4) | kind),
            _ => {
                self.bytes.push(0xf0 | kind);
                varint(&mut self.bytes, count as u64);
            }
        }
    }

    fn finish(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}

fn binary(bytes: &mut Vec<u8>, text: &str) {
    varint(bytes, text.len() as u64);
    bytes.extend(text.as_bytes());
}

fn zigzag(bytes: &mut Vec<u8>, value: i64) {
    varint(bytes, ((value << 1) ^ (value >> 63)).cast_unsigned());
}

/// Seven bits a byte, the lowest first.
fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

//! A page: which rows have a value, and the values.

use super::thrift::{Struct, varint};
use super::{PLAIN, RLE, Values};
use std::io;

/// The header and the data of a page.
pub(super) fn page(values: &Values) -> io::Result<Vec<u8>> {
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

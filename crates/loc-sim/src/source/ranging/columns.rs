//! Fields that both recordings have.

use crate::Result;
use loc_core::table::Row;
use std::path::Path;

/// A number of something, also where a program wrote it with decimals: `6.000000`.
pub(in crate::source) fn whole(row: &Row<'_>, column: &str) -> Result<u32> {
    let value = row.number(column)?;
    if value >= 0.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX) {
        // A whole number in range.
        return Ok(value as u32);
    }
    Err(row.error(column, "a whole number >= 0", row.text(column)?).into())
}

/// A distance.
pub(in crate::source) fn distance(row: &Row<'_>, column: &str) -> Result<f64> {
    let value = row.number(column)?;
    if value >= 0.0 {
        return Ok(value);
    }
    Err(row.error(column, "a distance >= 0", row.text(column)?).into())
}

/// A stamp that must not be before that of the row above.
pub(in crate::source) fn stamp_after(row: &Row<'_>, column: &str, last: &mut f64) -> Result<f64> {
    let stamp = row.number(column)?;
    if stamp < *last {
        let expected = format!("a time not before {last}, that of the line above");
        return Err(row.error(column, &expected, row.text(column)?).into());
    }
    *last = stamp;
    Ok(stamp)
}

/// Refuses a file without data.
pub(in crate::source) fn not_empty(empty: bool, file: &Path, what: &'static str) -> Result<()> {
    if empty {
        return Err(loc_core::Error::Empty { file: file.to_owned(), what }.into());
    }
    Ok(())
}

//! Rows as CSV (RFC 4180, with line feeds): a null is empty, numbers have every digit they need.

use super::columns::Cell;
use super::parquet::Column;
use std::fmt::Write;

/// The first line.
pub(super) fn header(columns: &[Column]) -> String {
    let cells: Vec<Cell> = columns.iter().map(|c| Cell::Text(c.name.clone())).collect();
    line(&cells)
}

/// A row with its line feed.
pub(super) fn line(cells: &[Cell]) -> String {
    let mut line = String::new();
    for (k, cell) in cells.iter().enumerate() {
        if k > 0 {
            line.push(',');
        }
        // Writing to a String cannot fail.
        let _ = match cell {
            Cell::Null => Ok(()),
            Cell::Bool(value) => write!(line, "{value}"),
            Cell::Integer(value) => write!(line, "{value}"),
            Cell::Seed(value) => write!(line, "{value}"),
            Cell::Number(value) => write!(line, "{value}"),
            Cell::Text(text) => write!(line, "{}", quoted(text)),
        };
    }
    line.push('\n');
    line
}

fn quoted(text: &str) -> String {
    let plain = !text.contains(['"', ',', '\n', '\r']) && !text.is_empty();
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_read_back_by_any_reader() {
        let cells = [
            Cell::Null,
            Cell::Bool(true),
            Cell::Integer(-3),
            Cell::Seed(u64::MAX),
            Cell::Number(0.1 + 0.2),
            Cell::Text("a,\"b\"\n".into()),
            Cell::Text(String::new()),
        ];
        let expected = ",true,-3,18446744073709551615,0.30000000000000004,\"a,\"\"b\"\"\n\",\"\"\n";
        assert_eq!(line(&cells), expected);
    }
}

//! The table of tables.

use super::Table;
use super::value::{Row, Value};

/// The page at which it starts.
pub(super) const ROOT: u32 = 1;

/// The table of a name, where a row of the table of tables (type, name, table, root, SQL) is it.
pub(super) fn table(row: &Row, name: &str) -> Option<Table> {
    let text = |column| match row.value(column) {
        Value::Text(text) => Some(String::from_utf8_lossy(text).into_owned()),
        _ => None,
    };
    if text(0)? != "table" || text(1)? != name {
        return None;
    }
    let Value::Integer(root) = row.value(3) else { return None };
    let definitions = definitions(&text(4)?);
    let is_row_id = |words: &Vec<String>| {
        let tail: Vec<String> = words.iter().skip(1).map(|w| w.to_uppercase()).collect();
        tail.starts_with(&["INTEGER".into(), "PRIMARY".into(), "KEY".into()])
    };
    Some(Table {
        root: u32::try_from(root).ok()?,
        row_id: definitions.iter().position(is_row_id),
        columns: definitions.into_iter().filter_map(|words| words.into_iter().next()).collect(),
    })
}

/// The words of each column of `CREATE TABLE name(column, column, ..)`.
fn definitions(sql: &str) -> Vec<Vec<String>> {
    let inside = sql.split_once('(').map_or("", |(_, rest)| rest);
    let inside = inside.rsplit_once(')').map_or(inside, |(inside, _)| inside);
    let (mut columns, mut column, mut depth) = (Vec::new(), String::new(), 0_u32);
    for letter in inside.chars() {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if letter == ',' && depth == 0 {
            columns.push(std::mem::take(&mut column));
        } else {
            column.push(letter);
        }
    }
    columns.push(column);
    let quotes: &[char] = &['"', '`', '[', ']'];
    let words = |column: String| {
        column.split_whitespace().map(|word| word.trim_matches(quotes).to_owned()).collect()
    };
    columns.into_iter().map(words).collect()
}

//! Text for the terminal that is there: narrow ones too.

use std::ops::Range;

/// The columns of the terminal that standard output is; `None` where it is none.
pub(super) fn width() -> Option<usize> {
    let terminal = console::Term::stdout();
    let (_, columns) = terminal.is_term().then(|| terminal.size_checked()).flatten()?;
    (columns > 0).then_some(columns.into())
}

/// The text in lines of at most `width` columns: tables lose columns on the right, and say so;
/// other lines are broken between words.
pub(super) fn narrow(text: &str, width: usize) -> String {
    let lines: Vec<&str> = text.lines().collect();
    if lines.iter().all(|line| columns(line) <= width) {
        return text.to_owned();
    }
    let mut narrowed = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let rows = lines[at..].iter().take_while(|line| is_row(line)).count();
        if rows > 1 {
            narrowed.extend(table(&lines[at..at + rows], width));
        } else {
            narrowed.extend(wrapped(lines[at], width));
        }
        at += rows.max(1);
    }
    narrowed.join("\n")
}

fn columns(line: &str) -> usize {
    line.chars().count()
}

/// Rows of tables have gaps.
fn is_row(line: &str) -> bool {
    line.trim().contains("  ")
}

/// The rows up to the last gap between columns that fits.
fn table(rows: &[&str], width: usize) -> Vec<String> {
    let rows: Vec<Vec<char>> = rows.iter().map(|row| row.chars().collect()).collect();
    let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if longest <= width {
        return rows.iter().map(|row| row.iter().collect()).collect();
    }
    let is_free = |column: usize| rows.iter().all(|row| row.get(column).is_none_or(|c| *c == ' '));
    let gap = (1..=width).rev().find(|&column| is_free(column) && !is_free(column - 1));
    let cut = |row: &[char], range: Range<usize>| -> String {
        row[range.start.min(row.len())..range.end.min(row.len())].iter().collect()
    };
    let end = gap.unwrap_or(width);
    let mut cut: Vec<String> =
        rows.iter().map(|row| cut(row, 0..end).trim_end().to_owned()).collect();
    cut.extend(wrapped("(more columns in a wider terminal, or with --json)", width));
    cut
}

/// A line broken between words; a word that is too long stays whole.
fn wrapped(line: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in line.split(' ') {
        match lines.last_mut() {
            Some(last) if columns(last) + 1 + columns(word) <= width => {
                last.push(' ');
                last.push_str(word);
            }
            Some(_) => lines.push(format!("  {word}")),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::narrow;

    const TABLE: &str = "a drive of one minute, seed 1\n\
                         method    ATE [m]   sensor\n\
                         ekf         0.152   camera\n\
                         mcl-all    10.024   laser\n\
                         written to out";

    #[test]
    fn what_fits_stays_as_it_is() {
        assert_eq!(narrow(TABLE, 29), TABLE);
    }

    #[test]
    fn tables_lose_whole_columns_and_lines_are_broken() {
        let narrow = narrow(TABLE, 22);
        let lines: Vec<&str> = narrow.lines().collect();
        assert!(lines.iter().all(|line| line.len() <= 22), "{narrow}");
        assert_eq!(lines[..3], ["a drive of one minute,", "  seed 1", "method    ATE [m]"]);
        assert_eq!(lines[4], "mcl-all    10.024");
        assert_eq!(lines[5], "(more columns in a");
        assert_eq!(lines.last(), Some(&"written to out"));
    }

    #[test]
    fn a_word_that_is_too_long_stays_whole() {
        assert_eq!(narrow("written to /a/long/path", 12), "written to\n  /a/long/path");
    }
}

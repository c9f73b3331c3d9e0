use loc_core::Error;
use loc_core::file::{write_beside, write_whole};
use loc_core::table::Table;
use std::fs;

const COLUMNS: [&str; 3] = ["t", "x", "id"];

/// All rows as (t, x, id), or the first error.
fn read(text: &str) -> Result<Vec<(f64, f64, u32)>, Error> {
    let table = Table::parse("log.txt", text, &COLUMNS);
    let read_row = |row: Result<loc_core::table::Row<'_>, Error>| {
        let row = row?;
        Ok((row.number("t")?, row.number("x")?, row.whole_number("id")?))
    };
    table.rows().map(read_row).collect()
}

/// The message of the error that a text must cause.
fn refused(text: &str) -> String {
    match read(text) {
        Err(error @ Error::Parse { .. }) => error.to_string(),
        other => panic!("{text:?} gave {other:?}"),
    }
}

#[test]
fn separators_comments_headers_and_line_ends() {
    let expected = vec![(0.0, 1.5, 7), (0.1, -2e-3, 8)];
    for text in [
        "0 1.5 7\n0.1 -2e-3 8\n",
        "0 1.5 7\n0.1 -2e-3 8",
        "0,1.5,7\n0.1,-2e-3,8\n",
        "0, 1.5 ,\t7\r\n0.1, -2e-3, 8\r\n",
        "  0\t1.5   7  \n\n \t \n0.1 -2e-3 8\n",
        "# a comment\n#another, with, commas\nt x id\n0 1.5 7\n0.1 -2e-3 8\n",
        "t,x,id\r\n0,1.5,7\r\n# between\r\n0.1,-2e-3,8\r\n",
        "t, x, id\n+0 1.5 7\n1e-1 -.002 8\n",
    ] {
        assert_eq!(read(text).unwrap(), expected, "{text:?}");
    }
}

#[test]
fn nothing_is_no_row() {
    for text in ["", "\n\n", "# only a comment", "t x id\n", "\r\n"] {
        assert_eq!(read(text).unwrap(), [], "{text:?}");
    }
}

#[test]
fn fields_that_are_no_finite_numbers() {
    for bad in
        ["NaN", "nan", "inf", "-inf", "infinity", "1e999", "abc", "1.2.3", "0x10", "1_0", "--1"]
    {
        let message = refused(&format!("0 1 2\n0 {bad} 2\n"));
        let expected = format!("log.txt:2: x: expected a finite number, got `{bad}`");
        assert_eq!(message, expected);
    }
    assert_eq!(refused("0,,2"), "log.txt:1: x: expected a finite number, got ``");
    assert_eq!(refused("0,1 5,2"), "log.txt:1: x: expected a finite number, got `1 5`");
    assert_eq!(refused("0 \u{fc} 2"), "log.txt:1: x: expected a finite number, got `\u{fc}`");
}

#[test]
fn fields_that_are_no_whole_numbers() {
    for bad in ["-1", "1.0", "4294967296", "1e3", "x"] {
        let message = refused(&format!("# first\n0 1 {bad}"));
        let expected = format!("log.txt:2: id: expected a whole number >= 0, got `{bad}`");
        assert_eq!(message, expected);
    }
}

#[test]
fn lines_of_the_wrong_length() {
    assert_eq!(
        refused("0 1 2\n0 1"),
        "log.txt:2: id: expected a value, got the end of the line after 2 columns"
    );
    assert_eq!(
        refused("0"),
        "log.txt:1: x: expected a value, got the end of the line after 1 columns"
    );
    assert_eq!(refused("0 1 2 3"), "log.txt:1: line: expected 3 columns (t x id), got 4 columns");
    assert!(refused("0,1,2,").contains("got 4 columns"));
    assert!(refused("t x\n").contains("id: expected a value"), "half a header is a short line");
}

#[test]
fn optional_columns() {
    let table = Table::parse("log.txt", "0 1\n0 1 2\n", &COLUMNS).with_optional(1);
    let rows: Vec<_> = table.rows().collect::<Result<_, _>>().unwrap();
    assert_eq!(rows[0].optional_text("id"), None);
    assert_eq!(rows[1].optional_text("id"), Some("2"));
    assert_eq!((rows[0].line(), rows[1].line()), (1, 2));
    let message = rows[0].number("id").unwrap_err().to_string();
    assert_eq!(message, "log.txt:1: id: expected a value, got `the end of the line`");
    let header = Table::parse("log.txt", "t x\n0 1\n", &COLUMNS).with_optional(9);
    assert_eq!(header.rows().count(), 1);
    assert!(header.rows().all(|row| row.unwrap().number("unknown").is_err()));
}

#[test]
fn an_error_does_not_end_the_reading() {
    let table = Table::parse("log.txt", "0\n0 1 2\n", &COLUMNS);
    let rows: Vec<bool> = table.rows().map(|row| row.is_ok()).collect();
    assert_eq!(rows, [false, true]);
}

#[test]
fn files_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.txt");
    let error = Table::read(&missing, &COLUMNS).unwrap_err();
    assert!(matches!(&error, Error::Io { path, .. } if *path == missing), "{error}");
    let binary = folder.path().join("binary.txt");
    std::fs::write(&binary, [0xff, 0xfe, 0x00]).unwrap();
    assert!(matches!(Table::read(&binary, &COLUMNS), Err(Error::Io { .. })));
    let good = folder.path().join("good.txt");
    std::fs::write(&good, "0 1 2\n").unwrap();
    let table = Table::read(&good, &COLUMNS).unwrap();
    assert_eq!((table.file(), table.rows().count()), (good.as_path(), 1));
}

#[test]
fn what_fails_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.txt");
    write_whole(&file, "first").unwrap();
    let failed: Result<(), loc_core::Error> = write_beside(&file, |part| {
        fs::write(part, "half").unwrap();
        Err(loc_core::Error::io(part)(std::io::Error::other("full")))
    });
    assert!(failed.is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), "first");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let error = write_whole(folder.path(), "x").unwrap_err().to_string();
    assert!(error.starts_with(&folder.path().display().to_string()), "{error}");
}

/// A pipe stays one: its reader gets the bytes.
#[cfg(unix)]
#[test]
fn a_pipe_is_written_to_and_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: no mkfifo");
        return;
    }
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read_to_string(pipe).unwrap()
    });
    write_whole(&pipe, "through").unwrap();
    assert_eq!(reader.join().unwrap(), "through");
    assert!(!fs::metadata(&pipe).unwrap().is_file());
}

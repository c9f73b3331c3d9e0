//! Parquet files are read back by a small reader written from the specification alone, and by
//! pyarrow where Python has it.

use loc_sim::localizer::Method;
use loc_sim::study::parquet::{Column, Kind, Values, Writer};
use std::collections::BTreeMap;
use std::process::Command;

/// A value of Thrift's compact protocol.
#[derive(Debug, Clone)]
enum Thrift {
    Integer(i64),
    Binary(Vec<u8>),
    List(Vec<Thrift>),
    Struct(BTreeMap<i64, Thrift>),
}

struct Reader<'a>(&'a [u8], usize);

impl Reader<'_> {
    fn byte(&mut self) -> u8 {
        self.1 += 1;
        self.0[self.1 - 1]
    }
    fn varint(&mut self) -> u64 {
        let (mut value, mut shift) = (0, 0);
        loop {
            let byte = self.byte();
            value |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte < 0x80 {
                return value;
            }
        }
    }
    fn integer(&mut self) -> i64 {
        let value = self.varint();
        (value >> 1) as i64 ^ -((value & 1) as i64)
    }
    fn value(&mut self, kind: u8) -> Thrift {
        match kind {
            5 | 6 => Thrift::Integer(self.integer()),
            8 => {
                let length = self.varint() as usize;
                self.1 += length;
                Thrift::Binary(self.0[self.1 - length..self.1].to_vec())
            }
            9 => {
                let head = self.byte();
                let count = if head >> 4 == 15 { self.varint() } else { u64::from(head >> 4) };
                Thrift::List((0..count).map(|_| self.value(head & 15)).collect())
            }
            12 => self.object(),
            kind => panic!("type {kind}"),
        }
    }
    fn object(&mut self) -> Thrift {
        let (mut fields, mut number) = (BTreeMap::new(), 0);
        loop {
            let head = self.byte();
            if head == 0 {
                return Thrift::Struct(fields);
            }
            number += i64::from(head >> 4);
            fields.insert(number, self.value(head & 15));
        }
    }
}

impl Thrift {
    fn get(&self, number: i64) -> &Thrift {
        let Thrift::Struct(fields) = self else { panic!("no struct") };
        &fields[&number]
    }
    fn list(&self) -> &[Thrift] {
        let Thrift::List(list) = self else { panic!("no list") };
        list
    }
    fn integer(&self) -> i64 {
        let Thrift::Integer(value) = self else { panic!("no integer") };
        *value
    }
    fn text(&self) -> String {
        let Thrift::Binary(bytes) = self else { panic!("no text") };
        String::from_utf8(bytes.clone()).unwrap()
    }
}

/// Columns of one page each: name and cells as text, null as `-`.
fn read(bytes: &[u8]) -> Vec<(String, Vec<String>)> {
    let count = bytes.len();
    assert_eq!((&bytes[..4], &bytes[count - 4..]), (&b"PAR1"[..], &b"PAR1"[..]));
    let length = u32::from_le_bytes(bytes[count - 8..count - 4].try_into().unwrap()) as usize;
    let footer = Reader(bytes, count - 8 - length).object();
    let schema = footer.get(2).list();
    assert_eq!(schema[0].get(5).integer() as usize, schema.len() - 1);
    let mut table: Vec<(String, Vec<String>)> =
        schema[1..].iter().map(|element| (element.get(4).text(), Vec::new())).collect();
    let mut total = 0;
    for group in footer.get(4).list() {
        total += group.get(3).integer();
        for (chunk, (name, cells)) in group.get(1).list().iter().zip(&mut table) {
            let data = chunk.get(3);
            assert_eq!(data.get(3).list()[0].text(), *name);
            let mut reader = Reader(bytes, data.get(9).integer() as usize);
            let begin = reader.1;
            let header = reader.object();
            let rows = header.get(5).get(1).integer() as usize;
            let end = reader.1 + header.get(3).integer() as usize;
            assert_eq!(data.get(7).integer() as usize, end - begin);
            cells.extend(page(&bytes[reader.1..end], data.get(1).integer(), rows));
        }
    }
    assert_eq!(footer.get(3).integer(), total);
    table
}

fn page(bytes: &[u8], kind: i64, rows: usize) -> Vec<String> {
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    let mut levels = Reader(bytes, 4);
    let mut present = Vec::new();
    while levels.1 < 4 + length {
        let run = levels.varint();
        assert_eq!(run & 1, 0, "a run, not packed bits");
        present.extend(std::iter::repeat_n(levels.byte() == 1, (run >> 1) as usize));
    }
    assert_eq!(present.len(), rows);
    let (mut rest, mut bit) = (&bytes[4 + length..], 0);
    let mut take = |count: usize| {
        let (head, tail) = rest.split_at(count);
        rest = tail;
        head.to_vec()
    };
    let mut eight = 0;
    let cell = |present: bool| {
        if !present {
            return "-".to_owned();
        }
        match kind {
            0 => {
                if bit % 8 == 0 {
                    eight = take(1)[0];
                }
                bit += 1;
                (eight >> ((bit - 1) % 8) & 1 == 1).to_string()
            }
            2 => i64::from_le_bytes(take(8).try_into().unwrap()).to_string(),
            5 => f64::from_le_bytes(take(8).try_into().unwrap()).to_string(),
            6 => {
                let length = u32::from_le_bytes(take(4).try_into().unwrap()) as usize;
                String::from_utf8(take(length)).unwrap()
            }
            kind => panic!("type {kind}"),
        }
    };
    let cells = present.into_iter().map(cell).collect();
    assert!(rest.is_empty(), "all bytes are used");
    cells
}

fn columns() -> Vec<Column> {
    vec![
        Column::new("ok", Kind::Bool),
        Column::new("n", Kind::Integer),
        Column::new("seed", Kind::Unsigned),
        Column::new("filter.x", Kind::Number),
        Column::new("text", Kind::Text),
    ]
}

/// Two row groups with nulls in all places, and more than 8 truth values.
fn example() -> Vec<u8> {
    let mut writer = Writer::new(Vec::new(), columns()).unwrap();
    let bools: Vec<_> = (0..11).map(|k| (k % 4 != 1).then_some(k % 3 == 0)).collect();
    let integers = (0..11).map(|k| (k > 2).then_some(k - 7)).collect();
    let seeds = (0..11).map(|k| (k < 9).then_some(u64::MAX - k)).collect();
    let numbers = (0..11).map(|k| Some(0.1 * f64::from(k))).collect();
    let texts = (0..11).map(|k| (k % 2 == 0).then(|| format!("ä{k}"))).collect();
    let first = [
        Values::Bool(bools),
        Values::Integer(integers),
        Values::Unsigned(seeds),
        Values::Number(numbers),
        Values::Text(texts),
    ];
    writer.rows(&first).unwrap();
    let second = [
        Values::Bool(vec![None]),
        Values::Integer(vec![Some(i64::MIN)]),
        Values::Unsigned(vec![None]),
        Values::Number(vec![Some(-1e-300)]),
        Values::Text(vec![Some(String::new())]),
    ];
    writer.rows(&second).unwrap();
    writer.finish().unwrap()
}

#[test]
fn a_file_is_read_back_value_by_value() {
    let table = read(&example());
    let names: Vec<&str> = table.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["ok", "n", "seed", "filter.x", "text"]);
    assert_eq!(table[0].1.join(" "), "true - false true false - true false false - false -");
    assert_eq!(table[1].1.join(" "), "- - - -4 -3 -2 -1 0 1 2 3 -9223372036854775808");
    assert_eq!(table[2].1[..3], ["-1", "-2", "-3"], "as signed numbers");
    assert_eq!(table[3].1[3], "0.30000000000000004");
    assert_eq!(table[3].1[11].parse::<f64>().unwrap(), -1e-300);
    assert_eq!(table[4].1[10..], ["ä10", ""]);
}

/// What a study writes: the Parquet file holds the table, cell by cell, nulls and texts included.
#[test]
fn the_file_of_a_study_is_its_table() {
    let methods = [Method::DeadReckoning, Method::Ekf];
    let study = super::drive(5, &["camera.range_sigma=0.05,0.2"], &methods);
    let folder = tempfile::TempDir::new().unwrap();
    assert!(study.run(folder.path(), 2, &mut |_| true).unwrap());
    study.write(folder.path(), "test").unwrap();
    let table = read(&std::fs::read(folder.path().join("runs.parquet")).unwrap());
    let csv = std::fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names: Vec<&str> = table.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(lines.next().unwrap(), names);
    let rows: Vec<Vec<&str>> = lines.collect();
    assert_eq!(rows.len(), 2 * 5 * 2);
    let mut nulls = 0;
    for (k, row) in rows.iter().enumerate() {
        let cells = table.iter().map(|(_, cells)| if cells[k] == "-" { "" } else { &cells[k] });
        assert!(row.iter().copied().eq(cells), "row {k}: {row:?}");
        nulls += row.iter().filter(|cell| cell.is_empty()).count();
    }
    assert!(nulls > 0 && table.iter().all(|(_, cells)| cells.len() == rows.len()));
}

#[test]
fn a_table_without_rows_is_a_file_too() {
    let mut writer = Writer::new(Vec::new(), columns()).unwrap();
    writer
        .rows(&[
            Values::Bool(vec![]),
            Values::Integer(vec![]),
            Values::Unsigned(vec![]),
            Values::Number(vec![]),
            Values::Text(vec![]),
        ])
        .unwrap();
    assert!(read(&writer.finish().unwrap()).iter().all(|(_, cells)| cells.is_empty()));
    assert!(read(&Writer::new(Vec::new(), vec![]).unwrap().finish().unwrap()).is_empty());
}

/// Many columns need the long form of a list.
#[test]
fn many_columns_and_many_rows() {
    let columns: Vec<Column> =
        (0..40).map(|k| Column::new(format!("c{k}"), Kind::Integer)).collect();
    let mut writer = Writer::new(Vec::new(), columns).unwrap();
    let values: Vec<Values> =
        (0..40).map(|k| Values::Integer((0..300).map(|row| Some(row * k)).collect())).collect();
    writer.rows(&values).unwrap();
    let table = read(&writer.finish().unwrap());
    assert_eq!((table.len(), table[39].1.len(), table[39].1[299].as_str()), (40, 300, "11661"));
}

#[test]
fn values_that_are_not_the_columns_are_refused() {
    let mut writer =
        Writer::new(Vec::new(), vec![Column::new("a", Kind::Bool), Column::new("b", Kind::Bool)])
            .unwrap();
    for values in [
        vec![Values::Bool(vec![])],
        vec![Values::Bool(vec![None]), Values::Number(vec![None])],
        vec![Values::Bool(vec![None]), Values::Bool(vec![])],
    ] {
        assert_eq!(writer.rows(&values).unwrap_err().kind(), std::io::ErrorKind::InvalidInput);
    }
}

/// The judge of the format: `LOC_PYTHON` names a Python with pyarrow.
#[test]
fn pyarrow_reads_it() {
    let python = std::env::var("LOC_PYTHON").unwrap_or("python3".into());
    let has = Command::new(&python).args(["-c", "import pyarrow.parquet"]).output();
    if !has.is_ok_and(|output| output.status.success()) {
        println!("skipped: {python} has no pyarrow");
        return;
    }
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), example()).unwrap();
    let script = "import sys, pyarrow.parquet as p; t = p.read_table(sys.argv[1]); \
                  print([str(f.type) for f in t.schema]); \
                  print([t.slice(k, 1).to_pylist()[0]['seed'] for k in (0, 8, 9)]); \
                  print(t.to_pylist()[11]); print(t['ok'].to_pylist())";
    let output = Command::new(&python).args(["-c", script]).arg(file.path()).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let expected = "['bool', 'int64', 'uint64', 'double', 'string']\n\
                    [18446744073709551615, 18446744073709551607, None]\n\
                    {'ok': None, 'n': -9223372036854775808, 'seed': None, 'filter.x': -1e-300, 'text': ''}\n\
                    [True, None, False, True, False, None, True, False, False, None, False, None]\n";
    assert_eq!(text, expected, "{}", String::from_utf8_lossy(&output.stderr));
}

//! Small databases of SQLite, as bags of ROS 2 are, written here byte by byte.

/// Bytes of a page; no table here needs a second one.
const PAGE: usize = 8192;

/// What a row holds.
enum Value<'a> {
    /// Stands for the number of the row.
    Null,
    Integer(i64),
    Text(&'a str),
    Blob(&'a [u8]),
}

/// A bag with topics (number, name, type) and messages (topic, time \[ns\], data).
pub(crate) fn database(topics: &[(i64, &str, &str)], messages: &[(i64, i64, &[u8])]) -> Vec<u8> {
    let topics: Vec<_> = topics
        .iter()
        .map(|(id, name, kind)| {
            cell(*id, &[Value::Null, Value::Text(name), Value::Text(kind), Value::Text("cdr")])
        })
        .collect();
    let messages: Vec<_> = (1..)
        .zip(messages)
        .map(|(id, (topic, time, data))| {
            let (topic, time) = (Value::Integer(*topic), Value::Integer(*time));
            cell(id, &[Value::Null, topic, time, Value::Blob(data)])
        })
        .collect();
    let tables = [
        ("topics", 2, "id INTEGER PRIMARY KEY,name TEXT,type TEXT,serialization_format TEXT"),
        ("messages", 3, "id INTEGER PRIMARY KEY,topic_id INTEGER,timestamp INTEGER,data BLOB"),
    ];
    let schema = tables.map(|(name, root, columns)| {
        let sql = format!("CREATE TABLE {name}({columns})");
        let text = Value::Text;
        cell(root, &[text("table"), text(name), text(name), Value::Integer(root), text(&sql)])
    });
    let mut first = page(100, &schema);
    first[..16].copy_from_slice(b"SQLite format 3\0");
    first[16..18].copy_from_slice(&(PAGE as u16).to_be_bytes());
    first[18..24].copy_from_slice(&[1, 1, 0, 64, 32, 32]);
    first[59] = 1;
    [first, page(0, &topics), page(0, &messages)].concat()
}

/// A leaf of a table's tree; its head is at `head`.
fn page(head: usize, cells: &[Vec<u8>]) -> Vec<u8> {
    let mut page = vec![0; PAGE];
    let mut end = PAGE;
    page[head] = 0x0d;
    page[head + 3..head + 5].copy_from_slice(&(cells.len() as u16).to_be_bytes());
    for (index, cell) in cells.iter().enumerate() {
        end -= cell.len();
        page[end..end + cell.len()].copy_from_slice(cell);
        let pointer = head + 8 + 2 * index;
        page[pointer..pointer + 2].copy_from_slice(&(end as u16).to_be_bytes());
        assert!(pointer + 2 < end, "the rows of a table fit on one page");
    }
    page[head + 5..head + 7].copy_from_slice(&(end as u16).to_be_bytes());
    page
}

fn cell(id: i64, row: &[Value<'_>]) -> Vec<u8> {
    let (mut kinds, mut values) = (Vec::new(), Vec::new());
    for value in row {
        match value {
            Value::Null => kinds.extend(varint(0)),
            Value::Integer(number) => {
                kinds.extend(varint(6));
                values.extend(number.to_be_bytes());
            }
            Value::Text(text) => {
                kinds.extend(varint(13 + 2 * text.len() as u64));
                values.extend(text.as_bytes());
            }
            Value::Blob(blob) => {
                kinds.extend(varint(12 + 2 * blob.len() as u64));
                values.extend(*blob);
            }
        }
    }
    let record = [varint(1 + kinds.len() as u64), kinds, values].concat();
    [varint(record.len() as u64), varint(id as u64), record].concat()
}

/// A number in groups of seven bits, the highest first.
pub(crate) fn varint(number: u64) -> Vec<u8> {
    let groups = (0..9).rev().map(|k| (number >> (7 * k)) as u8 & 0x7f);
    let mut bytes: Vec<u8> = groups.skip_while(|group| *group == 0).collect();
    if bytes.is_empty() {
        bytes.push(0);
    }
    let last = bytes.len() - 1;
    bytes[..last].iter_mut().for_each(|byte| *byte |= 0x80);
    bytes
}

//! A file `.db3`: tables `topics` and `messages` of a SQLite database.

use crate::Result;
use crate::source::ros::bag::{Channel, Encoding, MessageReader, RawMessage};
use crate::source::ros::sqlite::{Database, Row, Table, TableScan, Value};
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::Path;

/// A database of messages, read row by row in the order in which they were written.
#[derive(Debug)]
pub struct Database3 {
    database: Database,
    channels: Vec<Channel>,
    /// Index of the channel of each topic.
    topics: BTreeMap<i64, usize>,
    messages: Table,
    /// Columns of topic, time and data.
    columns: [usize; 3],
    scan: TableScan,
    row: Row,
    without_topic: u64,
}

impl Database3 {
    /// Opens a file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`crate::Error::Recording`] for a file that is no such database.
    pub fn open(path: &Path) -> Result<Self> {
        Database3::new(Database::open(path)?)
    }

    /// A database from anything that can be read; `path` is only named in errors.
    ///
    /// # Errors
    /// As [`Database3::open`].
    pub fn read(path: &Path, bytes: impl Read + Seek + 'static) -> Result<Self> {
        Database3::new(Database::read(path, bytes)?)
    }

    fn new(mut database: Database) -> Result<Self> {
        let (channels, topics) = topics(&mut database)?;
        let (messages, columns) =
            table(&mut database, "messages", ["topic_id", "timestamp", "data"])?;
        let scan = messages.scan();
        Ok(Database3 {
            database,
            channels,
            topics,
            messages,
            columns,
            scan,
            row: Row::default(),
            without_topic: 0,
        })
    }

    /// Reads rows until there is a message: its channel and its time.
    fn advance(&mut self) -> Result<Option<(usize, i64)>> {
        while let Some(row) = self.database.next(&mut self.scan)? {
            self.row = row;
            let value = |column| self.messages.value(&self.row, column);
            let [topic, time, _] = self.columns;
            let (Value::Integer(topic), Value::Integer(time)) = (value(topic), value(time)) else {
                self.without_topic += 1;
                continue;
            };
            match self.topics.get(&topic) {
                Some(channel) => return Ok(Some((*channel, time))),
                None => self.without_topic += 1,
            }
        }
        Ok(None)
    }
}

/// A table with the places of some of its columns.
fn table<const N: usize>(
    database: &mut Database,
    name: &str,
    columns: [&str; N],
) -> Result<(Table, [usize; N])> {
    let Some(table) = database.table(name)? else {
        return Err(database.error(&format!("a table `{name}`, as bags of ROS 2 have"), "none"));
    };
    let mut places = [0; N];
    for (place, column) in places.iter_mut().zip(columns) {
        *place = table.column(column).ok_or_else(|| {
            database.error(&format!("a column `{column}` of the table `{name}`"), "none")
        })?;
    }
    Ok((table, places))
}

type Topics = (Vec<Channel>, BTreeMap<i64, usize>);

fn topics(database: &mut Database) -> Result<Topics> {
    let names = ["id", "name", "type", "serialization_format"];
    let (table, columns) = table(database, "topics", names)?;
    let (mut channels, mut topics) = (Vec::new(), BTreeMap::new());
    let mut scan = table.scan();
    while let Some(row) = database.next(&mut scan)? {
        let text = |column| match table.value(&row, column) {
            Value::Text(text) => String::from_utf8_lossy(text).into_owned(),
            _ => String::new(),
        };
        let [id, name, type_name, format] = columns;
        if let Value::Integer(id) = table.value(&row, id) {
            topics.insert(id, channels.len());
            channels.push(Channel {
                topic: text(name),
                type_name: text(type_name),
                encoding: Encoding::named(&text(format)),
            });
        }
    }
    Ok((channels, topics))
}

impl MessageReader for Database3 {
    fn path(&self) -> &Path {
        self.database.path()
    }

    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn next_message(&mut self) -> Result<Option<RawMessage<'_>>> {
        let Some((channel, log_time)) = self.advance()? else { return Ok(None) };
        let data = match self.messages.value(&self.row, self.columns[2]) {
            Value::Blob(data) | Value::Text(data) => data,
            _ => &[],
        };
        Ok(Some(RawMessage { channel, log_time, data }))
    }

    fn progress(&self) -> f64 {
        self.database.progress()
    }

    fn notes(&self) -> Vec<String> {
        let breaks_off = self
            .database
            .breaks_off()
            .map(|page| format!("breaks off before page {page} of the database: read up to there"));
        let count = self.without_topic;
        let without = (count > 0).then(|| format!("{count} messages without a topic passed over"));
        breaks_off.into_iter().chain(without).collect()
    }
}

//! `loc-sim info` lists the content of a recording.

use super::Global;
use super::console::Progress;
use super::replay::{Format, guess, open_landmarks};
use crate::source::carmen::CarmenLog;
use crate::source::laser_log::LaserLog;
use crate::source::ranging::{RangeRecording, RangingStart};
use crate::source::wean::WeanLog;
use crate::source::{Mrclam, Source};
use loc_filters::slam::Identities;
use loc_ros::Survey;
use loc_sensors::event::{Control, Measurement, Payload};
use std::path::{Path, PathBuf};

/// List the topics of a recording, with types, numbers, times and rates.
#[derive(Debug, Clone, clap::Args)]
pub struct InfoArgs {
    /// The recording, of any format that `replay` knows.
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// The format of the recording; found by its contents where left out.
    #[arg(long, value_name = "F")]
    pub format: Option<Format>,
}

/// A topic, or a kind of message in a format without topics.
#[derive(Debug, Clone, Default, serde::Serialize)]
struct Row {
    topic: String,
    #[serde(rename = "type")]
    kind: String,
    count: u64,
    bytes: Option<u64>,
    start_s: Option<f64>,
    end_s: Option<f64>,
    rate_hz: Option<f64>,
}

#[derive(Debug, serde::Serialize)]
struct Info {
    log: PathBuf,
    format: String,
    start_s: Option<f64>,
    duration_s: Option<f64>,
    messages: u64,
    topics: Vec<Row>,
    notes: Vec<String>,
}

/// Reads a recording to its end and prints its content.
///
/// # Errors
/// What is wrong with the recording.
pub fn info(args: &InfoArgs, global: &Global) -> anyhow::Result<()> {
    let log = args.log.as_path();
    let format = args.format.map_or_else(|| guess(log), Ok)?;
    let (topics, notes) = match format {
        Format::Ros => bag(log, global)?,
        Format::Mrclam => mrclam(log)?,
        Format::UwbLabyrinth => ranges(RangeRecording::labyrinth(log, &RangingStart::default())?)?,
        Format::Plaza => ranges(RangeRecording::plaza(log, 1, &RangingStart::default())?)?,
        Format::LandmarkCourse | Format::KfSlamDemo | Format::VictoriaPark => {
            let source = open_landmarks(log, format, Identities::Known, [0.0; 3])?;
            beacons(source, ["pose", "landmarks", "distances and directions"])?
        }
        Format::Carmen => entries(&CarmenLog::open(log)?.laser_log()?),
        Format::Wean => entries(&WeanLog::open(log)?.laser_log()?),
    };
    let least = |a: f64, b: f64| a.min(b);
    let start_s = topics.iter().filter_map(|row| row.start_s).reduce(least);
    let end_s = topics.iter().filter_map(|row| row.end_s).reduce(f64::max);
    let info = Info {
        log: log.to_owned(),
        format: format!("{format:?}").to_lowercase(),
        start_s,
        duration_s: start_s.zip(end_s).map(|(start, end)| end - start),
        messages: topics.iter().map(|row| row.count).sum(),
        topics,
        notes,
    };
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return super::print(&serde_json::to_string_pretty(&info)?);
    }
    super::print(&table(&info))
}

fn table(info: &Info) -> String {
    let duration = info.duration_s.map_or("no time".into(), |s| format!("{s:.1} s"));
    let start = info.start_s.map_or(String::new(), |s| format!(" from {s:.3} s"));
    let mut lines = vec![format!(
        "{}: {}, {} messages, {duration}{start}",
        info.log.display(),
        info.format,
        info.messages
    )];
    let width = |text: fn(&Row) -> &str, least: usize| {
        info.topics.iter().map(|row| text(row).chars().count()).max().unwrap_or(0).max(least)
    };
    let (topic, kind) = (width(|row| &row.topic, 5), width(|row| &row.kind, 4));
    lines.push(format!(
        "{:topic$}  {:kind$}  {:>8}  {:>9}  {:>9}",
        "topic", "type", "messages", "rate [Hz]", "span [s]"
    ));
    for row in &info.topics {
        let rate = row.rate_hz.map_or("-".into(), |rate| format!("{rate:.2}"));
        let span = row.start_s.zip(row.end_s).map(|(start, end)| end - start);
        let span = span.map_or("-".into(), |span| format!("{span:.1}"));
        lines.push(format!(
            "{:topic$}  {:kind$}  {:>8}  {rate:>9}  {span:>9}",
            row.topic, row.kind, row.count
        ));
    }
    lines.extend(info.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n")
}

type Found = (Vec<Row>, Vec<String>);

fn bag(log: &Path, global: &Global) -> anyhow::Result<Found> {
    let mut bag = loc_ros::open(log)?;
    let mut progress = Progress::new("info", global);
    let survey = Survey::of(bag.as_mut(), &mut |_, _| {}, &mut |share| progress.update(share))?;
    progress.finish();
    let row = |topic: loc_ros::Topic| Row {
        rate_hz: topic.rate(),
        topic: topic.channel.topic,
        kind: topic.channel.type_name,
        count: topic.count,
        bytes: Some(topic.bytes),
        start_s: topic.span.map(|span| span.0.seconds()),
        end_s: topic.span.map(|span| span.1.seconds()),
    };
    let mut topics: Vec<Row> = survey.topics.into_iter().map(row).collect();
    topics.sort_by(|a, b| a.topic.cmp(&b.topic));
    Ok((topics, survey.notes))
}

/// Counts messages by name.
#[derive(Default)]
struct Counter(Vec<Row>);

impl Counter {
    fn take(&mut self, topic: &str, kind: &str, stamp: f64) {
        let known = self.0.iter().position(|row| row.topic == topic);
        let index = known.unwrap_or_else(|| {
            let (topic, kind) = (topic.to_owned(), kind.to_owned());
            self.0.push(Row { topic, kind, ..Row::default() });
            self.0.len() - 1
        });
        let row = &mut self.0[index];
        row.count += 1;
        row.start_s = Some(row.start_s.map_or(stamp, |start| start.min(stamp)));
        row.end_s = Some(row.end_s.map_or(stamp, |end| end.max(stamp)));
    }

    fn finish(mut self) -> Vec<Row> {
        for row in &mut self.0 {
            let span = row.start_s.zip(row.end_s).map_or(0.0, |(start, end)| end - start);
            row.rate_hz = (span > 0.0).then(|| (row.count - 1) as f64 / span);
        }
        self.0
    }
}

fn entries(log: &LaserLog) -> Found {
    let mut counter = Counter::default();
    for entry in &log.entries {
        let (topic, kind) = match entry.payloads.as_slice() {
            [Payload::Control(_)] => ("odometry", "pose"),
            [Payload::Truth(_)] => ("truth", "pose"),
            _ if !entry.has_scan() => ("other", "measurement"),
            _ if entry.truth().is_some() => ("laser", "scan with a corrected pose"),
            _ => ("laser", "scan"),
        };
        counter.take(topic, kind, entry.stamp);
    }
    (counter.finish(), log.notes.clone())
}

/// All robots of a folder of MRCLAM.
fn mrclam(log: &Path) -> anyhow::Result<Found> {
    let mut counter = Counter::default();
    let mut notes = Vec::new();
    for robot in 1..=5 {
        if !log.join(format!("Robot{robot}_Odometry.dat")).is_file() {
            continue;
        }
        let mut source = Mrclam::open(log, robot)?;
        while let Some(event) = source.next_event()? {
            let (topic, kind) = match &event.payload {
                Payload::Control(Control::Velocity(_)) => ("odometry", "velocity"),
                Payload::Measurement(Measurement::Landmarks(_)) => {
                    ("landmarks", "range and bearing")
                }
                Payload::Truth(_) => ("truth", "pose"),
                _ => ("other", ""),
            };
            counter.take(&format!("robot {robot}: {topic}"), kind, event.stamp);
        }
        notes.extend(source.notes().into_iter().map(|note| format!("robot {robot}: {note}")));
    }
    Ok((counter.finish(), notes))
}

/// The events of a recording of ranges.
fn ranges(source: RangeRecording) -> anyhow::Result<Found> {
    beacons(source, ["velocity", "ranges", "range to a beacon"])
}

/// A recording of odometry and of observations of beacons or landmarks; `names` are their types
/// and the name of the latter.
fn beacons(mut source: impl Source, names: [&'static str; 3]) -> anyhow::Result<Found> {
    let [odometry, topic, measured] = names;
    let mut counter = Counter::default();
    let heading = source.truth_has_heading();
    while let Some(event) = source.next_event()? {
        let (topic, kind) = match &event.payload {
            Payload::Control(_) => ("odometry", odometry),
            Payload::Measurement(_) => (topic, measured),
            Payload::Truth(_) if heading => ("truth", "pose"),
            Payload::Truth(_) => ("truth", "position"),
        };
        counter.take(topic, kind, event.stamp);
    }
    Ok((counter.finish(), source.notes()))
}

//! What the fuzz targets share: reading to the end, and parsers that want files.
//!
//! A target hands bytes to a parser and lets go of what comes out; a panic, an overflow, too much
//! memory or too much time is the finding. Errors are welcome.

use loc_ros::messages::Message;
use loc_ros::{Dialect, Encoding, MessageReader, messages};
use loc_sim::source::Source;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Between the parts of an input that stands for several files.
const BETWEEN_FILES: u8 = 0;

/// Reads a bag to its end, or to its first error.
pub fn drain(bag: loc_ros::Result<impl MessageReader>) {
    let Ok(mut bag) = bag else { return };
    while let Ok(Some(message)) = bag.next_message() {
        let channel = message.channel;
        assert!(channel < bag.channels().len(), "a message of a channel that is known");
        assert!((0.0..=1.0).contains(&bag.progress()));
    }
    bag.notes();
}

/// Reads a recording to its end, or to its first error: events in order, without NaN in a stamp.
pub fn replay(source: loc_sim::Result<impl Source>) {
    let Ok(mut source) = source else { return };
    let mut last = f64::NEG_INFINITY;
    while let Ok(Some(event)) = source.next_event() {
        assert!(event.arrival >= last, "{} after {last}", event.arrival);
        last = event.arrival;
    }
    source.notes();
}

/// Decodes a message as the type that the first byte picks. What comes out must survive being
/// written and read once more in any dialect, bit by bit.
pub fn message(data: &[u8], encoding: &Encoding) {
    let Some((kind, bytes)) = data.split_first() else { return };
    match kind % 14 {
        0 => drop(round_trip::<messages::LaserScan>(bytes, encoding)),
        1 => {
            let scan = round_trip::<messages::MultiEchoLaserScan>(bytes, encoding);
            scan.map(|scan| scan.first_echo());
        }
        2 => drop(round_trip::<messages::Odometry>(bytes, encoding)),
        3 => drop(round_trip::<messages::TfMessage>(bytes, encoding)),
        4 => drop(round_trip::<messages::Imu>(bytes, encoding)),
        5 => drop(round_trip::<messages::NavSatFix>(bytes, encoding)),
        6 => {
            let cloud = round_trip::<messages::PointCloud2>(bytes, encoding);
            cloud.map(|cloud| cloud.slice(&messages::Slice::default()));
        }
        7 => drop(round_trip::<messages::PoseWithCovarianceStamped>(bytes, encoding)),
        8 => drop(round_trip::<messages::OccupancyGrid>(bytes, encoding)),
        9 => drop(round_trip::<messages::Path>(bytes, encoding)),
        10 => drop(round_trip::<messages::PoseArray>(bytes, encoding)),
        11 => drop(round_trip::<messages::PoseStamped>(bytes, encoding)),
        12 => drop(round_trip::<messages::ParticleCloud>(bytes, encoding)),
        _ => drop(round_trip::<messages::DiagnosticArray>(bytes, encoding)),
    }
}

fn round_trip<M: Message>(bytes: &[u8], encoding: &Encoding) -> Option<M> {
    let message = M::from_bytes(bytes, encoding).ok()?;
    for dialect in [Dialect::Cdr, Dialect::CdrBigEndian] {
        let written = message.to_bytes(dialect);
        let again = M::from_bytes(&written, &Encoding::Cdr).map(|again| again.to_bytes(dialect));
        assert_eq!(again.ok().as_ref(), Some(&written), "{} {dialect:?}", M::NAME);
    }
    Some(message)
}

/// A folder of this process for parsers that open files themselves.
pub fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("loc-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder for temporary files");
        folder
    })
}

/// Writes bytes into a file of [`folder`].
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    std::fs::write(&path, bytes).expect("room for a temporary file");
    path
}

/// Writes the parts of an input, which a zero byte parts, into files of these names.
pub fn files(names: &[&str], data: &[u8]) {
    let mut parts = data.splitn(names.len(), |byte| *byte == BETWEEN_FILES);
    for name in names {
        file(name, parts.next().unwrap_or_default());
    }
}

/// The bytes as a text; what is no UTF-8 is replaced.
pub fn text(data: &[u8]) -> String {
    String::from_utf8_lossy(data).into_owned()
}

//! Satellite positioning (B10), GPS and its kin: the place on the Earth, outdoors.
//!
//! A receiver gives latitude, longitude and height, [`Geodetic`], on the ellipsoid WGS84. A robot
//! counts metres in a plane: [`LocalFrame`] converts both ways, exactly, between the ellipsoid and
//! the frame east-north-up (ENU) that touches it at an origin. [`GnssFix`] is one measurement,
//! [`GnssNoise`] says how far it may be off, and [`Gnss`] simulates the receiver, with errors that
//! last for a while, as those of satellites do, and with outages.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::gnss::{Geodetic, Gnss, LocalFrame};
//! let osnabrueck = Geodetic::from_degrees(52.2719, 8.0443, 64.0)?;
//! let frame = LocalFrame::new(osnabrueck)?;
//! let mut receiver = Gnss::new(frame);
//! let pose = Pose2::new(100.0, 50.0, 0.0);
//! let fix = receiver.measure(pose, 1.0, &mut stream(1, "gnss")).unwrap();
//! let enu = frame.to_enu(&fix.position);
//! assert!((enu.x - 100.0).hypot(enu.y - 50.0) < 15.0);
//! # Ok::<(), loc_core::Error>(())
//! ```

mod fix;
mod geodesy;
mod noise;
mod simulated;

pub use fix::GnssFix;
pub use geodesy::{Geodetic, LocalFrame};
pub use noise::{GnssNoise, Outages};
pub use simulated::Gnss;

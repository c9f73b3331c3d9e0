//! The sensors of the robot, each with a random stream of its own.

use super::config::{OutdoorConfig, RadioConfig, TimedWheelConfig};
use crate::Result;
use crate::source::TrueError;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::compass::Compass;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::gnss::{Geodetic, Gnss, LocalFrame};
use loc_sensors::imu::Imu;
use loc_sensors::landmark_camera::{LandmarkCamera, Observed};
use loc_sensors::wheel::WheelOdometry;

/// Time between two notes of the true errors \[s\].
const NOTE_EVERY: f64 = 0.5;

/// The true motion at the end of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub(super) step: usize,
    pub(super) dt: f64,
    pub(super) pose: Pose2,
    pub(super) twist: Twist2,
    /// Change of the velocity per second, during the step.
    pub(super) change: Twist2,
}

impl Moment {
    pub(super) fn stamp(&self) -> f64 {
        self.step as f64 * self.dt
    }
}

/// A sensor with its pace and the times at which it is silent.
#[derive(Debug)]
struct Timed<S> {
    sensor: S,
    every: usize,
    silent: Vec<[f64; 2]>,
    rng: ChaCha8Rng,
}

impl<S> Timed<S> {
    fn is_due(&self, moment: &Moment) -> bool {
        moment.step.is_multiple_of(self.every)
    }

    fn is_heard(&self, stamp: f64) -> bool {
        !self.silent.iter().any(|[from, to]| (*from..=*to).contains(&stamp))
    }
}

#[derive(Debug)]
struct Wheels {
    odometry: WheelOdometry,
    /// Way and turn since the last reading.
    way: f64,
    turn: f64,
}

#[derive(Debug)]
struct Radio {
    antenna: LandmarkCamera,
    scale: f64,
    offset: f64,
}

#[derive(Debug)]
struct Receiver {
    gnss: Gnss,
    frame: LocalFrame,
    latency: f64,
}

#[derive(Debug)]
pub(super) struct Sensors {
    wheels: Option<Timed<Wheels>>,
    inertial: Option<Timed<Imu>>,
    compass: Option<Timed<Compass>>,
    receiver: Option<Timed<Receiver>>,
    radio: Option<Timed<Radio>>,
    note_every: usize,
    /// The true errors so far.
    gyroscope: Vec<(f64, f64)>,
    forward: Vec<(f64, f64)>,
    left: Vec<(f64, f64)>,
    east: Vec<(f64, f64)>,
    north: Vec<(f64, f64)>,
    heard: Vec<f64>,
}

impl Sensors {
    pub(super) fn new(config: &OutdoorConfig, seed: u64) -> Result<Self> {
        let rng = |name| stream(seed, name);
        let wheels = |wheels: &TimedWheelConfig| -> Result<_> {
            let noise = config.landmark_settings()?.motion_noise;
            let odometry = WheelOdometry::new(wheels.drive.track_m)?.with_noise(noise);
            let odometry = odometry.with_faults(wheels.drive.faults)?;
            Ok(Timed {
                sensor: Wheels { odometry, way: 0.0, turn: 0.0 },
                every: config.steps("outdoor.wheels.every_s", wheels.every_s)?,
                silent: wheels.silent_s.clone(),
                rng: rng("odometry"),
            })
        };
        let radio = |radio: &RadioConfig| -> Result<_> {
            let (scale, offset) = (radio.scale, radio.offset_m);
            Ok(Timed {
                sensor: Radio { antenna: radio.antenna()?, scale, offset },
                every: config.steps("outdoor.radio.every_s", radio.every_s)?,
                silent: radio.silent_s.clone(),
                rng: rng("radio"),
            })
        };
        let (mut inertial, mut compass, mut receiver) = (None, None, None);
        if let Some(unit) = &config.inertial {
            let sensor = Imu::new(unit.spec(config.time_step_s))?;
            let silent = unit.silent_s.clone();
            inertial = Some(Timed { sensor, every: 1, silent, rng: rng("imu") });
        }
        if let Some(given) = &config.compass {
            compass = Some(Timed {
                sensor: given.compass()?,
                every: config.steps("outdoor.compass.every_s", given.every_s)?,
                silent: given.silent_s.clone(),
                rng: rng("compass"),
            });
        }
        if let Some(given) = &config.satellites {
            let frame = LocalFrame::new(Geodetic::from_degrees(52.2719, 8.0443, 64.0)?)?;
            let gnss = Gnss::new(frame).with_noise(given.noise())?;
            receiver = Some(Timed {
                sensor: Receiver { gnss, frame, latency: given.latency_s },
                every: config.steps("outdoor.satellites.every_s", given.every_s)?,
                silent: given.silent_s.clone(),
                rng: rng("satellites"),
            });
        }
        let (gyroscope, forward, left) = Default::default();
        let (east, north, heard) = Default::default();
        Ok(Sensors {
            wheels: config.wheels.as_ref().map(wheels).transpose()?,
            inertial,
            compass,
            receiver,
            radio: config.radio.as_ref().map(radio).transpose()?,
            note_every: (NOTE_EVERY / config.time_step_s).round().max(1.0) as usize,
            gyroscope,
            forward,
            left,
            east,
            north,
            heard,
        })
    }

    /// What the sensors tell at the end of a step that was driven at the velocity `mean`.
    pub(super) fn measure(
        &mut self,
        now: &Moment,
        mean: Twist2,
        landmarks: &LandmarkMap,
        tell: &mut dyn FnMut(Event),
    ) {
        let stamp = now.stamp();
        let measured = |measurement| Event::now(stamp, Payload::Measurement(measurement));
        if let Some(wheels) = &mut self.wheels {
            turn_wheels(wheels, now, mean, tell);
        }
        if let Some(unit) = &mut self.inertial {
            let reading = unit.sensor.measure(mean, now.change, now.dt, &mut unit.rng);
            if unit.is_heard(stamp) {
                tell(measured(Measurement::Inertial(reading)));
            }
        }
        if let Some(compass) = self.compass.as_mut().filter(|compass| compass.is_due(now)) {
            let reading = compass.sensor.measure(now.pose, &mut compass.rng);
            if compass.is_heard(stamp) {
                tell(measured(Measurement::Compass(reading)));
            }
        }
        if let Some(receiver) = self.receiver.as_mut().filter(|receiver| receiver.is_due(now)) {
            let since = receiver.every as f64 * now.dt;
            let Timed { sensor: Receiver { gnss, frame, latency }, rng, .. } = receiver;
            let fix = gnss.measure(now.pose, since, rng);
            let (frame, arrival) = (*frame, stamp + *latency);
            if let Some(fix) = fix.filter(|_| receiver.is_heard(stamp)) {
                tell(Event { arrival, ..measured(Measurement::Position(fix.in_plane(&frame))) });
            }
        }
        if let Some(radio) = self.radio.as_mut().filter(|radio| radio.is_due(now)) {
            let Radio { antenna, scale, offset } = &radio.sensor;
            let mut observations = antenna.observe(landmarks, now.pose, &mut radio.rng);
            for observation in &mut observations {
                if let Observed::Range { range } = &mut observation.sight {
                    *range = (*scale * *range + *offset).max(0.0);
                }
            }
            if !observations.is_empty() && radio.is_heard(stamp) {
                self.heard.push(stamp);
                tell(measured(Measurement::Landmarks(observations)));
            }
        }
        if now.step.is_multiple_of(self.note_every) {
            self.note(stamp);
        }
    }

    fn note(&mut self, stamp: f64) {
        if let Some((force, turn)) = self.inertial.as_ref().and_then(|unit| unit.sensor.biases()) {
            self.gyroscope.push((stamp, turn.z.to_degrees()));
            self.forward.push((stamp, force.x));
            self.left.push((stamp, force.y));
        }
        if let Some(drift) = self.receiver.as_ref().and_then(|r| r.sensor.gnss.drift()) {
            self.east.push((stamp, drift.x));
            self.north.push((stamp, drift.y));
        }
    }

    /// The true errors over time, named as the method `fusion` names them.
    pub(super) fn errors(&self) -> Vec<TrueError> {
        let mut errors = vec![
            ("gyroscope [deg/s]", self.gyroscope.clone()),
            ("accelerometer forward [m/s^2]", self.forward.clone()),
            ("accelerometer left [m/s^2]", self.left.clone()),
            ("satellites east [m]", self.east.clone()),
            ("satellites north [m]", self.north.clone()),
        ];
        if let (Some(radio), Some(first), Some(last)) =
            (&self.radio, self.heard.first(), self.heard.last())
        {
            let always = |value: f64| vec![(*first, value), (*last, value)];
            errors.push(("range scale", always(radio.sensor.scale)));
            errors.push(("range offset [m]", always(radio.sensor.offset)));
        }
        errors.retain(|(_, values)| !values.is_empty());
        errors.into_iter().map(|(name, values)| TrueError { name, values }).collect()
    }
}

/// The wheels report the mean velocity since the last reading, when the time is over.
fn turn_wheels(
    wheels: &mut Timed<Wheels>,
    now: &Moment,
    mean: Twist2,
    tell: &mut dyn FnMut(Event),
) {
    let sensor = &mut wheels.sensor;
    sensor.way += mean.vx * now.dt;
    sensor.turn += mean.omega * now.dt;
    if !now.step.is_multiple_of(wheels.every) {
        return;
    }
    let period = wheels.every as f64 * now.dt;
    let driven = Twist2::forward(sensor.way / period, sensor.turn / period);
    let reading = sensor.odometry.measure(driven, period, &mut wheels.rng);
    (sensor.way, sensor.turn) = (0.0, 0.0);
    let (arrival, stamp) = (now.stamp(), now.stamp() - period);
    if wheels.is_heard(arrival) {
        let payload = Payload::Control(Control::Velocity(reading));
        tell(Event { stamp, arrival, payload });
    }
}

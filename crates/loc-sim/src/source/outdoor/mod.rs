//! A simulated robot outdoors, with sensors of different rates that have outages.

mod config;

pub use config::{
    CompassConfig, CourseConfig, InertialConfig, OutdoorConfig, RadioConfig, SatelliteConfig,
    TimedWheelConfig,
};

use super::{ArrivalQueue, SensorTruth, Setup, Silence, Source, TrueError};
use crate::Result;
use loc_core::gaussian::pose_belief;
use loc_core::motion::Integration;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::compass::Compass;
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use loc_sensors::gnss::{Geodetic, Gnss, LocalFrame};
use loc_sensors::imu::Imu;
use loc_sensors::landmark_camera::{LandmarkCamera, Observed};
use loc_sensors::wheel::WheelOdometry;
use std::sync::Arc;

/// Time between two true poses \[s\].
const TRUTH_EVERY: f64 = 0.1;

/// A simulated robot with limited accelerations. It drives arcs.
#[derive(Debug)]
pub struct SimulatedOutdoor {
    setup: Setup,
    /// The target velocity of each step.
    course: Vec<Twist2>,
    /// Largest change of the velocity in a step.
    most: Twist2,
    moment: Moment,
    sensors: Sensors,
    silences: Vec<Silence>,
    truth_every: usize,
    queue: ArrivalQueue,
}

impl SimulatedOutdoor {
    /// A robot as configured.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(name: &str, config: &OutdoorConfig, seed: u64) -> Result<Self> {
        let mut course = Vec::new();
        for piece in &config.course {
            let steps = config.steps("outdoor.course.duration", piece.duration)?;
            course.extend(std::iter::repeat_n(piece.twist(), steps));
        }
        let dt = config.time_step;
        let pose = config.start;
        let mut start_belief = pose_belief(pose, config.start_sigma.sigmas()?);
        start_belief.mean = start_belief.sample(&mut stream(seed, "start"));
        let setup = Setup {
            name: name.into(),
            start: 0.0,
            end: course.len() as f64 * dt,
            start_belief,
            rail: None,
            landmarks: Arc::new(config.map()?),
            map: None,
            lines: None,
            has_laser: false,
            kidnapped_at: None,
        };
        let silence = |(sensor, [from, to]): (_, [f64; 2])| Silence { sensor, from, to };
        let turn = config.turn_acceleration;
        let mut robot = SimulatedOutdoor {
            setup,
            course,
            most: Twist2::forward(config.acceleration * dt, turn * dt),
            moment: Moment { step: 0, dt, pose, twist: Twist2::ZERO, change: Twist2::ZERO },
            sensors: Sensors::new(config, seed)?,
            silences: config.silences().into_iter().map(silence).collect(),
            truth_every: (TRUTH_EVERY / dt).round().max(1.0) as usize,
            queue: ArrivalQueue::default(),
        };
        robot.tell_truth();
        Ok(robot)
    }

    fn drive(&mut self, goal: Twist2) {
        let Moment { dt, twist: before, .. } = self.moment;
        let toward = |now: f64, goal: f64, most: f64| now + (goal - now).clamp(-most, most);
        let after = Twist2::forward(
            toward(before.vx, goal.vx, self.most.vx),
            toward(before.omega, goal.omega, self.most.omega),
        );
        let mean =
            Twist2::forward(0.5 * (before.vx + after.vx), 0.5 * (before.omega + after.omega));
        let change =
            Twist2::forward((after.vx - before.vx) / dt, (after.omega - before.omega) / dt);
        let pose = Integration::ExactArc.step(self.moment.pose, mean, dt);
        let step = self.moment.step + 1;
        self.moment = Moment { step, dt, pose, twist: after, change };
        let landmarks = &self.setup.landmarks;
        self.sensors.measure(&self.moment, mean, landmarks, &mut |event| self.queue.push(event));
        if step.is_multiple_of(self.truth_every) {
            self.tell_truth();
        }
    }

    fn tell_truth(&mut self) {
        let Moment { pose, twist, .. } = self.moment;
        let truth = Truth { pose, speed: Some(twist.vx) };
        self.queue.push(Event::now(self.moment.stamp(), Payload::Truth(truth)));
    }

    /// The true pose now.
    pub fn pose(&self) -> Pose2 {
        self.moment.pose
    }
}

impl Source for SimulatedOutdoor {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        loop {
            let ended = self.moment.step == self.course.len();
            // Events of the next step arrive later.
            let now = self.moment.stamp() + 0.5 * self.moment.dt;
            if let Some(event) = self.queue.pop(if ended { f64::INFINITY } else { now }) {
                return Ok(Some(event));
            }
            match self.course.get(self.moment.step).copied() {
                Some(goal) => self.drive(goal),
                None => return Ok(None),
            }
        }
    }

    fn sensor_truth(&self) -> SensorTruth {
        SensorTruth { silences: self.silences.clone(), errors: self.sensors.errors() }
    }
}

/// Sample time of the true errors \[s\].
const NOTE_EVERY: f64 = 0.5;

/// The true motion at the end of a step.
#[derive(Debug, Clone, Copy)]
struct Moment {
    step: usize,
    dt: f64,
    pose: Pose2,
    twist: Twist2,
    /// Change of the velocity per second, during the step.
    change: Twist2,
}

impl Moment {
    fn stamp(&self) -> f64 {
        self.step as f64 * self.dt
    }
}

/// A sensor with its rate and its outages.
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
    /// Distance and turn since the last measurement.
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
struct Sensors {
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
    fn new(config: &OutdoorConfig, seed: u64) -> Result<Self> {
        let rng = |name| stream(seed, name);
        let wheels = |wheels: &TimedWheelConfig| -> Result<_> {
            let noise = config.robot()?.odometry;
            let odometry = WheelOdometry::new(wheels.drive.track)?.with_noise(noise);
            let odometry = odometry.with_faults(wheels.drive.faults)?;
            Ok(Timed {
                sensor: Wheels { odometry, way: 0.0, turn: 0.0 },
                every: config.steps("outdoor.wheels.every", wheels.every)?,
                silent: wheels.silent.clone(),
                rng: rng("odometry"),
            })
        };
        let radio = |radio: &RadioConfig| -> Result<_> {
            let (scale, offset) = (radio.scale, radio.offset);
            Ok(Timed {
                sensor: Radio { antenna: radio.antenna()?, scale, offset },
                every: config.steps("outdoor.radio.every", radio.every)?,
                silent: radio.silent.clone(),
                rng: rng("radio"),
            })
        };
        let (mut inertial, mut compass, mut receiver) = (None, None, None);
        if let Some(unit) = &config.inertial {
            let sensor = Imu::new(unit.spec(config.time_step))?;
            let silent = unit.silent.clone();
            inertial = Some(Timed { sensor, every: 1, silent, rng: rng("imu") });
        }
        if let Some(given) = &config.compass {
            compass = Some(Timed {
                sensor: given.compass()?,
                every: config.steps("outdoor.compass.every", given.every)?,
                silent: given.silent.clone(),
                rng: rng("compass"),
            });
        }
        if let Some(given) = &config.satellites {
            let frame = LocalFrame::new(Geodetic::from_degrees(52.2719, 8.0443, 64.0)?)?;
            let gnss = Gnss::new(frame).with_noise(given.noise())?;
            receiver = Some(Timed {
                sensor: Receiver { gnss, frame, latency: given.latency },
                every: config.steps("outdoor.satellites.every", given.every)?,
                silent: given.silent.clone(),
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
            note_every: (NOTE_EVERY / config.time_step).round().max(1.0) as usize,
            gyroscope,
            forward,
            left,
            east,
            north,
            heard,
        })
    }

    /// The measurements at the end of a step that was driven at the velocity `mean`.
    fn measure(
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
                if let Observed::Range { range } = &mut observation.observed {
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
    fn errors(&self) -> Vec<TrueError> {
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

/// The wheels report the mean velocity since the last measurement, at the end of their period.
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

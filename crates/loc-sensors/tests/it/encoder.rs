use approx::assert_relative_eq;
use loc_core::kinematics::Ackermann;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::encoder::{
    SteeringCount, SteeringEncoder, SteeringNoise, WheelEncoder, WheelTicks,
};
use std::f64::consts::PI;

#[test]
fn ticks_by_hand() {
    // 100 counts a turn, 1 m around: a count is 1 cm.
    let mut wheel = WheelEncoder::new(100, 0.5 / PI).unwrap();
    assert_relative_eq!(wheel.resolution(), 0.01, epsilon = 1e-15);
    assert_eq!(wheel.roll(0.025), WheelTicks(2));
    assert_eq!(wheel.roll(0.006), WheelTicks(1), "half a count was left");
    assert_eq!(wheel.roll(-0.05), WheelTicks(-5));
    assert_relative_eq!(wheel.distance(WheelTicks(-3)), -0.03, epsilon = 1e-15);
    assert_eq!(wheel.roll(f64::NAN), WheelTicks(0));
    assert_eq!(wheel.roll(f64::INFINITY), WheelTicks(0));
    assert_eq!(wheel.roll(0.02), WheelTicks(2), "and it still works");
}

#[test]
fn no_way_is_lost() {
    let mut wheel = WheelEncoder::new(512, 0.1).unwrap();
    let (mut ticks, mut way) = (0, 0.0);
    for k in 0..100_000 {
        let step = 3e-4 * (0.01 * f64::from(k)).sin() + 1e-4;
        ticks += wheel.roll(step).0;
        way += step;
    }
    let error = wheel.distance(WheelTicks(ticks)) - way;
    assert!(error.abs() <= wheel.resolution(), "{error}");
}

#[test]
fn steering_by_hand() {
    let mut encoder = SteeringEncoder::new(3600).unwrap();
    let mut rng = stream(1, "steering");
    let tenth = 0.1_f64.to_radians();
    assert_relative_eq!(encoder.resolution(), tenth, epsilon = 1e-15);
    assert_eq!(encoder.measure(2.44 * tenth, &mut rng), SteeringCount(2));
    assert_eq!(encoder.measure(-2.6 * tenth, &mut rng), SteeringCount(-3));
    assert_relative_eq!(encoder.angle(SteeringCount(-3)), -3.0 * tenth, epsilon = 1e-15);
    assert_eq!(encoder.measure(99.0, &mut rng), SteeringCount(1800));
}

#[test]
fn play_follows_at_a_distance() {
    let noise = SteeringNoise { backlash: 0.02, zero_offset: 0.1, ..SteeringNoise::NONE };
    let mut encoder = SteeringEncoder::new(1 << 24).unwrap().with_noise(noise).unwrap();
    let mut rng = stream(1, "steering");
    let mut angle = |steering| {
        let count = encoder.measure(steering, &mut rng);
        encoder.angle(count) - 0.1
    };
    assert_relative_eq!(angle(0.005), 0.0, epsilon = 1e-6);
    assert_relative_eq!(angle(0.30), 0.29, epsilon = 1e-6);
    assert_relative_eq!(angle(0.285), 0.29, epsilon = 1e-6);
    assert_relative_eq!(angle(0.20), 0.21, epsilon = 1e-6);
}

/// The speed of the rear wheels and the steering angle make the velocity of a car.
#[test]
fn counts_give_a_cars_velocity() {
    let car = Ackermann::new(2.5).unwrap();
    let mut rear = WheelEncoder::new(4096, 0.3).unwrap();
    let mut steering = SteeringEncoder::new(1 << 14).unwrap();
    let ticks = rear.roll(0.8);
    let count = steering.measure(0.2, &mut stream(1, "steering"));
    let seen = car.twist(rear.distance(ticks) / 0.1, steering.angle(count));
    let truth = car.twist(8.0, 0.2);
    assert_relative_eq!(seen.vx, truth.vx, epsilon = rear.resolution() / 0.1);
    assert_relative_eq!(seen.omega, truth.omega, epsilon = 2e-3);
}

#[test]
fn noise_has_its_variance() {
    let noise = SteeringNoise { sigma: 0.01, ..SteeringNoise::NONE };
    let mut encoder = SteeringEncoder::new(1 << 16).unwrap().with_noise(noise).unwrap();
    let mut rng = stream(2, "steering");
    let counts: Vec<_> = (0..20_000).map(|_| encoder.measure(0.3, &mut rng)).collect();
    let moments = RunningMoments::of(counts.into_iter().map(|c| encoder.angle(c))).unwrap();
    assert_relative_eq!(moments.mean().unwrap(), 0.3, epsilon = 3e-4);
    assert_relative_eq!(moments.standard_deviation().unwrap(), 0.01, max_relative = 0.03);
}

#[test]
fn bad_settings_are_refused() {
    assert!(WheelEncoder::new(0, 0.1).is_err());
    assert!(WheelEncoder::new(100, 0.0).is_err());
    assert!(WheelEncoder::new(100, f64::NAN).is_err());
    assert!(SteeringEncoder::new(3).is_err() && SteeringEncoder::new(u32::MAX).is_err());
    let encoder = SteeringEncoder::new(1000).unwrap();
    assert!(encoder.with_noise(SteeringNoise { sigma: -1.0, ..SteeringNoise::NONE }).is_err());
    assert!(encoder.with_noise(SteeringNoise { backlash: -1.0, ..SteeringNoise::NONE }).is_err());
}

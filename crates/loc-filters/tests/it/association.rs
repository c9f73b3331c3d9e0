use loc_core::random::{ChaCha8Rng, stream};
use loc_core::stats::chi_square_quantile;
use loc_filters::association::{
    Association, AssociationSettings, Associator, PairInnovation, Pairing, Rule,
};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

/// Points of the plane, seen by a robot whose own place is uncertain.
struct Points {
    seen: Vec<Vector2<f64>>,
    known: Vec<Vector2<f64>>,
    /// What all observations have in common, and what each has of its own.
    robot: Matrix2<f64>,
    sensor: Vec<Matrix2<f64>>,
}

impl Pairing<2> for Points {
    fn observations(&self) -> usize {
        self.seen.len()
    }
    fn landmarks(&self) -> usize {
        self.known.len()
    }
    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<2>> {
        let residual = self.seen[observation] - self.known[landmark];
        Some(PairInnovation { residual, covariance: self.robot + self.sensor[landmark] })
    }
    fn cross_covariance(&self, _: (usize, usize), _: (usize, usize)) -> Matrix2<f64> {
        self.robot
    }
}

fn draw(rng: &mut ChaCha8Rng) -> Vector2<f64> {
    Vector2::from_fn(|_, _| StandardNormal.sample(rng))
}

/// Landmarks close together, seen by a robot that is off by about as much.
fn world(rng: &mut ChaCha8Rng, landmarks: usize, observations: usize) -> Points {
    let known: Vec<_> = (0..landmarks).map(|_| 2.0 * draw(rng)).collect();
    let off = 0.7 * draw(rng);
    let mut seen: Vec<_> = (0..observations)
        .map(|k| if k < landmarks { known[k] + off + 0.2 * draw(rng) } else { 2.0 * draw(rng) })
        .collect();
    seen.rotate_left(rng.random_range(0..observations.max(1)));
    let sensor =
        (0..landmarks).map(|_| Matrix2::identity() * rng.random_range(0.02..0.2_f64)).collect();
    Points { seen, known, robot: Matrix2::new(0.6, 0.2, 0.2, 0.5), sensor }
}

fn associate(rule: Rule, pairing: &impl Pairing<2>) -> Association {
    let settings = AssociationSettings::default().rule(rule);
    Associator::new(settings).unwrap().associate(pairing).unwrap()
}

/// The same, believing the likeliest however little it leads.
fn trusting(rule: Rule, pairing: &impl Pairing<2>) -> Association {
    let settings = AssociationSettings::default().rule(rule).min_ratio(1.0);
    Associator::new(settings).unwrap().associate(pairing).unwrap()
}

/// Squared Mahalanobis distance of all pairs together, with the whole matrix inverted.
fn joint_nis(points: &Points, partners: &[Option<usize>]) -> (usize, f64) {
    let pairs: Vec<_> =
        partners.iter().enumerate().filter_map(|(i, j)| j.map(|j| (i, j))).collect();
    let n = 2 * pairs.len();
    let (mut s, mut r) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for (a, &(i, j)) in pairs.iter().enumerate() {
        r.fixed_rows_mut::<2>(2 * a).copy_from(&(points.seen[i] - points.known[j]));
        for (b, &(_, other)) in pairs.iter().enumerate() {
            let own = if a == b { points.sensor[other] } else { Matrix2::zeros() };
            s.fixed_view_mut::<2, 2>(2 * a, 2 * b).copy_from(&(points.robot + own));
        }
    }
    let nis = if n == 0 { 0.0 } else { (r.transpose() * s.try_inverse().unwrap() * r)[(0, 0)] };
    (pairs.len(), nis)
}

/// The best of all hypotheses whose every beginning fits: most pairs, then the smallest NIS.
fn brute_force(points: &Points, gate: f64) -> (Vec<Option<usize>>, (usize, f64)) {
    let (n, m) = (points.seen.len(), points.known.len());
    let mut best = (vec![None; n], (0, f64::INFINITY));
    for code in 0..(m + 1).pow(n as u32) {
        let digit = |k: usize| code / (m + 1).pow(k as u32) % (m + 1);
        let partners: Vec<_> = (0..n).map(|k| digit(k).checked_sub(1)).collect();
        let mut used: Vec<_> = partners.iter().flatten().collect();
        let pairs = used.len();
        used.sort();
        used.dedup();
        let fits = |end: usize| {
            let (pairs, nis) = joint_nis(points, &partners[..end]);
            pairs == 0 || nis <= chi_square_quantile(2 * pairs, gate).unwrap()
        };
        let alone = |(i, j): (usize, &Option<usize>)| {
            let mut single = vec![None; n];
            single[i] = *j;
            joint_nis(points, &single).1 <= chi_square_quantile(2, gate).unwrap()
        };
        if used.len() < pairs || !partners.iter().enumerate().all(alone) || !(1..=n).all(fits) {
            continue;
        }
        let value = joint_nis(points, &partners);
        if value.0 > best.1.0 || (value.0 == best.1.0 && value.1 < best.1.1) {
            best = (partners, value);
        }
    }
    best
}

#[test]
fn joint_compatibility_against_all_hypotheses() {
    let mut rng = stream(3, "worlds");
    let mut differs = 0;
    for round in 0..60 {
        let points = world(&mut rng, 4, 1 + round % 4);
        let found = trusting(Rule::JointCompatibility, &points);
        let (partners, _) = brute_force(&points, 0.99);
        assert!(found.complete);
        assert_eq!(found.partners, partners, "round {round}");
        differs += usize::from(trusting(Rule::NearestNeighbor, &points).partners != partners);
    }
    assert!(differs >= 8, "the worlds are too easy: {differs}");
}

/// A landmark known well at 2.0 and one known badly at 3.2, an observation at 2.5.
#[test]
fn nearest_neighbor_and_maximum_likelihood_differ() {
    let points = Points {
        seen: vec![Vector2::new(2.5, 0.0)],
        known: vec![Vector2::new(2.0, 0.0), Vector2::new(3.2, 0.0)],
        robot: Matrix2::zeros(),
        sensor: vec![Matrix2::identity() * 0.05, Matrix2::identity() * 0.2],
    };
    // NIS 0.25 / 0.05 = 5 and 0.49 / 0.2 = 2.45; the likelihood has ln 0.05^2 and ln 0.2^2 beside.
    let nearest = trusting(Rule::NearestNeighbor, &points);
    assert_eq!(nearest.partners, [Some(1)]);
    assert!((nearest.nearest[0] - 2.45).abs() < 1e-12);
    let likely = trusting(Rule::MaximumLikelihood, &points);
    assert_eq!(likely.partners, [Some(0)]);
}

#[test]
fn every_landmark_is_given_away_once() {
    let mut rng = stream(8, "crowd");
    for rule in [Rule::NearestNeighbor, Rule::MaximumLikelihood, Rule::JointCompatibility] {
        let mut points = world(&mut rng, 30, 30);
        // Everything is seen twice, so that more observations than one group compete.
        points.seen.extend(points.seen.clone());
        let found = trusting(rule, &points);
        let mut landmarks: Vec<_> = found.partners.iter().flatten().collect();
        let count = landmarks.len();
        landmarks.sort();
        landmarks.dedup();
        assert_eq!((landmarks.len(), found.partners.len()), (count, 60));
        assert!(count > 15, "{rule:?} {count}");
    }
}

#[test]
fn a_search_that_is_cut_short_says_so() {
    let mut rng = stream(5, "crowd");
    let points = world(&mut rng, 20, 20);
    let search = |search_limit| {
        let settings = AssociationSettings::default().search_limit(search_limit);
        Associator::new(settings).unwrap().associate(&points).unwrap()
    };
    let (short, long) = (search(1), search(20_000));
    assert!(!short.complete);
    assert!(short.matched() >= 1 && long.matched() >= short.matched());
}

#[test]
fn nothing_much_and_nonsense() {
    let none =
        Points { seen: Vec::new(), known: Vec::new(), robot: Matrix2::zeros(), sensor: Vec::new() };
    let crowd = Points {
        seen: (0..100_000).map(|k| Vector2::new(f64::from(k), 0.0)).collect(),
        known: vec![Vector2::new(50_000.0, 0.1)],
        robot: Matrix2::identity() * 1e-4,
        sensor: vec![Matrix2::identity() * 0.01],
    };
    for rule in [Rule::NearestNeighbor, Rule::MaximumLikelihood, Rule::JointCompatibility] {
        assert!(associate(rule, &none).partners.is_empty());
        let found = associate(rule, &crowd);
        assert_eq!((found.matched(), found.partners[50_000]), (1, Some(0)));
    }
    let unknown = Points { known: Vec::new(), sensor: Vec::new(), ..crowd };
    let found = associate(Rule::JointCompatibility, &unknown);
    assert!(found.matched() == 0 && found.nearest.iter().all(|nis| nis.is_infinite()));
    let refused = |residual: f64, variance: f64| {
        let points = Points {
            seen: vec![Vector2::new(residual, 0.0)],
            known: vec![Vector2::zeros()],
            robot: Matrix2::zeros(),
            sensor: vec![Matrix2::identity() * variance],
        };
        let associator = Associator::new(AssociationSettings::default()).unwrap();
        associator.associate(&points).unwrap_err().to_string()
    };
    assert!(refused(f64::NAN, 1.0).contains("residual of an observation: expected finite"));
    assert!(refused(0.0, -1.0).contains("positive definite"));
    let gate = AssociationSettings::default().gate_probability(1.5);
    assert!(Associator::new(gate).is_err());
}

/// Points of the plane among which there may be others that are unknown.
struct AmongOthers(Points);

impl Pairing<2> for AmongOthers {
    fn observations(&self) -> usize {
        self.0.observations()
    }
    fn landmarks(&self) -> usize {
        self.0.landmarks()
    }
    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<2>> {
        self.0.innovation(observation, landmark)
    }
    fn elsewhere(&self, _: usize) -> f64 {
        0.1
    }
    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        self.0.cross_covariance(a, b)
    }
}

/// The robot may be off by 1 m. A single landmark that fits then says nothing: the density of it
/// is 0.16 at most, that of something else 0.1. Two that fit each other do.
#[test]
fn one_that_fits_is_chance_and_two_are_not() {
    let points = |seen: &[[f64; 2]]| {
        AmongOthers(Points {
            seen: seen.iter().map(|&place| Vector2::from(place)).collect(),
            known: vec![Vector2::new(0.0, 0.0), Vector2::new(3.0, 0.5)],
            robot: Matrix2::identity(),
            sensor: vec![Matrix2::identity() * 0.01; 2],
        })
    };
    for rule in [Rule::NearestNeighbor, Rule::MaximumLikelihood, Rule::JointCompatibility] {
        assert_eq!(associate(rule, &points(&[[0.3, 0.2]])).partners, [None], "{rule:?}");
    }
    let joint = |seen: &[[f64; 2]]| associate(Rule::JointCompatibility, &points(seen)).partners;
    assert_eq!(joint(&[[0.3, 0.2], [3.25, 0.75]]), [Some(0), Some(1)]);
    // These two fit one landmark each, but not together: the larger set is one of them, by chance.
    assert_eq!(joint(&[[0.3, 0.2], [3.9, -0.3]]), [None, None]);
}

/// Two landmarks close together: whichever it is, the other one is nearly as likely.
#[test]
fn one_of_two_is_left_out_rather_than_guessed() {
    let points = Points {
        seen: vec![Vector2::new(0.1, 0.0), Vector2::new(5.0, 0.1)],
        known: vec![Vector2::zeros(), Vector2::new(0.3, 0.0), Vector2::new(5.0, 0.0)],
        robot: Matrix2::identity() * 0.03,
        sensor: vec![Matrix2::identity() * 0.01; 3],
    };
    for rule in [Rule::NearestNeighbor, Rule::MaximumLikelihood, Rule::JointCompatibility] {
        let found = associate(rule, &points);
        assert_eq!(found.partners, [None, Some(2)], "{rule:?}");
        assert!(found.nearest[0] < 0.3);
        assert_eq!(trusting(rule, &points).partners, [Some(0), Some(2)]);
    }
}

//! Comparison with the figures of evo 1.38.1 for two small generated recordings.
//!
//! `evo_ape tum REF EST` and `evo_rpe tum REF EST`, for the rotations with `-r angle_deg`. With
//! `-a` for the planar recording as se2; in space, where `-a` is free to turn about any axis, with
//! evo's `umeyama_alignment` over x and y alone.

use loc_sim::metrics::{
    Alignment, EvalSettings, Evaluation, SpatialTrajectory, Statistics, evaluate,
};
use std::fmt::Write;

/// Of ape, ape_rot, rpe_trans and rpe_rot: rmse, mean, median, std, min, max, sse.
type Figures = [[f64; 7]; 4];

const PLANAR_NONE: Figures = [
    [
        1.3000932756439374,
        1.298533851794482,
        1.3129011995495623,
        0.06365815830174287,
        1.1976028488287602,
        1.3870514246290153,
        27.04388040599333,
    ],
    [
        3.0340866328163965,
        2.7466738750433946,
        2.630990183189441,
        1.2889780136174709,
        0.38016086038900104,
        4.554995133978968,
        147.29090712696222,
    ],
    [
        0.0810245137475302,
        0.05335959555866625,
        0.028835829950356735,
        0.060973153025239514,
        0.010280645834447004,
        0.23858607031385948,
        0.09847457742035565,
    ],
    [
        1.9255905231631565,
        1.55227109563099,
        1.1532232358146979,
        1.1394530743143065,
        0.04028218637658115,
        4.1823654990343355,
        55.61848294343638,
    ],
];
const PLANAR_ORIGIN: Figures = [
    [
        0.21111441350421656,
        0.19563692555822243,
        0.208793272173164,
        0.07934411728260561,
        0.0,
        0.31716923301659933,
        0.7131087294276693,
    ],
    [
        4.613205354833783,
        3.603073291576823,
        3.086000249970355,
        2.8808898801226066,
        0.0,
        9.042158193658658,
        340.50661833387335,
    ],
    PLANAR_NONE[2],
    PLANAR_NONE[3],
];
const PLANAR_SE2: Figures = [
    [
        0.0882307006964704,
        0.0859316761992332,
        0.09052104466817841,
        0.020010086730953495,
        0.04080351600227683,
        0.11953692575998162,
        0.12455450472624227,
    ],
    [
        2.9285500556037323,
        2.640241629649247,
        2.603148024030561,
        1.2670949314253104,
        0.8058898419655934,
        4.912892041256275,
        137.222486850826,
    ],
    PLANAR_NONE[2],
    PLANAR_NONE[3],
];
const SPACE_NONE: Figures = [
    [
        0.38588088418893574,
        0.38344795254889374,
        0.36668457385527314,
        0.04326343107632768,
        0.3363822124225769,
        0.4693437990250554,
        13.401365110419134,
    ],
    [
        10.308848349319927,
        5.481677403441594,
        0.9652870423750376,
        8.730610925580981,
        0.2186787620163811,
        29.14999134897997,
        9564.511886034856,
    ],
    [
        0.01870469420856152,
        0.016941700744973146,
        0.01660774807613906,
        0.007927443554108175,
        0.005029988567525259,
        0.031620492545474006,
        0.031138037103785744,
    ],
    [
        15.082296524622755,
        10.894663342771096,
        9.583642434954234,
        10.429859975298202,
        0.5474921049866991,
        30.094443814416632,
        20245.334492641643,
    ],
];
const SPACE_ORIGIN: Figures = [
    [
        0.22545019965181087,
        0.18769975389403434,
        0.1811280890165123,
        0.12488632795930993,
        0.0,
        0.4007046877440369,
        4.574501327073724,
    ],
    [
        10.196942801032245,
        5.607199100903072,
        1.2779781324336927,
        8.516863315232614,
        0.0,
        28.84978784821946,
        9357.987823877098,
    ],
    SPACE_NONE[2],
    SPACE_NONE[3],
];
const SPACE_SE2: Figures = [
    [
        0.2248870140080586,
        0.21679869100544863,
        0.20034984772763423,
        0.059770365966628915,
        0.14566321242594601,
        0.3182131231486806,
        4.551675216251468,
    ],
    [
        9.52800199436405,
        6.781944739078238,
        3.7265538976232353,
        6.6923872841232335,
        2.1685180991746686,
        26.214976827218457,
        8170.453980414479,
    ],
    SPACE_NONE[2],
    SPACE_NONE[3],
];

fn evaluated(recording: &Recording, align: Alignment) -> Evaluation {
    let estimate = SpatialTrajectory::parse_tum("estimate.tum", &recording.estimate).unwrap();
    let reference = SpatialTrajectory::parse_tum("reference.tum", &recording.reference).unwrap();
    let settings = EvalSettings { align, ..EvalSettings::default() };
    evaluate(&estimate, &reference, &settings).unwrap()
}

fn figures(s: &Statistics) -> [f64; 7] {
    [s.rmse, s.mean, s.median, s.std, s.min, s.max, s.sse]
}

#[track_caller]
fn assert_as_evo(recording: &Recording, align: Alignment, pairs: usize, expected: &Figures) {
    let evaluation = evaluated(recording, align);
    assert_eq!(evaluation.pairs, pairs);
    let ours = [
        figures(&evaluation.ape),
        figures(&evaluation.ape_rot),
        figures(&evaluation.rpe_trans.unwrap()),
        figures(&evaluation.rpe_rot.unwrap()),
    ];
    for (row, (ours, theirs)) in ours.iter().zip(expected).enumerate() {
        for (column, (a, b)) in ours.iter().zip(theirs).enumerate() {
            // Sums of squares reach 2e4: those relative to their size.
            let tolerance = 1e-9 * b.abs().max(1.0);
            assert!((a - b).abs() < tolerance, "[{row}][{column}]: {a}, evo {b}");
        }
    }
}

#[test]
fn planar_recording_without_alignment() {
    assert_as_evo(&planar(), Alignment::None, 16, &PLANAR_NONE);
}

#[test]
fn planar_recording_aligned_at_the_origin() {
    assert_as_evo(&planar(), Alignment::Origin, 16, &PLANAR_ORIGIN);
}

#[test]
fn planar_recording_aligned_in_the_plane() {
    assert_as_evo(&planar(), Alignment::Se2, 16, &PLANAR_SE2);
}

#[test]
fn spatial_recording_without_alignment() {
    assert_as_evo(&space(), Alignment::None, 90, &SPACE_NONE);
}

#[test]
fn spatial_recording_aligned_at_the_origin() {
    assert_as_evo(&space(), Alignment::Origin, 90, &SPACE_ORIGIN);
}

#[test]
fn spatial_recording_aligned_about_z() {
    assert_as_evo(&space(), Alignment::Se2, 90, &SPACE_SE2);
}

/// An estimate and its reference.
pub(crate) struct Recording {
    pub(crate) estimate: String,
    pub(crate) reference: String,
}

/// Planar: a reference at 20 Hz, an estimate at 7 Hz, 3 ms late, with a gap of two seconds.
pub(crate) fn planar() -> Recording {
    let (mut estimate, mut reference) = (String::from("# t x y z qx qy qz qw\n"), String::new());
    for i in 0..200 {
        let t = 0.05 * f64::from(i);
        write_pose(&mut reference, t, [curve_x(t), curve_y(t), 0.0], turn(t), 1.0);
    }
    for i in (0..70).filter(|i| !(20..34).contains(i)) {
        let t = 0.003 + f64::from(i) / 7.0;
        let position = [1.2 + curve_x(t) + 0.02 * t, curve_y(t) - 0.1 * t.sin(), 0.0];
        write_pose(&mut estimate, t, position, turn(t + 0.05 * t.cos()), 1.0);
    }
    Recording { estimate, reference }
}

/// In space: an estimate at 50 Hz whose stamps come in twos, its quaternions not of unit length,
/// and a reference at 30 Hz, 4 ms early, at a stamp of the year 2020.
pub(crate) fn space() -> Recording {
    let (mut estimate, mut reference) = (String::new(), String::new());
    let start = 1_600_000_000.0;
    for i in 0..90 {
        let t = f64::from(i) / 30.0 - 0.004;
        let position = [curve_x(t), curve_y(t), 0.5 * t.cos()];
        write_pose(&mut reference, start + t, position, tumble(t), 1.0);
    }
    for i in 0..150 {
        let t = 0.02 * f64::from(i);
        let position = [curve_x(t) + 0.3, 0.9 * curve_y(t), 0.4 * t.cos() - 0.2];
        let stretch = 0.5 + 0.01 * f64::from(i);
        write_pose(&mut estimate, start + t, position, tumble(1.1 * t), stretch);
        let late = position.map(|value| value + 0.01);
        write_pose(&mut estimate, start + t, late, tumble(t), 1.0);
    }
    Recording { estimate, reference }
}

fn curve_x(t: f64) -> f64 {
    3.0 * (0.4 * t).sin() + 0.1 * t
}

fn curve_y(t: f64) -> f64 {
    2.0 * (0.7 * t + 0.3).cos()
}

/// The quaternion (x, y, z, w) of a heading that runs through several full turns.
fn turn(t: f64) -> [f64; 4] {
    let half = 0.5 * (1.5 * t - 2.0);
    [0.0, 0.0, half.sin(), half.cos()]
}

/// A quaternion (x, y, z, w) of unit length that turns about all axes.
fn tumble(t: f64) -> [f64; 4] {
    let q = [0.4 * t.sin(), 0.3 * (2.0 * t).cos(), (0.8 * t).sin(), (0.8 * t).cos()];
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    q.map(|v| v / norm)
}

fn write_pose(text: &mut String, stamp: f64, position: [f64; 3], q: [f64; 4], stretch: f64) {
    let [x, y, z] = position;
    let [qx, qy, qz, qw] = q.map(|v| v * stretch);
    writeln!(text, "{stamp} {x} {y} {z} {qx} {qy} {qz} {qw}").unwrap();
}

//! Lateration (D): where two and three circles meet, and what a fourth range adds.

use loc_filters::lateration::{LaterationSettings, Range, locate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = LaterationSettings::default();
    // Landmark [m], measured distance [m], standard deviation [m].
    let mut ranges = vec![Range::new([0.0, 0.0], 5.0, 0.1), Range::new([6.0, 0.0], 5.0, 0.1)];
    let two = locate(&ranges, Some([3.0, 1.0].into()), &settings)?;
    println!("two ranges: {} or {:?}", two.best.position, two.other.map(|fix| fix.position));

    for (landmark, distance) in [([3.0, 10.0], 6.05), ([-2.0, 4.0], 5.02)] {
        ranges.push(Range::new(landmark, distance, 0.1));
        let found = locate(&ranges, None, &settings)?;
        let covariance = found.best.covariance;
        let (x, y) = (covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt());
        println!(
            "{} ranges: {}, sigma {x:.3} m, {y:.3} m, unique: {}",
            ranges.len(),
            found.best.position,
            found.is_unique()
        );
    }
    Ok(())
}

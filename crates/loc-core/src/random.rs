//! Reproducible randomness: one seed, separate named streams.
//!
//! A simulated world, its sensors and each filter draw from their own streams, so that
//! changing how many numbers one of them draws never changes what the others see.
//!
//! ```
//! use loc_core::random::stream;
//! use rand::RngExt;
//! let a: f64 = stream(7, "sensor").random();
//! let b: f64 = stream(7, "sensor").random();
//! let c: f64 = stream(7, "filter").random();
//! assert!(a == b && a != c);
//! ```

pub use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// The generator of stream `name` under `seed`: the same numbers on every machine and in every
/// version.
pub fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(fnv1a(name));
    rng
}

/// The 64-bit FNV-1a hash: unlike the standard library's, fixed by its definition.
fn fnv1a(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

//! Work on a cloud in parts, by one thread or several, with the same result.
//!
//! The cloud is cut into parts of a fixed size, whatever the number of threads, and each part has
//! a random stream of its own: who works on a part, and when, changes nothing.

use crate::{Likelihood, Motion, Particles, Poses, PosesMut, Result};
use loc_core::random::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Particles of one part: enough to keep a thread busy, few enough to stay in its fastest memory.
pub(crate) const PART: usize = 512;

/// The threads that move and weigh particles.
#[derive(Debug, Default)]
pub struct Workers {
    #[cfg(feature = "threads")]
    pool: Option<rayon::ThreadPool>,
}

impl Workers {
    /// The calling thread alone.
    pub fn one() -> Self {
        Workers::default()
    }

    /// `threads` threads; with 0 or 1, or without the feature `threads`, the calling one alone.
    ///
    /// # Errors
    /// [`crate::Error::Threads`] where the system refuses to start them.
    #[cfg(feature = "threads")]
    pub fn new(threads: usize) -> Result<Self> {
        let start = || rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let failed = |error: rayon::ThreadPoolBuildError| crate::Error::Threads {
            threads,
            reason: error.to_string(),
        };
        let pool = (threads > 1).then(start).transpose().map_err(failed)?;
        Ok(Workers { pool })
    }

    /// `threads` threads; with 0 or 1, or without the feature `threads`, the calling one alone.
    ///
    /// # Errors
    /// None without the feature.
    #[cfg(not(feature = "threads"))]
    pub fn new(_threads: usize) -> Result<Self> {
        Ok(Workers::default())
    }

    /// Moves every particle by `motion`.
    pub fn sample(&self, particles: &mut Particles, motion: &impl Motion, rng: &mut ChaCha8Rng) {
        let seed = rng.next_u64();
        let PosesMut { x, y, theta } = particles.poses_mut();
        let parts = x.chunks_mut(PART).zip(y.chunks_mut(PART)).zip(theta.chunks_mut(PART));
        self.for_each(parts.enumerate(), |(part, ((x, y), theta))| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(part as u64);
            motion.sample(PosesMut { x, y, theta }, &mut rng);
        });
    }

    /// Adds the log-likelihood of a measurement to the log weight of every particle.
    pub fn rate(&self, particles: &mut Particles, measurement: &impl Likelihood) {
        let (Poses { x, y, theta }, weights) = particles.poses_and_log_weights();
        let poses = x.chunks(PART).zip(y.chunks(PART)).zip(theta.chunks(PART));
        self.for_each(poses.zip(weights.chunks_mut(PART)), |(((x, y), theta), weights)| {
            measurement.rate(Poses { x, y, theta }, weights);
        });
    }

    /// Does `work` on every item, in any order.
    pub(crate) fn for_each<T: Send>(
        &self,
        items: impl Iterator<Item = T> + Send,
        work: impl Fn(T) + Sync,
    ) {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            use rayon::iter::{IntoParallelIterator, ParallelIterator};
            let items: Vec<T> = items.collect();
            pool.install(|| items.into_par_iter().for_each(&work));
            return;
        }
        items.for_each(work);
    }
}

//! Work on particles in parts, by one thread or several, with the same result.
//!
//! Particles are divided into parts of a fixed size, whatever the number of threads. Each part has
//! a random stream of its own, and sums over the particles are those of the parts, added up in
//! their order: which thread works on a part, and when, changes nothing.
//!
//! An idle thread goes to sleep after some microseconds, and waking it takes as many. An update of
//! the filter is a dozen loops, some shorter than that: so the whole update runs in
//! [`Workers::within`], and between its loops the threads stay awake.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_pf::{Particles, Workers};
//! let workers = Workers::new(2)?;
//! let mut particles = Particles::from_poses(vec![Pose2::IDENTITY; 2000]);
//! workers.within(|| {
//!     workers.rate(&mut particles, &|pose: Pose2| -pose.x.abs());
//!     workers.rate(&mut particles, &|pose: Pose2| -pose.y.abs());
//! });
//! assert_eq!(workers.threads(), 2);
//! # Ok::<(), loc_pf::Error>(())
//! ```

use crate::log_weights::{self, Mass};
use crate::{Likelihood, Motion, Particles, Result};
use loc_core::random::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Particles of one part: enough work for a thread, few enough for its first-level cache.
pub(crate) const PART: usize = 512;

/// The threads that work on particles; copies share them.
#[derive(Debug, Clone, Default)]
pub struct Workers {
    #[cfg(feature = "threads")]
    pool: Option<std::sync::Arc<rayon::ThreadPool>>,
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
        Ok(Workers { pool: pool.map(std::sync::Arc::new) })
    }

    /// `threads` threads; with 0 or 1, or without the feature `threads`, the calling one alone.
    ///
    /// # Errors
    /// None without the feature.
    #[cfg(not(feature = "threads"))]
    pub fn new(_threads: usize) -> Result<Self> {
        Ok(Workers::default())
    }

    /// How many threads there are.
    pub fn threads(&self) -> usize {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            return pool.current_num_threads();
        }
        1
    }

    /// Runs `work` on one of the threads while the others wait for parts of it. Faster around
    /// several short loops; the result is the same without.
    pub fn within<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            return pool.install(work);
        }
        work()
    }

    /// Runs both, on two threads where available.
    pub(crate) fn both<A: Send, B: Send>(
        &self,
        one: impl FnOnce() -> A + Send,
        other: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            return pool.join(one, other);
        }
        (one(), other())
    }

    /// Does `work` on every item, in any order.
    pub(crate) fn for_each<T: Send>(
        &self,
        items: impl Iterator<Item = T> + Send,
        work: impl Fn(T) + Sync,
    ) {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            let max = items.size_hint().1.unwrap_or(usize::MAX);
            if max > 1 {
                return work_off(pool, max, items, &work);
            }
        }
        items.for_each(work);
    }

    /// The results of `work` for every item, in the order of the items.
    pub(crate) fn map<T: Send, A: Send + Default>(
        &self,
        items: impl ExactSizeIterator<Item = T> + Send,
        work: impl Fn(T) -> A + Sync,
    ) -> Vec<A> {
        let mut answers = Vec::new();
        answers.resize_with(items.len(), A::default);
        self.for_each(items.zip(&mut answers), |(item, answer)| *answer = work(item));
        answers
    }

    /// Moves every particle by `motion`.
    pub fn sample(&self, particles: &mut Particles, motion: &impl Motion, rng: &mut ChaCha8Rng) {
        let seed = rng.next_u64();
        self.for_each(particles.poses_mut().chunks(PART).enumerate(), |(part, poses)| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(part as u64);
            motion.sample(poses, &mut rng);
        });
    }

    /// Adds the log-likelihood of a measurement to the log weight of every particle.
    pub fn rate(&self, particles: &mut Particles, measurement: &impl Likelihood) {
        let (poses, weights) = particles.poses_and_log_weights();
        self.for_each(poses.chunks(PART).zip(weights.chunks_mut(PART)), |(poses, weights)| {
            measurement.rate(poses, weights);
        });
    }

    /// The same, and adds up the weights that come out.
    pub(crate) fn rate_and_add_up(
        &self,
        particles: &mut Particles,
        measurement: &impl Likelihood,
    ) -> Mass {
        let (poses, weights) = particles.poses_and_log_weights();
        let parts = poses.chunks(PART).zip(weights.chunks_mut(PART));
        Mass::total(self.map(parts, |(poses, weights)| {
            measurement.rate(poses, weights);
            Mass::of(weights)
        }))
    }

    /// Adds up the weights.
    pub(crate) fn add_up(&self, particles: &Particles) -> Mass {
        Mass::total(self.map(particles.log_weights().chunks(PART), Mass::of))
    }

    /// Makes weights add up to 1, of which `mass` is the sum; see [`Particles::normalize`].
    pub(crate) fn divide_by(&self, particles: &mut Particles, mass: &Mass) -> f64 {
        let Some(sum) = mass.log_sum() else {
            particles.set_equal_weights();
            return f64::NEG_INFINITY;
        };
        let parts = particles.log_weights_mut().chunks_mut(PART);
        self.for_each(parts, |weights| log_weights::divide(weights, sum));
        sum
    }

    /// [`Particles::copy_selected`].
    pub(crate) fn copy_selected(&self, to: &mut Particles, from: &Particles, indices: &[u32]) {
        to.resize(indices.len());
        let parts = to.poses_mut().chunks(PART).zip(indices.chunks(PART));
        self.for_each(parts, |(poses, indices)| poses.copy_selected(from.poses(), indices));
    }
}

/// Lets the threads of a pool take items from a queue until none is left. A thread that starts late
/// finds fewer items, and no thread waits for another to start.
#[cfg(feature = "threads")]
fn work_off<T: Send>(
    pool: &rayon::ThreadPool,
    max: usize,
    items: impl Iterator<Item = T> + Send,
    work: &(impl Fn(T) + Sync),
) {
    use std::sync::{Mutex, PoisonError};

    let queue = Mutex::new(items);
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || {
        while let Some(item) = next() {
            work(item);
        }
    };
    let threads = pool.current_num_threads().min(max);
    pool.install(|| side_by_side(threads, &take));
}

#[cfg(feature = "threads")]
fn side_by_side(threads: usize, work: &(impl Fn() + Sync)) {
    if threads > 1 {
        rayon::join(work, || side_by_side(threads - 1, work));
    } else {
        work();
    }
}

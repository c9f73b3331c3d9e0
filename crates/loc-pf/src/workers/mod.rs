//! Work on a cloud in parts, by one thread or several, with the same result.
//!
//! The cloud is cut into parts of a fixed size, whatever the number of threads. Each part has a
//! random stream of its own, and sums over the cloud are those of the parts, added up in their
//! order: who works on a part, and when, changes nothing.
//!
//! A thread that has nothing to do falls asleep after some microseconds, and it takes as many to
//! wake it. An update of the filter is a dozen loops, some shorter than that: so the whole update
//! is handed over ([`Workers::within`]), and between its loops the threads stay awake.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_pf::{Particles, Workers};
//! let workers = Workers::new(2)?;
//! let mut cloud = Particles::from_poses(vec![Pose2::IDENTITY; 2000]);
//! workers.within(|| {
//!     workers.rate(&mut cloud, &|pose: Pose2| -pose.x.abs());
//!     workers.rate(&mut cloud, &|pose: Pose2| -pose.y.abs());
//! });
//! assert_eq!(workers.threads(), 2);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod cloud;
#[cfg(feature = "threads")]
mod queue;

use crate::Result;

/// Particles of one part: enough to keep a thread busy, few enough to stay in its fastest memory.
pub(crate) const PART: usize = 512;

/// The threads that work on a cloud; copies share them.
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

    /// Runs `work` on one of the threads while the others wait for parts of it. Worth it around
    /// several short loops; the result is the same without.
    pub fn within<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool {
            return pool.install(work);
        }
        work()
    }

    /// Does both, on two threads where there are.
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
            let most = items.size_hint().1.unwrap_or(usize::MAX);
            if most > 1 {
                return queue::work_off(pool, most, items, &work);
            }
        }
        items.for_each(work);
    }

    /// What `work` says of every item, in the order of the items.
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
}

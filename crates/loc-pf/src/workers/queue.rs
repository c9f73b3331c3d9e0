//! Threads that work off a queue.

use rayon::ThreadPool;
use std::sync::{Mutex, PoisonError};

/// Lets the threads of a pool take items until none is left. A thread that comes late finds
/// less to do, and nobody waits for one that does not come.
pub(super) fn work_off<T: Send>(
    pool: &ThreadPool,
    most: usize,
    items: impl Iterator<Item = T> + Send,
    work: &(impl Fn(T) + Sync),
) {
    let queue = Mutex::new(items);
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || {
        while let Some(item) = next() {
            work(item);
        }
    };
    let threads = pool.current_num_threads().min(most);
    pool.install(|| side_by_side(threads, &take));
}

fn side_by_side(threads: usize, work: &(impl Fn() + Sync)) {
    if threads > 1 {
        rayon::join(work, || side_by_side(threads - 1, work));
    } else {
        work();
    }
}

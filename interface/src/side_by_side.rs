//! Work on all processors: numbered jobs, workers that take the next one, and a caller that keeps
//! the results and may give all of it up.

use std::{
    convert::Infallible,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
        mpsc::{RecvTimeoutError, SyncSender, sync_channel},
    },
    thread,
    time::Duration,
};

/// Between two looks whether to go on.
const LOOK: Duration = Duration::from_millis(2);

/// What a worker takes its jobs from and brings its results to.
pub struct Jobs<'a, T> {
    /// Which of the workers this is, from 0.
    pub worker: usize,
    count: usize,
    next: &'a AtomicUsize,
    given_up: Arc<AtomicBool>,
    results: SyncSender<(usize, T)>,
}

impl<T> Jobs<'_, T> {
    /// The number of a job that nobody has taken; none when all are, or nobody waits any more.
    pub fn next(&self) -> Option<usize> {
        let job = self.next.fetch_add(1, Ordering::Relaxed);
        (job < self.count && !self.given_up.load(Ordering::Relaxed)).then_some(job)
    }

    /// Hands in a result.
    pub fn done(&self, job: usize, result: T) {
        // Where nobody takes it, all of it was given up.
        let _ = self.results.send((job, result));
    }

    /// Set once nobody waits for the results any more.
    pub fn given_up(&self) -> &Arc<AtomicBool> {
        &self.given_up
    }
}

/// What `work` makes of each number below `count`, in their order.
pub fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut made: Vec<Option<T>> = (0..count).map(|_| None).collect();
    let worker = |jobs: Jobs<'_, T>| {
        while let Some(i) = jobs.next() {
            jobs.done(i, work(i));
        }
    };
    let Ok(()) = side_by_side(count, worker, |result| {
        if let Some((i, result)) = result {
            made[i] = Some(result);
        }
        Ok::<_, Infallible>(())
    });
    made.into_iter().flatten().collect()
}

/// Runs `worker` on as many threads as there are processors, and no more than `count` jobs. `each`
/// is told every result as it comes, in any order, and is asked every few milliseconds without
/// one; its error gives everything up and is returned once all workers have ended.
///
/// # Errors
/// That of `each`.
pub fn side_by_side<T: Send, E>(
    count: usize,
    worker: impl Fn(Jobs<'_, T>) + Sync,
    mut each: impl FnMut(Option<(usize, T)>) -> Result<(), E>,
) -> Result<(), E> {
    let processors = thread::available_parallelism().map_or(1, usize::from);
    let (next, given_up) = (AtomicUsize::new(0), Arc::new(AtomicBool::new(false)));
    thread::scope(|scope| {
        let (results, receiver) = sync_channel(processors);
        for number in 0..processors.min(count) {
            let (next, given_up) = (&next, given_up.clone());
            let jobs = Jobs { worker: number, count, next, given_up, results: results.clone() };
            scope.spawn(|| worker(jobs));
        }
        drop(results);
        loop {
            let told = match receiver.recv_timeout(LOOK) {
                Ok(result) => each(Some(result)),
                Err(RecvTimeoutError::Timeout) => each(None),
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            if told.is_err() {
                given_up.store(true, Ordering::Relaxed);
                return told;
            }
        }
    })
}

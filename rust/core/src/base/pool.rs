//! Threads to work with: in, a number of them and the work; out, what the work returns.
//!
//! All parallel work is done in pools that last as long as the work, never in the pool that rayon keeps for a whole process: that one
//! has no threads in a process that was forked, where its work would wait for ever. A pool has at most as many threads as the system
//! gives, and none where it gives none: then the work is done on the thread that asks for it.

use std::env;
use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Threads for parallel work, until it is dropped.
#[derive(Debug)]
pub struct Pool(Option<ThreadPool>);

impl Pool {
    /// So many threads, by default one a processor. On a thread of a pool that has that many, whose ever it is, no others are started.
    pub fn new(threads: Option<usize>) -> Self {
        let is_at_hand =
            rayon::current_thread_index().is_some() && threads.is_none_or(|threads| threads == rayon::current_num_threads());
        Self(if is_at_hand { None } else { started(threads) })
    }

    /// Does the work on these threads and waits for it.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => here(work),
        }
    }

    /// Starts the work on so many threads and returns at once; where there are none, it is done before this returns. Whoever waits
    /// for it hears of a panic by what the work then drops, such as the sender of a channel.
    pub fn start(threads: Option<usize>, work: impl FnOnce() + Send + 'static) {
        match started(threads) {
            // Its threads end when the work is done.
            Some(pool) => pool.spawn(work),
            // A panic has said what it has to say.
            None => drop(catch_unwind(AssertUnwindSafe(|| here(work)))),
        }
    }
}

/// As many of these threads as there can be; `None` if there can be none.
fn started(threads: Option<usize>) -> Option<ThreadPool> {
    let mut threads = threads.unwrap_or_else(one_a_processor);
    while threads > 0 {
        // By default a panic that nobody waits for would end the process.
        let builder = ThreadPoolBuilder::new().num_threads(threads).thread_name(|_| "graphstipple".into()).panic_handler(drop);
        if let Ok(pool) = builder.build() {
            return Some(pool);
        }
        threads /= 2;
    }
    None
}

/// Does the work on the thread that asks, which may be one of a pool. If it is not, it becomes one of a pool without any other, and
/// stays so: what rayon keeps for that, a few kilobytes once a thread, is never given back.
fn here<T>(work: impl FnOnce() -> T) -> T {
    if rayon::current_thread_index().is_none() {
        let alone = ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        debug_assert!(alone.is_ok(), "nothing is started, so nothing can fail");
    }
    work()
}

/// The number of processors, or a smaller one that rayon's own variable tells.
fn one_a_processor() -> usize {
    let processors = thread::available_parallelism().map_or(1, NonZero::get);
    let told = env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok());
    told.filter(|threads| (1..=processors).contains(threads)).unwrap_or(processors)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{RecvTimeoutError, channel};
    use std::time::Duration;

    use rayon::prelude::*;

    use super::*;

    fn sum() -> u64 {
        (0..100_000u64).into_par_iter().sum()
    }

    #[test]
    fn work_is_done_on_as_many_threads_as_were_asked_for() {
        for threads in [1, 2, 5] {
            let pool = Pool::new(Some(threads));
            assert_eq!(pool.run(|| (rayon::current_num_threads(), sum())), (threads, 4_999_950_000));
            // Within it no other is made, unless another number is asked for.
            let within = |asked| pool.run(|| Pool::new(asked).run(rayon::current_num_threads));
            assert_eq!([None, Some(threads), Some(3)].map(within), [threads, threads, 3]);
        }
        assert_eq!(Pool::new(None).run(rayon::current_num_threads), one_a_processor());
    }

    #[test]
    fn work_that_is_started_goes_on_by_itself() {
        let (sender, receiver) = channel();
        Pool::start(Some(2), move || sender.send((rayon::current_num_threads(), sum())).unwrap());
        assert_eq!(receiver.recv(), Ok((2, 4_999_950_000)));
    }

    #[test]
    fn a_panic_ends_nothing_but_the_work() {
        let (sender, receiver) = channel::<()>();
        Pool::start(Some(2), move || {
            let _kept = sender;
            panic!("on purpose");
        });
        assert_eq!(receiver.recv_timeout(Duration::from_secs(10)), Err(RecvTimeoutError::Disconnected));
    }

    #[test]
    fn a_thread_alone_does_the_work_itself_again_and_again() {
        // As where no thread can be had.
        let alone = Pool(None);
        thread::scope(|scope| {
            scope.spawn(|| {
                for _ in 0..3 {
                    let me = thread::current().id();
                    let done = || (rayon::current_num_threads(), sum(), rayon::join(|| thread::current().id(), sum).0);
                    assert_eq!(alone.run(done), (1, 4_999_950_000, me));
                    // It may still have others work for it.
                    assert_eq!(Pool::new(Some(2)).run(|| (rayon::current_num_threads(), sum())), (2, 4_999_950_000));
                }
            });
        });
    }
}

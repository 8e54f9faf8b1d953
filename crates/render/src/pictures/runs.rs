//! Passes over the pixels of a picture, on all cores.
//!
//! Threads are those of each pass alone: rayon's own pool would be dead in a forked process, as Python makes them, and a pass
//! takes a hundred times as long as it takes to start a few threads. Small pictures are done by the caller.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::thread;

use bytemuck::{Zeroable, zeroed_vec};
use raggio_kernels::FilmPixel;

use crate::devices::machine::cores;

/// Pixels that a thread takes at a time. Their number is fixed, so that what adds up floating-point numbers run by run gets
/// the same sum on all machines.
pub(crate) const RUN: usize = 1 << 14;
/// Pixels for which another thread pays.
const WORTH_A_THREAD: usize = 1 << 14;

/// Results of `work` for runs of `count` pixels, in their order.
pub(crate) fn in_runs<R: Send>(count: usize, work: impl Fn(Range<usize>) -> R + Sync) -> Vec<R> {
    let runs = (0..count).step_by(RUN).map(|first| first..count.min(first + RUN));
    on_threads(count, runs, work)
}

/// Has `work` fill `pixels`, or change them, run by run: it is given the place of the first.
pub(crate) fn fill<T: Send>(pixels: &mut [T], work: impl Fn(usize, &mut [T]) + Sync) {
    let count = pixels.len();
    let runs = pixels.chunks_mut(RUN).enumerate();
    on_threads(count, runs, |(i, run)| work(i * RUN, run));
}

/// What `value` makes of each of `count` pixels, in their order.
pub(crate) fn collect<T: Zeroable + Send>(count: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    // Memory that the system gives zeroed is touched by those alone who fill it.
    let mut values = zeroed_vec(count);
    fill(&mut values, |first, run| run.iter_mut().enumerate().for_each(|(i, place)| *place = value(first + i)));
    values
}

/// Copies `from`, which is as long.
pub(crate) fn copy(to: &mut [u8], from: &[u8]) {
    const RUN: usize = 1 << 19;
    let bytes_of_a_pixel = size_of::<FilmPixel>();
    let runs = to.chunks_mut(RUN).zip(from.chunks(RUN));
    on_threads(from.len() / bytes_of_a_pixel, runs, |(to, from)| to.copy_from_slice(from));
}

/// Results of `work` for all of `runs`, in their order, which together have `count` pixels.
fn on_threads<I: Send, R: Send>(
    count: usize,
    runs: impl Iterator<Item = I> + Send,
    work: impl Fn(I) -> R + Sync,
) -> Vec<R> {
    let threads = (count / WORTH_A_THREAD).min(cores());
    if threads < 2 {
        return runs.map(work).collect();
    }
    let runs = Mutex::new(runs.enumerate());
    let next = || runs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || std::iter::from_fn(next).map(|(i, run)| (i, work(run))).collect::<Vec<_>>();
    let mut results = thread::scope(|scope| {
        // Where the system refuses threads, those that there are do it all.
        let others: Vec<_> =
            (1..threads).map_while(|_| thread::Builder::new().spawn_scoped(scope, take).ok()).collect();
        let mut results = take();
        for other in others {
            results.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        results
    });
    results.sort_unstable_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_come_in_their_order_and_are_done_once() {
        for count in [0, 1, RUN - 1, RUN, 3 * RUN + 5, 40 * RUN + 1] {
            let runs = in_runs(count, |run| run);
            assert_eq!(runs.iter().map(|run| run.len()).sum::<usize>(), count);
            assert!(runs.iter().zip(runs.iter().skip(1)).all(|(a, b)| a.end == b.start && a.len() == RUN));
            assert_eq!(collect(count, |i| i), (0..count).collect::<Vec<_>>());
            let mut times = vec![0u8; count];
            fill(&mut times, |_, run| run.iter_mut().for_each(|times| *times += 1));
            assert!(times.iter().all(|times| *times == 1));
        }
    }

    #[test]
    #[should_panic(expected = "a pixel that cannot be")]
    fn a_panic_of_a_thread_is_the_callers() {
        in_runs(40 * RUN, |run| assert!(run.start != 20 * RUN, "a pixel that cannot be"));
    }
}

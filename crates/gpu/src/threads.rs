//! Work of the CPU divided among threads of its own.
//!
//! A shared pool would not do: while a batch waits for its part, the pool may start another batch
//! on the same thread, which then waits for the lock that this thread holds.

use std::num::NonZero;
use std::sync::OnceLock;
use std::thread;

/// Largest number of threads: more do not copy faster.
const MAX_THREADS: usize = 8;

/// Returns the results of `work` in the order of the items. A thread is started for every `least`
/// items, up to the number of cores or [`MAX_THREADS`].
pub(crate) fn map<T: Send, R: Send>(
    items: Vec<T>,
    least: usize,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let threads = cores().min(MAX_THREADS).min(items.len() / least.max(1));
    if threads < 2 {
        return items.into_iter().map(work).collect();
    }
    let share = items.len().div_ceil(threads);
    let mut items = items.into_iter();
    thread::scope(|scope| {
        let work = &work;
        let mut running = Vec::with_capacity(threads);
        for _ in 0..threads {
            let part: Vec<T> = items.by_ref().take(share).collect();
            running.push(scope.spawn(move || part.into_iter().map(work).collect::<Vec<R>>()));
        }
        let results = running.into_iter().map(|part| part.join());
        results
            .flat_map(|part| part.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

/// Returns the number of cores, read once: the system call opens files.
fn cores() -> usize {
    static CORES: OnceLock<usize> = OnceLock::new();
    *CORES.get_or_init(|| thread::available_parallelism().map_or(1, NonZero::get))
}

#[cfg(test)]
mod tests {
    use super::map;

    #[test]
    fn results_are_in_the_order_of_the_items_for_every_division() {
        for len in [0, 1, 7, 64, 1001] {
            for least in [1, 3, 100] {
                let expected: Vec<usize> = (0..len).map(|item| 2 * item).collect();
                assert_eq!(
                    map((0..len).collect(), least, |item| 2 * item),
                    expected,
                    "{len} {least}"
                );
            }
        }
    }
}

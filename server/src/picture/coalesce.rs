//! Batching of requests: twenty requests for pictures of one frame become one job.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Mutex;

/// Batches of items by a common key.
#[derive(Debug)]
pub struct Coalescer<F, T> {
    batches: Mutex<HashMap<F, Vec<T>>>,
}

impl<F: Eq + Hash, T> Coalescer<F, T> {
    /// Creates an empty set of batches.
    pub fn new() -> Self {
        Self { batches: Mutex::new(HashMap::new()) }
    }

    /// Adds an item; true if it begins a new batch, which the caller must take later.
    pub fn add(&self, common: F, item: T) -> bool {
        let mut batches = self.batches.lock().expect("nothing panics under this lock");
        let batch = batches.entry(common).or_default();
        batch.push(item);
        batch.len() == 1
    }

    /// Removes and returns a batch; later items begin a new one.
    pub fn take(&self, common: &F) -> Vec<T> {
        let mut batches = self.batches.lock().expect("nothing panics under this lock");
        batches.remove(common).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_of_one_frame_make_one_batch() {
        let coalescer = Coalescer::new();
        let first: Vec<_> =
            [("a", 1), ("a", 2), ("b", 3)].map(|(frame, item)| coalescer.add(frame, item)).to_vec();
        assert_eq!(first, [true, false, true]);
        assert_eq!(coalescer.take(&"a"), [1, 2]);
        assert!(coalescer.take(&"a").is_empty());
        assert!(coalescer.add("a", 4));
        assert_eq!(coalescer.take(&"b"), [3]);
    }
}

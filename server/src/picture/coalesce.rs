//! Gathers what is wanted within a moment into batches: twenty requests for the pictures of one frame are one job.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::Mutex;

/// Batches by what their items have in common.
#[derive(Debug)]
pub struct Coalescer<F, T> {
    batches: Mutex<HashMap<F, Vec<T>>>,
}

impl<F: Eq + Hash, T> Coalescer<F, T> {
    /// No batches yet.
    pub fn new() -> Self {
        Self { batches: Mutex::new(HashMap::new()) }
    }

    /// Adds to a batch; true where it is a new one, which the caller takes a moment later.
    pub fn add(&self, common: F, item: T) -> bool {
        let mut batches = self.batches.lock().expect("nothing panics under this lock");
        let batch = batches.entry(common).or_default();
        batch.push(item);
        batch.len() == 1
    }

    /// Takes a batch; what is added from now on makes a new one.
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

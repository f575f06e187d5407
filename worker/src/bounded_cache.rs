//! One cache with one limit in bytes for everything that a renderer derives: meshes, sample sets,
//! programs, parsed targets and light files.
//!
//! Dropping an entry costs time and changes no result. The limit is shared, so that a renderer that
//! only draws programs uses all of it for sample sets.

use std::any::{Any, TypeId};
use std::sync::Arc;

use moka::policy::EvictionPolicy;
use moka::sync::Cache;

/// Value with its weight in KiB.
type Entry = (Arc<dyn Any + Send + Sync>, u32);

/// Shared cache; clones refer to the same entries. Drops the least recently used entries, and does
/// not keep a value that is larger than the limit.
#[derive(Clone)]
pub(crate) struct BoundedCache {
    /// By type and hash.
    entries: Cache<(TypeId, [u8; 32]), Entry>,
}

impl BoundedCache {
    /// Creates a cache of at most `bytes`.
    pub(crate) fn new(bytes: u64) -> Self {
        let entries = Cache::builder()
            .max_capacity((bytes / 1024).max(1))
            .weigher(|_, (_, kib): &Entry| *kib)
            .eviction_policy(EvictionPolicy::lru())
            .build();
        Self { entries }
    }

    /// Returns a value if it is in the cache.
    pub(crate) fn get<T: Send + Sync + 'static>(&self, key: [u8; 32]) -> Option<Arc<T>> {
        self.entries.get(&(TypeId::of::<T>(), key)).map(|entry| typed(entry))
    }

    /// Adds a value of about `bytes`.
    pub(crate) fn insert<T: Send + Sync + 'static>(
        &self,
        key: [u8; 32],
        value: Arc<T>,
        bytes: usize,
    ) {
        self.entries.insert((TypeId::of::<T>(), key), (value, kib(bytes)));
    }

    /// Returns a value, or makes and adds it. `make` also returns its size in bytes. Concurrent
    /// callers wait for the one that makes it.
    ///
    /// # Errors
    /// Returns the error of `make`.
    pub(crate) fn get_or_make<T: Send + Sync + 'static, E: Send + Sync + 'static>(
        &self,
        key: [u8; 32],
        make: impl FnOnce() -> Result<(Arc<T>, usize), E>,
    ) -> Result<Arc<T>, Arc<E>> {
        let entry = self.entries.try_get_with((TypeId::of::<T>(), key), || {
            let (value, bytes) = make()?;
            Ok::<Entry, E>((value, kib(bytes)))
        })?;
        Ok(typed(entry))
    }
}

/// Returns the value of an entry; its key contains its type.
fn typed<T: Send + Sync + 'static>((value, _): Entry) -> Arc<T> {
    value.downcast().expect("the type is part of the key")
}

fn kib(bytes: usize) -> u32 {
    u32::try_from(bytes / 1024 + 1).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_all_types_share_one_limit() {
        let cache = BoundedCache::new(64 << 10);
        for name in 0..16u8 {
            cache.insert([name; 32], Arc::new(u64::from(name)), 10 << 10);
            cache.insert([name; 32], Arc::new(format!("{name}")), 10 << 10);
        }
        cache.entries.run_pending_tasks();
        assert!(cache.entries.weighted_size() <= 64, "{} KiB", cache.entries.weighted_size());
        assert_eq!(cache.get::<u64>([15; 32]).as_deref(), Some(&15));
        assert_eq!(cache.get::<String>([15; 32]).as_deref(), Some(&"15".to_owned()));
        assert_eq!(cache.get::<u64>([0; 32]), None, "the oldest is dropped");
    }

    #[test]
    fn value_larger_than_the_limit_is_made_but_not_kept() {
        let cache = BoundedCache::new(64 << 10);
        cache.insert([1; 32], Arc::new(1u64), 10 << 10);
        let made = cache.get_or_make([2; 32], || Ok::<_, ()>((Arc::new(2u64), 1 << 20)));
        assert_eq!(made.as_deref(), Ok(&2));
        cache.entries.run_pending_tasks();
        assert_eq!(cache.get::<u64>([2; 32]), None);
        assert!(cache.get::<u64>([1; 32]).is_some(), "the others stay");
        assert_eq!(*cache.get_or_make::<u64, _>([3; 32], || Err("no")).unwrap_err(), "no");
    }
}

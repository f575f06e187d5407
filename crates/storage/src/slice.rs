//! Long work in many transactions of about [`SLICE`], so that other writes wait no longer than one.

use std::time::Duration;

use crate::error::Result;
use crate::sql::Conn;
use crate::write::{Durability, WriteFuture};
use crate::{StorageError, Store};

/// Time that the statements of a transaction take.
const SLICE: Duration = Duration::from_millis(15);

/// Size of the next transaction.
#[derive(Debug)]
pub(crate) struct Pace {
    size: u32,
    largest: u32,
}

impl Pace {
    pub(crate) fn new(first: u32, largest: u32) -> Self {
        Self { size: first, largest }
    }

    /// Size of the next transaction, at least 1.
    pub(crate) fn size(&self) -> u32 {
        self.size
    }

    /// Adapts the size to the time that a transaction has taken.
    pub(crate) fn adapt(&mut self, elapsed: Duration) {
        if elapsed > SLICE {
            self.size = (self.size / 2).max(1);
        } else if elapsed < SLICE / 2 {
            self.size = (self.size * 2).min(self.largest);
        }
    }
}

impl Store {
    /// Writes one slice; waits while there are too many other writes. The last one must be durable
    /// against power loss, which makes the others durable too.
    pub(crate) async fn write_slice<T, F>(
        &self,
        durability: Durability,
        operation: impl Fn() -> F,
    ) -> Result<T>
    where
        T: Send + 'static,
        F: for<'c> FnOnce(&'c mut Conn) -> WriteFuture<'c, Result<T>> + Send + 'static,
    {
        loop {
            match self.write_as(durability, operation()).await {
                Err(StorageError::Busy) => tokio::time::sleep(SLICE).await,
                written => return Ok(written?.0),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn size_follows_the_time_of_transactions() {
        let mut pace = Pace::new(4, 16);
        for (elapsed, size) in [(1, 8), (1, 16), (1, 16), (10, 16), (40, 8), (40, 4)] {
            pace.adapt(Duration::from_millis(elapsed));
            assert_eq!(pace.size(), size);
        }
        for _ in 0..5 {
            pace.adapt(SLICE * 2);
        }
        assert_eq!(pace.size(), 1);
    }
}

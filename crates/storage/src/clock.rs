//! Clock of leases in a SQLite file. Jumps of the time of day do not move it.

use std::sync::OnceLock;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Returns the time of day at the first call plus the time since, in milliseconds since 1970-01-01
/// UTC.
pub(crate) fn steady_ms() -> i64 {
    static START: OnceLock<(Instant, i64)> = OnceLock::new();
    let (begun, start_ms) = START.get_or_init(|| {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        (Instant::now(), millis(now))
    });
    start_ms + millis(begun.elapsed())
}

fn millis(time: std::time::Duration) -> i64 {
    i64::try_from(time.as_millis()).unwrap_or(i64::MAX)
}

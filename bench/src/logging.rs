//! Logging to stderr, filtered by `BROOD_LOG`. A service writes at most 20 lines of one kind in
//! 10 s, so that a repeated failure does not fill the disk, and counts the others.

use std::collections::HashMap;
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use tracing::callsite::Identifier;
use tracing::{Event, Level, Metadata, Subscriber};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::layer::{Context, Filter, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// Default filter of long-running commands.
const SERVICE: &str = "info,hyper=warn,hyper_util=warn,reqwest=warn,sqlx=warn,object_store=warn,wgpu_core=warn,wgpu_hal=error,naga=warn";
/// Default filter of offline commands.
const OFFLINE: &str = "warn,wgpu_hal=error";
/// Largest number of lines of one kind in [`WINDOW`].
const LINES: u32 = 20;
const WINDOW: Duration = Duration::from_secs(10);

/// Starts logging for `serve` and `worker`.
pub fn start_service() {
    let limit = LineLimit::default();
    start(SERVICE, Some(limit.clone()));
    let summary = std::thread::Builder::new().name("log".to_owned()).spawn(move || {
        loop {
            std::thread::sleep(WINDOW);
            for (place, lines) in limit.take_left_out() {
                tracing::warn!(target: "brood::log", place, lines, "more lines of this kind were left out");
            }
        }
    });
    if let Err(error) = summary {
        tracing::warn!(%error, "left out lines of the log are not counted");
    }
}

/// Starts logging for commands that print a result and end.
pub fn start_offline() {
    start(OFFLINE, None);
}

fn start(default: &str, limit: Option<LineLimit>) {
    let filter = EnvFilter::try_from_env("BROOD_LOG").unwrap_or_else(|_| EnvFilter::new(default));
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal());
    // Fails only in tests that run two commands in one process; the first subscriber stays.
    let _ = tracing_subscriber::registry().with(filter).with(lines.with_filter(limit)).try_init();
}

/// Filter that leaves out lines beyond [`LINES`] in [`WINDOW`] from one place in the code. Does not
/// limit lines below `INFO`. Clones share the counts.
#[derive(Debug, Clone, Default)]
struct LineLimit(Arc<Mutex<HashMap<Identifier, Kind>>>);

/// Lines of one kind in the current window.
#[derive(Debug)]
struct Kind {
    since: Instant,
    lines: u32,
    left_out: u64,
    place: String,
}

impl LineLimit {
    /// True if a line of this kind may be written at this time.
    fn allows(&self, metadata: &Metadata<'_>, now: Instant) -> bool {
        if *metadata.level() > Level::INFO {
            return true;
        }
        let mut kinds = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let kind = kinds.entry(metadata.callsite()).or_insert_with(|| {
            let line = metadata.line().unwrap_or(0);
            let place = format!("{}:{line}", metadata.module_path().unwrap_or("unknown"));
            Kind { since: now, lines: 0, left_out: 0, place }
        });
        if now.duration_since(kind.since) >= WINDOW {
            (kind.since, kind.lines) = (now, 0);
        }
        let allowed = kind.lines < LINES;
        kind.lines += u32::from(allowed);
        kind.left_out += u64::from(!allowed);
        allowed
    }

    /// Returns the places whose lines were left out since the last call, with their number.
    fn take_left_out(&self) -> Vec<(String, u64)> {
        let mut kinds = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let kinds = kinds.values_mut().filter(|kind| kind.left_out > 0);
        kinds.map(|kind| (kind.place.clone(), std::mem::take(&mut kind.left_out))).collect()
    }
}

impl<S: Subscriber> Filter<S> for LineLimit {
    fn enabled(&self, _: &Metadata<'_>, _: &Context<'_, S>) -> bool {
        true
    }

    fn event_enabled(&self, event: &Event<'_>, _: &Context<'_, S>) -> bool {
        self.allows(event.metadata(), Instant::now())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    /// Counts the lines that pass.
    struct Written(Arc<AtomicU32>);

    impl<S: Subscriber> Layer<S> for Written {
        fn on_event(&self, _: &Event<'_>, _: Context<'_, S>) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    #[test]
    fn lines_of_one_kind_are_limited_and_the_others_are_counted() {
        let written = Arc::new(AtomicU32::new(0));
        let limit = LineLimit::default();
        let lines = Written(written.clone()).with_filter(limit.clone());
        let subscriber = tracing_subscriber::registry().with(lines);
        tracing::subscriber::with_default(subscriber, || {
            for number in 0..100 {
                tracing::warn!(number, "often");
                tracing::debug!(number, "never limited");
            }
            tracing::info!("seldom");
        });
        assert_eq!(written.load(Ordering::Relaxed), LINES + 100 + 1);
        let left_out = limit.take_left_out();
        assert_eq!(left_out.iter().map(|(_, lines)| lines).sum::<u64>(), 80);
        assert!(left_out[0].0.starts_with("brood_bench::logging::tests:"), "{left_out:?}");
        assert!(limit.take_left_out().is_empty());
    }
}

//! Logging to stderr, filtered by `BROOD_LOG`.

use std::io::IsTerminal;

use tracing_subscriber::EnvFilter;

/// Default filter of long-running commands.
const SERVICE: &str = "info,hyper=warn,hyper_util=warn,reqwest=warn,sqlx=warn,wgpu_core=warn,wgpu_hal=error,naga=warn";
/// Default filter of offline commands.
const OFFLINE: &str = "warn,wgpu_hal=error";

/// Starts logging for `serve` and `worker`.
pub fn start_service() {
    start(SERVICE);
}

/// Starts logging for commands that print a result and end.
pub fn start_offline() {
    start(OFFLINE);
}

fn start(default: &str) {
    let filter = EnvFilter::try_from_env("BROOD_LOG").unwrap_or_else(|_| EnvFilter::new(default));
    // Fails only in tests that run two commands in one process; the first subscriber stays.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .try_init();
}

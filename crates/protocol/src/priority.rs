//! Priority of threads that do long work while people wait for short work on the same processors.

/// Lowers the priority of the calling thread, and of threads that it starts later. Has an effect on
/// Linux only: elsewhere it would change the whole process.
pub fn lower_thread_priority() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::nice(NICE) {
        // The work is done at normal priority instead.
        tracing::warn!(%error, "cannot lower the priority of a thread");
    }
}

/// The lowest: a hundredth of a processor that threads of normal priority use as well.
#[cfg(target_os = "linux")]
const NICE: i32 = 19;

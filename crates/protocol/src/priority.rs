//! Priority of threads that do long work while people wait for short work on the same processors.

#[cfg(target_os = "linux")]
use thread_priority::{
    Error, NormalThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Lowers the priority of the calling thread, and of threads that it starts later, to the lowest: a
/// hundredth of a processor that threads of normal priority use as well. Has an effect on Linux
/// only: elsewhere it would change the whole process.
pub fn lower_thread_priority() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::nice(NICE) {
        // The work is done at normal priority instead.
        tracing::warn!(%error, "cannot lower the priority of a thread");
    }
}

/// Lets the calling thread, and threads that it starts later, use only processors that no other
/// thread wants: a thread that wakes up takes the processor at once. Threads of
/// [`lower_thread_priority`] keep it to the end of their time slice. Has an effect on Linux only.
pub fn idle_thread_priority() {
    // ACCESS: the policy is set. The niceness, which has no effect on idle threads, is not changed.
    #[cfg(target_os = "linux")]
    if let Err(error) = set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Min,
        ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle),
    ) && error != Error::OS(rustix::io::Errno::ACCESS.raw_os_error())
    {
        tracing::warn!(?error, "cannot give a thread the priority idle");
    }
}

/// Lowest priority of a thread.
#[cfg(target_os = "linux")]
const NICE: i32 = 19;

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    /// Niceness and policy of a thread of its own after a change.
    fn after(change: fn()) -> [i32; 2] {
        let thread = std::thread::spawn(move || {
            change();
            std::fs::read_to_string("/proc/thread-self/stat").unwrap()
        });
        let stat = thread.join().unwrap();
        // proc_pid_stat(5): fields 3 and later are behind the name.
        let fields: Vec<_> = stat[stat.rfind(')').unwrap() + 2..].split(' ').collect();
        [19, 41].map(|field| fields[field - 3].parse().unwrap())
    }

    #[test]
    fn priority_is_lowered_to_nice_19_or_to_idle() {
        const IDLE: i32 = 5;
        assert_eq!(after(lower_thread_priority)[0], 19);
        assert_eq!(after(idle_thread_priority)[1], IDLE);
        let both = || {
            lower_thread_priority();
            idle_thread_priority();
        };
        assert_eq!(after(both)[1], IDLE);
    }
}

//! Numbers of the batches that the other servers have sent, which show that messages were lost.

use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Time without a batch of a server after which its last messages count as lost.
pub(super) const SILENCE: Duration = Duration::from_secs(5);
/// Losses within this time are reported together: after an outage each server has one.
const COLLECT: Duration = Duration::from_secs(2);

/// Last batch of each server. A run of a server has a name of its own and counts from 1.
#[derive(Debug, Default)]
pub(super) struct Seen {
    servers: HashMap<String, Last>,
    /// Time of the next report; `None` if nothing was lost.
    due: Option<Instant>,
}

#[derive(Debug)]
struct Last {
    number: u64,
    at: Instant,
}

impl Seen {
    /// Notes a batch. Returns false if it was received before: a sender repeats a batch whose
    /// NOTIFY was not answered.
    pub(super) fn note(&mut self, name: &str, number: u64, now: Instant) -> bool {
        let last = self.servers.get(name).map_or(0, |last| last.number);
        if number <= last {
            return false;
        }
        // A server that was not seen before may have sent batches before this one listened.
        if number > last + 1 {
            self.lose(now);
        }
        self.servers.insert(name.to_owned(), Last { number, at: now });
        true
    }

    /// Notes that batches of any server may have been lost.
    pub(super) fn lose_all(&mut self, now: Instant) {
        self.servers.clear();
        self.lose(now);
    }

    /// Returns true if a loss must be reported now. Servers that are silent count as a loss, once.
    pub(super) fn take_loss(&mut self, now: Instant) -> bool {
        let known = self.servers.len();
        self.servers.retain(|_, last| now.duration_since(last.at) < SILENCE);
        if self.servers.len() < known {
            self.lose(now);
        }
        let is_due = self.due.is_some_and(|due| due <= now);
        if is_due {
            self.due = None;
        }
        is_due
    }

    fn lose(&mut self, now: Instant) {
        self.due = Some(self.due.unwrap_or(now + COLLECT));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// Sends a batch each second, so that the server is never silent. Returns the number of losses
    /// that are reported until the last one.
    fn losses(numbers: impl IntoIterator<Item = u64>) -> usize {
        let (mut seen, mut now, mut losses) = (Seen::default(), Instant::now(), 0);
        for number in numbers {
            seen.note("a", number, now);
            now += SECOND;
            losses += usize::from(seen.take_loss(now));
        }
        losses
    }

    #[test]
    fn nothing_is_lost_while_the_numbers_follow_each_other_from_1() {
        assert_eq!(losses(1..20), 0);
    }

    #[test]
    fn loss_is_reported_once_when_a_number_is_missing() {
        assert_eq!(losses([1, 2, 4, 5, 6, 7, 8]), 1);
        assert_eq!(losses([1, 3, 4, 5, 6, 9, 10, 11]), 2);
        assert_eq!(losses([1, 3, 5, 6, 7, 8]), 1, "losses within a short time are one");
    }

    #[test]
    fn loss_is_reported_when_the_first_number_of_a_server_is_not_1() {
        assert_eq!(losses(57..70), 1);
    }

    #[test]
    fn batch_that_is_sent_again_is_skipped() {
        let (mut seen, now) = (Seen::default(), Instant::now());
        assert!(seen.note("a", 1, now) && seen.note("a", 2, now));
        assert!(!seen.note("a", 2, now) && !seen.note("a", 1, now));
        assert!(seen.note("a", 3, now) && seen.note("b", 1, now));
        assert!(!seen.take_loss(now + COLLECT));
    }

    #[test]
    fn loss_is_reported_once_when_a_server_falls_silent() {
        let (mut seen, start) = (Seen::default(), Instant::now());
        seen.note("a", 1, start);
        seen.note("b", 1, start);
        let mut losses = 0;
        for second in 1..30 {
            let now = start + second * SECOND;
            seen.note("b", 1 + u64::from(second), now);
            losses += u32::from(seen.take_loss(now));
        }
        assert_eq!(losses, 1);
    }

    #[test]
    fn loss_is_reported_once_when_the_connection_was_lost() {
        let (mut seen, start) = (Seen::default(), Instant::now());
        for name in ["a", "b", "c"] {
            seen.note(name, 1, start);
        }
        seen.lose_all(start);
        for name in ["a", "b", "c"] {
            seen.note(name, 7, start + SECOND);
        }
        assert!(!seen.take_loss(start + SECOND));
        assert!(seen.take_loss(start + COLLECT));
        assert!(!seen.take_loss(start + 2 * COLLECT));
    }
}

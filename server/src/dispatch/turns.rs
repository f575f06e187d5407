//! Places of render jobs in their queues: clients take turns, so that one with a thousand jobs does
//! not keep others waiting.
//!
//! Start-time fair queueing (Goyal, Vin and Cheng 1996): a job begins at the virtual time at which
//! the last job of its client ends, but not before the virtual time of its queue, which is the
//! start of the job that was claimed last. The length of a job is the number of its rays.

use std::collections::HashMap;

use brood_protocol::Queue;

use crate::client::Client;

/// Number of clients after which those without a waiting job are forgotten.
const CLIENTS: usize = 1024;

/// Virtual times of the queues.
#[derive(Debug, Default)]
pub struct Turns {
    queues: HashMap<Queue, VirtualTimes>,
}

#[derive(Debug, Default)]
struct VirtualTimes {
    now: u64,
    /// End of the last job of each client.
    ends: HashMap<Client, u64>,
}

impl Turns {
    /// Returns the place of a new job of a client, which traces this many rays.
    pub fn next(&mut self, queue: Queue, client: Client, rays: u64) -> u64 {
        let times = self.queues.entry(queue).or_default();
        if times.ends.len() >= CLIENTS {
            let now = times.now;
            times.ends.retain(|_, end| *end > now);
        }
        let end = times.ends.entry(client).or_default();
        let start = times.now.max(*end);
        *end = start.saturating_add(rays.max(1));
        start
    }

    /// Notes that the job with this place was claimed.
    pub fn claimed(&mut self, queue: Queue, turn: u64) {
        let times = self.queues.entry(queue).or_default();
        times.now = times.now.max(turn);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clients_take_turns_in_proportion_to_their_rays() {
        let mut turns = Turns::default();
        let (many, few) = (Client::Token([1; 32]), Client::Token([2; 32]));
        let queue = Queue::Interactive;
        let mut waiting: Vec<(u64, Client)> =
            (0..100).map(|_| (turns.next(queue, many, 10), many)).collect();
        let mut order = Vec::new();
        for step in 0..60 {
            // The other client comes later and asks for jobs of double length.
            if (20..30).contains(&step) {
                waiting.push((turns.next(queue, few, 20), few));
            }
            let first = (0..waiting.len()).min_by_key(|at| waiting[*at].0).unwrap();
            let (turn, client) = waiting.remove(first);
            turns.claimed(queue, turn);
            order.push(client);
        }
        assert!(order[..20].iter().all(|client| *client == many));
        let share = order[20..50].iter().filter(|client| **client == few).count();
        assert_eq!(share, 10, "a third of the jobs, half of the rays");
        assert_eq!(turns.next(Queue::Batch, many, 1), 0, "queues are independent");
    }

    #[test]
    fn clients_without_waiting_jobs_are_forgotten() {
        let mut turns = Turns::default();
        for n in 0..5000_u32 {
            let client = Client::Address(std::net::Ipv4Addr::from(n).into());
            let turn = turns.next(Queue::Interactive, client, 7);
            turns.claimed(Queue::Interactive, turn + 7);
        }
        assert!(turns.queues[&Queue::Interactive].ends.len() <= CLIENTS);
    }
}

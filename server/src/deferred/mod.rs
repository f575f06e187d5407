//! Deferred answers: a request with `Prefer: respond-async` that takes longer than its client
//! waits is answered with 202 and a job. The answer is kept in memory until it expires.

mod progress;
mod table;

pub use progress::{AnswerProgress, in_time, longest_wait};
pub use table::{Deferred, RequestOutline};

//! Durations of a request's stages, for the `Server-Timing` header (W3C) that browsers display.

use std::fmt::Write;
use std::time::{Duration, Instant};

use http::HeaderValue;

/// Durations of the stages so far, in order.
#[derive(Debug)]
pub struct ServerTiming {
    last: Instant,
    done: Vec<(&'static str, Duration)>,
}

impl ServerTiming {
    /// Starts the first stage.
    pub fn begin() -> Self {
        Self { last: Instant::now(), done: Vec::new() }
    }

    /// Ends a stage and starts the next; returns the duration.
    pub fn end(&mut self, name: &'static str) -> Duration {
        let now = Instant::now();
        let took = now - self.last;
        self.last = now;
        self.note(name, took);
        took
    }

    /// Adds a duration that was measured elsewhere.
    pub fn note(&mut self, name: &'static str, took: Duration) {
        self.done.push((name, took));
    }

    /// Value of the header.
    pub fn header(&self) -> HeaderValue {
        let mut text = String::new();
        for (name, took) in &self.done {
            let separator = if text.is_empty() { "" } else { ", " };
            // The header's unit is milliseconds.
            let ms = took.as_secs_f64() * 1e3;
            write!(text, "{separator}{name};dur={ms:.3}").expect("writing to a string cannot fail");
        }
        HeaderValue::from_str(&text).expect("names and numbers are ASCII")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_names_the_stages_in_order() {
        let mut timing = ServerTiming::begin();
        timing.note("read", Duration::from_micros(1500));
        timing.note("make", Duration::from_millis(2));
        assert_eq!(timing.header(), "read;dur=1.500, make;dur=2.000");
    }
}

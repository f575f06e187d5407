//! Where the time of one request goes, told in its answer as `Server-Timing` (W3C), which browsers show by themselves.

use std::fmt::Write;
use std::time::{Duration, Instant};

use http::HeaderValue;

/// The stages of a request so far, in order.
#[derive(Debug)]
pub struct Stages {
    last: Instant,
    done: Vec<(&'static str, Duration)>,
}

impl Stages {
    /// Begins with the first stage.
    pub fn begin() -> Self {
        Self { last: Instant::now(), done: Vec::new() }
    }

    /// Ends a stage and begins the next; returns how long it took.
    pub fn end(&mut self, name: &'static str) -> Duration {
        let now = Instant::now();
        let took = now - self.last;
        self.last = now;
        self.note(name, took);
        took
    }

    /// Notes a time that was measured elsewhere.
    pub fn note(&mut self, name: &'static str, took: Duration) {
        self.done.push((name, took));
    }

    /// The header.
    pub fn header(&self) -> HeaderValue {
        let mut text = String::new();
        for (name, took) in &self.done {
            let separator = if text.is_empty() { "" } else { ", " };
            // Milliseconds, as the header wants them.
            let ms = took.as_secs_f64() * 1e3;
            write!(text, "{separator}{name};dur={ms:.3}").expect("a string takes all");
        }
        HeaderValue::from_str(&text).expect("names are words, and figures are digits")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn header_names_the_stages_in_order() {
        let mut stages = Stages::begin();
        stages.note("read", Duration::from_micros(1500));
        stages.note("make", Duration::from_millis(2));
        assert_eq!(stages.header(), "read;dur=1.500, make;dur=2.000");
    }
}

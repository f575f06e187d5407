//! Where the time of a brood went: what the client saw, what the server says in `Server-Timing`, and what the job that
//! rendered it says. Refuses to know how they are fetched.

use std::collections::BTreeMap;
use std::time::Duration;

use brood_protocol::{JobAnswer, JobTimes, Work};
use reqwest::header::{HeaderMap, LINK};
use serde::Serialize;

/// Times of one brood.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Request to the whole answer.
    pub breed: Duration,
    /// Request to the last byte of the last picture.
    pub total: Duration,
    /// Stages of the request as the server tells them.
    pub server: BTreeMap<String, Duration>,
    /// The job that rendered its pictures, once it is done.
    pub job: Option<JobAnswer>,
}

/// A row of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// In JSON.
    pub key: &'static str,
    /// On screen; indented below what it is a part of.
    pub label: &'static str,
}

/// By rank.
#[derive(Debug, Serialize)]
pub struct Figures {
    pub median_ms: f64,
    pub p99_ms: f64,
    pub min_ms: f64,
    pub max_ms: f64,
}

/// How a stage's time is taken from a sample; none where its parts were not told.
type Take = fn(&Sample) -> Option<Duration>;

const STAGES: [(&str, &str, Take); 15] = [
    ("total", "request to last picture", |it| Some(it.total)),
    ("breed", "  request to 201", |it| Some(it.breed)),
    ("read", "    lineage and parents read", |it| it.told("read")),
    ("make", "    births, lowering, bytes", |it| it.told("make")),
    ("prepare", "    keys, rows, job", |it| it.told("prepare")),
    ("queue", "    wait for other writes", |it| it.told("queue")),
    ("write", "    statements", |it| it.told("write")),
    ("commit", "    commit to disk", |it| it.told("commit")),
    ("pictures", "  201 to last picture", |it| it.total.checked_sub(it.breed)),
    ("queued", "  wait for a worker", |it| Some(Duration::from_micros(it.times()?.queued_us))),
    ("handover", "  hand-over to the worker and back", Sample::handover),
    ("render", "  rendering", |it| Some(Duration::from_micros(it.work()?.busy_us))),
    ("evaluation", "    sample sets, evaluation", |it| {
        it.work_us(|work| work.sets_us + work.evaluation_us)
    }),
    ("film", "    film, PNG", |it| it.work_us(|work| work.film_us)),
    ("delivery", "  delivery of the pictures", Sample::delivery),
];

impl Sample {
    fn told(&self, name: &str) -> Option<Duration> {
        self.server.get(name).copied()
    }

    fn times(&self) -> Option<JobTimes> {
        self.job.as_ref()?.times
    }

    fn work(&self) -> Option<&Work> {
        self.job.as_ref()?.work.as_ref()
    }

    /// A time that not every worker measures: 0 is taken as not told.
    fn work_us(&self, of: impl Fn(&Work) -> u64) -> Option<Duration> {
        Some(of(self.work()?)).filter(|us| *us > 0).map(Duration::from_micros)
    }

    fn handover(&self) -> Option<Duration> {
        let leased_us = self.times()?.leased_us;
        Some(Duration::from_micros(leased_us.saturating_sub(self.work()?.busy_us)))
    }

    /// From the results at the server to the last byte at the client: what is left when everything before is taken off.
    fn delivery(&self) -> Option<Duration> {
        let JobTimes { queued_us, leased_us } = self.times()?;
        let before = self.told("read")? + self.told("make")? + self.told("prepare")?;
        let landed = before + Duration::from_micros(queued_us + leased_us);
        Some(self.total.saturating_sub(landed))
    }
}

/// The stages that were told for any sample, with its times.
pub fn stages(samples: &[Sample]) -> Vec<(Stage, Vec<Duration>)> {
    let of = |take: Take| -> Vec<_> { samples.iter().filter_map(take).collect() };
    STAGES
        .into_iter()
        .map(|(key, label, take)| (Stage { key, label }, of(take)))
        .filter(|(_, times)| !times.is_empty())
        .collect()
}

/// One slow brood, and what may have made it slow.
#[derive(Debug, Serialize)]
pub struct Slow {
    /// Its number in the run, from 0.
    pub brood: usize,
    pub total_ms: f64,
    pub breed_ms: f64,
    pub commit_ms: Option<f64>,
    pub render_ms: Option<f64>,
    pub film_ms: Option<f64>,
    /// Sample sets made for it, and samples of its rough pixels.
    pub sets_made: u64,
    pub rough_samples: u64,
}

/// The slowest broods, the slowest first.
pub fn slowest(samples: &[Sample], count: usize) -> Vec<Slow> {
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let mut numbered: Vec<(usize, &Sample)> = samples.iter().enumerate().collect();
    numbered.sort_by_key(|(_, sample)| std::cmp::Reverse(sample.total));
    let slow = |(brood, sample): (usize, &Sample)| Slow {
        brood,
        total_ms: ms(sample.total),
        breed_ms: ms(sample.breed),
        commit_ms: sample.told("commit").map(ms),
        render_ms: sample.work().map(|work| work.busy_us as f64 / 1e3),
        film_ms: sample.work_us(|work| work.film_us).map(ms),
        sets_made: sample.work().map_or(0, |work| work.sets_made),
        rough_samples: sample.work().map_or(0, |work| work.rough_samples),
    };
    numbered.into_iter().take(count).map(slow).collect()
}

/// Figures of at least one time.
pub fn figures(times: impl IntoIterator<Item = Duration>) -> Figures {
    let mut times: Vec<f64> = times.into_iter().map(|time| time.as_secs_f64() * 1e3).collect();
    times.sort_by(f64::total_cmp);
    let rank = |share: usize| times[(share * times.len()).div_ceil(100).max(1) - 1];
    Figures { median_ms: rank(50), p99_ms: rank(99), min_ms: rank(0), max_ms: rank(100) }
}

/// The stages in `Server-Timing`.
pub fn server_timing(headers: &HeaderMap) -> BTreeMap<String, Duration> {
    let values = headers.get_all("server-timing").iter().filter_map(|value| value.to_str().ok());
    let stages = values.flat_map(|text| text.split(',')).filter_map(|stage| {
        let (name, ms) = stage.trim().split_once(";dur=")?;
        let ms: f64 = ms.parse().ok()?;
        Some((name.to_owned(), Duration::try_from_secs_f64(ms / 1e3).ok()?))
    });
    stages.collect()
}

/// Where the job is that renders a brood.
pub fn job_path(headers: &HeaderMap) -> Option<&str> {
    let link = headers.get(LINK)?.to_str().ok()?;
    link.strip_prefix('<')?.strip_suffix(">; rel=\"status\"")
}

#[cfg(test)]
mod tests {
    use brood_protocol::{JobId, JobStatus};
    use reqwest::header::HeaderValue;

    use super::*;

    #[test]
    fn figures_are_taken_by_rank() {
        let found = figures((1..=100).rev().map(Duration::from_millis));
        let got = (found.median_ms, found.p99_ms, found.min_ms, found.max_ms);
        assert_eq!(got, (50.0, 99.0, 1.0, 100.0));
        let one = figures(std::iter::once(Duration::from_millis(7)));
        assert_eq!((one.median_ms, one.p99_ms), (7.0, 7.0));
    }

    #[test]
    fn stages_are_read_from_headers_and_job() {
        let mut headers = HeaderMap::new();
        let told = "read;dur=1.000, make;dur=2.500, prepare;dur=0.5, nonsense, commit;dur=x";
        headers.insert("server-timing", HeaderValue::from_static(told));
        headers.insert(LINK, HeaderValue::from_static("</v1/jobs/1>; rel=\"status\""));
        assert_eq!(job_path(&headers), Some("/v1/jobs/1"));
        let job = JobAnswer {
            id: JobId::fresh(),
            kind: "render".to_owned(),
            state: JobStatus::Succeeded,
            reason: None,
            work: Some(Work { busy_us: 6000, ..Work::default() }),
            times: Some(JobTimes { queued_us: 1000, leased_us: 8000 }),
        };
        let sample = Sample {
            breed: Duration::from_millis(5),
            total: Duration::from_millis(15),
            server: server_timing(&headers),
            job: Some(job),
        };
        let quick = Sample { total: Duration::from_millis(9), job: None, ..sample.clone() };
        let slow = slowest(&[quick, sample.clone()], 1);
        assert_eq!((slow.len(), slow[0].brood, slow[0].render_ms), (1, 1, Some(6.0)));
        let found = stages(&[sample.clone(), sample]);
        let of = |key| {
            let (_, times) = found.iter().find(|(stage, _)| stage.key == key)?;
            Some((times.len(), times[0].as_micros()))
        };
        assert_eq!(of("make"), Some((2, 2500)));
        assert_eq!(of("pictures"), Some((2, 10_000)));
        assert_eq!(of("handover"), Some((2, 2000)));
        assert_eq!(of("delivery"), Some((2, 2000)));
        assert_eq!((of("commit"), of("film")), (None, None), "what is not told is left out");
    }
}

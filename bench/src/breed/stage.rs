//! Splits the time of a brood into stages, from the client's clock, the `Server-Timing` header and
//! the render job's times. Independent of how these are fetched.

use std::collections::BTreeMap;
use std::time::Duration;

use brood_protocol::{JobAnswer, JobTimes, RenderStats};
use reqwest::header::{HeaderMap, LINK};
use serde::Serialize;

use crate::measure::quantile;

/// Times of one brood.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Request to the end of the answer.
    pub breed: Duration,
    /// Request to the last byte of the last picture.
    pub total: Duration,
    /// Stages of the request, from `Server-Timing`.
    pub server: BTreeMap<String, Duration>,
    /// Render job of the brood, if it has one.
    pub job: Option<JobAnswer>,
}

/// Key and label of a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StageName {
    /// Key in JSON.
    pub key: &'static str,
    /// Printed label, indented below the stage that contains this one.
    pub label: &'static str,
}

/// Order statistics of a stage.
#[derive(Debug, Serialize)]
pub struct StageTimes {
    pub median_ms: f64,
    pub p99_ms: f64,
    pub min_ms: f64,
    pub max_ms: f64,
}

/// Extracts a stage's time from a sample; `None` if its parts were not reported.
type Extract = fn(&Sample) -> Option<Duration>;

/// Stages in printed order: key, label and time.
const STAGES: [(&str, &str, Extract); 15] = [
    ("total", "request to last picture", |it| Some(it.total)),
    ("breed", "  request to 201", |it| Some(it.breed)),
    ("read", "    lineage and parents read", |it| it.server_stage("read")),
    ("make", "    births, lowering, bytes", |it| it.server_stage("make")),
    ("prepare", "    keys, rows, job", |it| it.server_stage("prepare")),
    ("queue", "    wait for other writes", |it| it.server_stage("queue")),
    ("write", "    statements", |it| it.server_stage("write")),
    ("commit", "    commit to disk", |it| it.server_stage("commit")),
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
    fn server_stage(&self, name: &str) -> Option<Duration> {
        self.server.get(name).copied()
    }

    fn times(&self) -> Option<JobTimes> {
        self.job.as_ref()?.times
    }

    fn work(&self) -> Option<&RenderStats> {
        self.job.as_ref()?.work.as_ref()
    }

    /// Time that not every worker measures: 0 counts as not reported.
    fn work_us(&self, of: impl Fn(&RenderStats) -> u64) -> Option<Duration> {
        Some(of(self.work()?)).filter(|us| *us > 0).map(Duration::from_micros)
    }

    /// Time of the lease minus rendering: transfers of the job and of the results.
    fn handover(&self) -> Option<Duration> {
        let leased_us = self.times()?.leased_us;
        Some(Duration::from_micros(leased_us.saturating_sub(self.work()?.busy_us)))
    }

    /// Time from the results' arrival at the server to the last byte at the client: the total minus
    /// all stages before.
    fn delivery(&self) -> Option<Duration> {
        let JobTimes { queued_us, leased_us } = self.times()?;
        let before = self.server_stage("read")?
            + self.server_stage("make")?
            + self.server_stage("prepare")?;
        let received = before + Duration::from_micros(queued_us + leased_us);
        Some(self.total.saturating_sub(received))
    }
}

/// Returns the stages reported by at least one sample, with their times.
pub fn stages(samples: &[Sample]) -> Vec<(StageName, Vec<Duration>)> {
    let of = |take: Extract| -> Vec<_> { samples.iter().filter_map(take).collect() };
    STAGES
        .into_iter()
        .map(|(key, label, take)| (StageName { key, label }, of(take)))
        .filter(|(_, times)| !times.is_empty())
        .collect()
}

/// One slow brood with the likely causes.
#[derive(Debug, Serialize)]
pub struct Slow {
    /// Number of the brood in the run, from 0.
    pub brood: usize,
    pub total_ms: f64,
    pub breed_ms: f64,
    pub commit_ms: Option<f64>,
    pub render_ms: Option<f64>,
    pub film_ms: Option<f64>,
    /// Number of sample sets built for it.
    pub sets_made: u64,
    /// Number of samples in its rough pixels.
    pub rough_samples: u64,
}

/// Returns the `count` slowest broods, slowest first.
pub fn slowest(samples: &[Sample], count: usize) -> Vec<Slow> {
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    let mut numbered: Vec<(usize, &Sample)> = samples.iter().enumerate().collect();
    numbered.sort_by_key(|(_, sample)| std::cmp::Reverse(sample.total));
    let slow = |(brood, sample): (usize, &Sample)| Slow {
        brood,
        total_ms: ms(sample.total),
        breed_ms: ms(sample.breed),
        commit_ms: sample.server_stage("commit").map(ms),
        render_ms: sample.work().map(|work| work.busy_us as f64 / 1e3),
        film_ms: sample.work_us(|work| work.film_us).map(ms),
        sets_made: sample.work().map_or(0, |work| work.sets_made),
        rough_samples: sample.work().map_or(0, |work| work.rough_samples),
    };
    numbered.into_iter().take(count).map(slow).collect()
}

/// Computes the order statistics of `times`, which must not be empty.
pub fn figures(times: impl IntoIterator<Item = Duration>) -> StageTimes {
    let ms: Vec<f64> = times.into_iter().map(|time| time.as_secs_f64() * 1e3).collect();
    let rank = |share| quantile(&ms, share);
    StageTimes { median_ms: rank(0.5), p99_ms: rank(0.99), min_ms: rank(0.0), max_ms: rank(1.0) }
}

/// Parses the stages of `Server-Timing`.
pub fn server_timing(headers: &HeaderMap) -> BTreeMap<String, Duration> {
    let values = headers.get_all("server-timing").iter().filter_map(|value| value.to_str().ok());
    let stages = values.flat_map(|text| text.split(',')).filter_map(|stage| {
        let (name, ms) = stage.trim().split_once(";dur=")?;
        let ms: f64 = ms.parse().ok()?;
        Some((name.to_owned(), Duration::try_from_secs_f64(ms / 1e3).ok()?))
    });
    stages.collect()
}

/// Path of the render job of a brood, from its `Link` header.
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
    }

    #[test]
    fn stages_are_read_from_headers_and_job() {
        let mut headers = HeaderMap::new();
        let timing = "read;dur=1.000, make;dur=2.500, prepare;dur=0.5, nonsense, commit;dur=x";
        headers.insert("server-timing", HeaderValue::from_static(timing));
        headers.insert(LINK, HeaderValue::from_static("</v1/jobs/1>; rel=\"status\""));
        assert_eq!(job_path(&headers), Some("/v1/jobs/1"));
        let job = JobAnswer {
            id: JobId::fresh(),
            kind: "render".to_owned(),
            state: JobStatus::Succeeded,
            reason: None,
            work: Some(RenderStats { busy_us: 6000, ..RenderStats::default() }),
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
        assert_eq!((of("commit"), of("film")), (None, None), "unreported stages are left out");
    }
}

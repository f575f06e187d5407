//! Metrics of `/metrics`, in a recorder per server, so that several servers in one process stay
//! separate. Units are seconds and bytes.

mod gauge;

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use brood_protocol::RenderStats;
use metrics::{
    Counter, Gauge, Histogram, Key, Label, Level, Metadata, Recorder, SharedString, Unit,
};
use metrics_exporter_prometheus::{
    Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};

pub use gauge::GaugeName;

const BUCKETS: [f64; 14] =
    [0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0, 30.0];
const METADATA: Metadata<'static> = Metadata::new("brood", Level::INFO, None);

/// Counter of [`RenderStats`]: name, description and field.
type WorkCounter = (&'static str, &'static str, fn(&RenderStats) -> u64);

const WORK: [WorkCounter; 13] = [
    (
        "brood_operations_written_total",
        "Scalar operations of genomes as written, times the rays of their pictures",
        |work| work.operations_written,
    ),
    ("brood_operations_total", "Scalar operations executed by workers", |work| {
        work.operations_executed
    }),
    ("brood_inputs_known_total", "Known inputs, summed over pictures", |work| work.inputs_known),
    ("brood_inputs_read_total", "Inputs read by programs, summed over pictures", |work| {
        work.inputs_read
    }),
    ("brood_rays_total", "Rays of pictures", |work| work.rays),
    ("brood_samples_covered_total", "Rays that hit the mesh", |work| work.samples_covered),
    ("brood_samples_total", "Lit samples, which are shaded", |work| work.samples_lit),
    ("brood_rough_pixels_total", "Pixels that were resampled", |work| work.rough_pixels),
    ("brood_rough_samples_total", "Samples shaded in resampled pixels", |work| work.rough_samples),
    ("brood_sample_sets_reused_total", "Sample sets taken from workers' caches", |work| {
        work.sets_reused
    }),
    ("brood_sample_sets_made_total", "Sample sets traced by workers", |work| work.sets_made),
    (
        "brood_translations_reused_total",
        "Program translations taken from workers' caches",
        |work| work.translations_reused,
    ),
    ("brood_translations_made_total", "Programs translated by workers", |work| {
        work.translations_made
    }),
];

/// Times of [`RenderStats`], which are counters of seconds: name, description and microseconds.
const TIMES: [WorkCounter; 4] = [
    // Not `brood_render_seconds_total`: `brood_render_seconds` is a histogram.
    ("brood_render_busy_seconds_total", "Busy time of workers' render threads", |work| {
        work.busy_us
    }),
    ("brood_sample_sets_seconds_total", "Time spent on tracing sample sets", |work| work.sets_us),
    ("brood_evaluation_seconds_total", "Time spent on evaluating programs", |work| {
        work.evaluation_us
    }),
    ("brood_film_seconds_total", "Time spent on film and encoding", |work| work.film_us),
];

/// Metrics of a server.
pub struct Metrics {
    recorder: PrometheusRecorder,
    handle: PrometheusHandle,
    /// Generations bred.
    pub breeds: Counter,
    /// Children bred.
    pub births: Counter,
    /// Draws rejected as twins.
    pub redraws: Counter,
    /// Children that are twins.
    pub twins: Counter,
    /// Pictures rendered by workers.
    pub rendered: Counter,
    /// Pictures served from memory.
    pub served: Counter,
    /// Pictures served from disk.
    pub recalled: Counter,
    /// Pictures of broods that were already cached or being rendered.
    pub skipped: Counter,
    /// Render jobs that ended because no client waited for their pictures any more.
    pub abandoned: Counter,
    /// Render jobs that were given up because their workers died or were cut off repeatedly.
    pub dead: Counter,
    /// Pictures of broods that are equal to another of the same brood.
    pub shared: Counter,
    /// Generations reported by searches.
    pub search_generations: Counter,
    /// Writes that the database refused, as the store counts them.
    pub refused_writes: Counter,
    /// RenderStats done and avoided by workers, in the order of [`WORK`].
    work: [Counter; WORK.len()],
    /// Microseconds, in the order of [`TIMES`]. A [`Counter`] has no fractions.
    times_us: [AtomicU64; TIMES.len()],
    /// Seconds to make a brood.
    pub brood_seconds: Histogram,
    /// Seconds from a lease to its results.
    pub render_seconds: Histogram,
}

impl Metrics {
    /// Registers and describes all metrics.
    pub fn new() -> Self {
        let seconds = Matcher::Suffix("_seconds".to_owned());
        let recorder = PrometheusBuilder::new()
            .set_buckets_for_metric(seconds, &BUCKETS)
            .expect("the list of buckets is not empty")
            .build_recorder();
        let counter = |name: &'static str, text: &'static str| {
            recorder.describe_counter(name.into(), None, SharedString::const_str(text));
            recorder.register_counter(&Key::from_static_name(name), &METADATA)
        };
        let histogram = |name: &'static str, text: &'static str| {
            let unit = Some(Unit::Seconds);
            recorder.describe_histogram(name.into(), unit, SharedString::const_str(text));
            recorder.register_histogram(&Key::from_static_name(name), &METADATA)
        };
        let words = SharedString::const_str("Time from a request's head to the answer's head");
        recorder.describe_histogram("brood_request_seconds".into(), Some(Unit::Seconds), words);
        for gauge in GaugeName::ALL {
            let words = SharedString::const_str(gauge.text());
            recorder.describe_gauge(gauge.name().into(), None, words);
        }
        Self {
            breeds: counter("brood_breeds_total", "Generations bred"),
            births: counter("brood_births_total", "Children bred"),
            redraws: counter("brood_redraws_total", "Draws rejected as twins"),
            twins: counter("brood_twins_total", "Children that are twins"),
            rendered: counter("brood_pictures_rendered_total", "Pictures rendered by workers"),
            served: counter("brood_pictures_from_memory_total", "Pictures served from memory"),
            recalled: counter("brood_pictures_from_disk_total", "Pictures served from disk"),
            skipped: counter(
                "brood_pictures_skipped_total",
                "Pictures of broods that were already cached or being rendered",
            ),
            abandoned: counter(
                "brood_jobs_abandoned_total",
                "Render jobs that ended because no client waited for their pictures any more",
            ),
            dead: counter(
                "brood_jobs_dead_total",
                "Render jobs that were given up because their workers died repeatedly",
            ),
            shared: counter(
                "brood_pictures_shared_total",
                "Pictures of broods that are equal to another of the same brood",
            ),
            search_generations: counter(
                "brood_search_generations_total",
                "Generations reported by searches",
            ),
            refused_writes: counter(
                "brood_refused_writes_total",
                "Writes that the database refused because it was slow or full",
            ),
            work: WORK.map(|(name, text, _)| counter(name, text)),
            times_us: TIMES.map(|_| AtomicU64::new(0)),
            brood_seconds: histogram("brood_make_seconds", "Time to make a brood"),
            render_seconds: histogram("brood_render_seconds", "Time from a lease to its results"),
            handle: recorder.handle(),
            recorder,
        }
    }

    /// Adds a job's work to the counters.
    pub fn work(&self, work: &RenderStats) {
        for (counter, (_, _, of)) in self.work.iter().zip(WORK) {
            counter.increment(of(work));
        }
        for (time_us, (_, _, of)) in self.times_us.iter().zip(TIMES) {
            time_us.fetch_add(of(work), Ordering::Relaxed);
        }
    }

    /// Records an answered request.
    pub fn request(&self, method: &str, route: &str, status: u16, elapsed: Duration) {
        let labels = vec![
            Label::new("method", method_label(method)),
            Label::new("route", route.to_owned()),
            Label::new("status", status.to_string()),
        ];
        let key = Key::from_parts("brood_request_seconds", labels);
        self.recorder.register_histogram(&key, &METADATA).record(elapsed.as_secs_f64());
    }

    /// Sets a gauge.
    pub fn gauge(&self, gauge: GaugeName, labels: &[(&'static str, &str)], value: f64) {
        let labels: Vec<_> =
            labels.iter().map(|(name, value)| Label::new(*name, (*value).to_owned())).collect();
        let key = Key::from_parts(gauge.name(), labels);
        let gauge: Gauge = self.recorder.register_gauge(&key, &METADATA);
        gauge.set(value);
    }

    /// Returns the metrics in the Prometheus text format.
    pub fn render(&self) -> String {
        let mut text = self.handle.render();
        for (time_us, (name, about, _)) in self.times_us.iter().zip(TIMES) {
            let us = time_us.load(Ordering::Relaxed);
            let (whole, rest) = (us / 1_000_000, us % 1_000_000);
            text += &format!(
                "# HELP {name} {about}\n# TYPE {name} counter\n{name} {whole}.{rest:06}\n\n"
            );
        }
        text
    }

    /// Folds recorded values into the buckets. Without this, memory grows until the next scrape.
    pub fn upkeep(&self) {
        self.handle.run_upkeep();
    }
}

/// Returns a method's label. Unknown methods share one, so that clients cannot create labels
/// without bound.
fn method_label(method: &str) -> &'static str {
    ["GET", "POST", "PATCH", "DELETE", "HEAD", "PUT", "OPTIONS"]
        .into_iter()
        .find(|known| *known == method)
        .unwrap_or("other")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_render_what_was_recorded() {
        let metrics = Metrics::new();
        metrics.births.increment(20);
        metrics.work(&RenderStats { rays: 5, film_us: 7, ..RenderStats::default() });
        metrics.work(&RenderStats { rays: 5, film_us: 61_000_000, ..RenderStats::default() });
        metrics.request("GET", "/v1/system", 200, Duration::from_millis(3));
        metrics.request("BREW", "none", 405, Duration::from_millis(3));
        metrics.gauge(GaugeName::Jobs, &[("queue", "interactive")], 4.0);
        let text = metrics.render();
        assert!(text.contains("brood_births_total 20"), "{text}");
        assert!(text.contains("route=\"/v1/system\",status=\"200\",le=\"0.005\"} 1"), "{text}");
        assert!(text.contains("method=\"other\""), "{text}");
        assert!(text.contains("brood_rays_total 10"), "{text}");
        assert!(text.contains("\nbrood_film_seconds_total 61.000007\n"), "{text}");
        assert!(text.contains("brood_jobs{queue=\"interactive\"} 4"), "{text}");
    }

    #[test]
    fn every_metric_has_a_type_a_description_and_a_base_unit() {
        let metrics = Metrics::new();
        metrics.request("GET", "/v1/system", 200, Duration::from_millis(3));
        metrics.brood_seconds.record(0.1);
        for gauge in GaugeName::ALL {
            metrics.gauge(*gauge, &[], 1.0);
        }
        let text = metrics.render();
        let types = text.lines().filter_map(|line| line.strip_prefix("# TYPE "));
        let names: Vec<_> = types.filter_map(|line| line.split(' ').next()).collect();
        assert!(names.len() > 30 && names.contains(&"brood_film_seconds_total"), "{text}");
        for name in &names {
            assert!(text.contains(&format!("# HELP {name} ")), "{name} in {text}");
            assert_eq!(names.iter().filter(|other| *other == name).count(), 1, "{name}");
            let other_units = ["micro", "milli", "_us", "_ms", "_kib", "_mib", "minutes"];
            assert!(other_units.iter().all(|unit| !name.contains(unit)), "{name}");
        }
    }
}

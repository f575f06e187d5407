//! Metrics of `/metrics`, in a recorder per server, so that several servers in one process stay
//! separate.

use std::time::Duration;

use brood_protocol::RenderStats;
use metrics::{
    Counter, Gauge, Histogram, Key, Label, Level, Metadata, Recorder, SharedString, Unit,
};
use metrics_exporter_prometheus::{
    Matcher, PrometheusBuilder, PrometheusHandle, PrometheusRecorder,
};

const BUCKETS: [f64; 14] =
    [0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0, 30.0];
const METADATA: Metadata<'static> = Metadata::new("brood", Level::INFO, None);

/// Counter of [`RenderStats`]: name, description and field.
type WorkCounter = (&'static str, &'static str, fn(&RenderStats) -> u64);

const WORK: [WorkCounter; 17] = [
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
    ("brood_render_microseconds_total", "Busy time of workers' render threads", |work| {
        work.busy_us
    }),
    ("brood_sample_sets_microseconds_total", "Time spent on tracing sample sets", |work| {
        work.sets_us
    }),
    ("brood_evaluation_microseconds_total", "Time spent on evaluating programs", |work| {
        work.evaluation_us
    }),
    ("brood_film_microseconds_total", "Time spent on film and encoding", |work| work.film_us),
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
    /// Pictures of broods that are equal to another of the same brood.
    pub shared: Counter,
    /// Generations reported by searches.
    pub search_generations: Counter,
    /// RenderStats done and avoided by workers, in the order of [`WORK`].
    work: [Counter; WORK.len()],
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
            shared: counter(
                "brood_pictures_shared_total",
                "Pictures of broods that are equal to another of the same brood",
            ),
            search_generations: counter(
                "brood_search_generations_total",
                "Generations reported by searches",
            ),
            work: WORK.map(|(name, text, _)| counter(name, text)),
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
    pub fn gauge(&self, name: &'static str, labels: &[(&'static str, &str)], value: f64) {
        let labels: Vec<_> =
            labels.iter().map(|(name, value)| Label::new(*name, (*value).to_owned())).collect();
        let gauge: Gauge = self.recorder.register_gauge(&Key::from_parts(name, labels), &METADATA);
        gauge.set(value);
    }

    /// Returns the metrics in the Prometheus text format.
    pub fn render(&self) -> String {
        self.handle.render()
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
        metrics.work(&RenderStats { rays: 5, ..RenderStats::default() });
        metrics.request("GET", "/v1/system", 200, Duration::from_millis(3));
        metrics.request("BREW", "none", 405, Duration::from_millis(3));
        metrics.gauge("brood_jobs", &[("queue", "interactive")], 4.0);
        let text = metrics.render();
        assert!(text.contains("brood_births_total 20"), "{text}");
        assert!(text.contains("route=\"/v1/system\",status=\"200\",le=\"0.005\"} 1"), "{text}");
        assert!(text.contains("method=\"other\""), "{text}");
        assert!(text.contains("brood_rays_total 10"), "{text}");
        assert!(text.contains("brood_film_microseconds_total 7"), "{text}");
        assert!(text.contains("brood_jobs{queue=\"interactive\"} 4"), "{text}");
    }
}

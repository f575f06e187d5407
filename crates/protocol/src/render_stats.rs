//! Counters of rendering work that was done and of work that was avoided.
//!
//! Every counter of work done has a counterpart for the work without the optimisation, so that the
//! share saved can be computed.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// Counters of rendering work, summed over pictures. They do not affect any pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
#[schema(as = Work)]
pub struct RenderStats {
    /// Number of pictures rendered.
    pub pictures: u64,
    /// Scalar operations of the genomes as written, times the rays of their pictures: the cost
    /// without dead code removal and without skipping unlit rays.
    pub operations_written: u64,
    /// Scalar operations executed: operations of the lowered programs, times the samples shaded.
    pub operations_executed: u64,
    /// Number of available inputs, summed over pictures.
    pub inputs_known: u64,
    /// Number of inputs that the programs read, summed over pictures.
    pub inputs_read: u64,
    /// Camera rays, summed over pictures, also where pictures share one sample set.
    pub rays: u64,
    /// Rays that hit the mesh.
    pub samples_covered: u64,
    /// Hits that are lit and face the camera. Only these are shaded.
    pub samples_lit: u64,
    /// Pixels that were supersampled because they differ from their neighbours.
    pub rough_pixels: u64,
    /// Samples shaded in supersampled pixels.
    pub rough_samples: u64,
    /// Sample sets taken from the cache.
    pub sets_reused: u64,
    /// Sample sets computed.
    pub sets_made: u64,
    /// Compiled programs taken from the cache.
    pub translations_reused: u64,
    /// Programs compiled.
    pub translations_made: u64,
    /// Time on the render thread, from programs to encoded pictures, in microseconds.
    pub busy_us: u64,
    /// Time to compute or look up sample sets, in microseconds.
    pub sets_us: u64,
    /// Time to evaluate programs, in microseconds.
    pub evaluation_us: u64,
    /// Time to develop and encode pictures, in microseconds.
    pub film_us: u64,
}

impl AddAssign for RenderStats {
    fn add_assign(&mut self, other: Self) {
        self.pictures += other.pictures;
        self.operations_written += other.operations_written;
        self.operations_executed += other.operations_executed;
        self.inputs_known += other.inputs_known;
        self.inputs_read += other.inputs_read;
        self.rays += other.rays;
        self.samples_covered += other.samples_covered;
        self.samples_lit += other.samples_lit;
        self.rough_pixels += other.rough_pixels;
        self.rough_samples += other.rough_samples;
        self.sets_reused += other.sets_reused;
        self.sets_made += other.sets_made;
        self.translations_reused += other.translations_reused;
        self.translations_made += other.translations_made;
        self.busy_us += other.busy_us;
        self.sets_us += other.sets_us;
        self.evaluation_us += other.evaluation_us;
        self.film_us += other.film_us;
    }
}

//! What a job took, and what the engine did not have to do for it: counters that add up over pictures, jobs and workers.
//!
//! Every number of work done stands beside the number it would have been, so that a share can be read off either.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

/// Counters of rendering. A renderer fills one for each call and adds them up; nothing here decides a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Work {
    /// Pictures made.
    pub pictures: u64,
    /// Scalar operations of the genomes as written, times the rays of their pictures: what running everything costs.
    pub operations_written: u64,
    /// Scalar operations executed: those of the programs, times the samples shaded.
    pub operations_executed: u64,
    /// Inputs that there are, counted for each picture.
    pub inputs_known: u64,
    /// Inputs that the programs read.
    pub inputs_read: u64,
    /// Rays shot for the pictures, counted for each picture also where a sample set is shared.
    pub rays: u64,
    /// Rays that hit the mesh.
    pub samples_covered: u64,
    /// Hits that light reaches and the camera sees the front of: only these are shaded.
    pub samples_lit: u64,
    /// Pixels that looked rough and were sampled again.
    pub rough_pixels: u64,
    /// Samples shaded in them.
    pub rough_samples: u64,
    /// Sample sets that were at hand.
    pub sets_reused: u64,
    /// Sample sets made.
    pub sets_made: u64,
    /// Programs whose translation was at hand.
    pub translations_reused: u64,
    /// Programs translated.
    pub translations_made: u64,
    /// Time of jobs on the render thread, from programs to encoded pictures, in microseconds.
    pub busy_us: u64,
    /// Time to make or find sample sets, in microseconds.
    pub sets_us: u64,
    /// Time to evaluate programs, in microseconds.
    pub evaluation_us: u64,
    /// Time for film and encoding, in microseconds.
    pub film_us: u64,
}

impl AddAssign for Work {
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

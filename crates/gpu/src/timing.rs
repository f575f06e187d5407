//! Cost of a batch, for benchmarks and for the division of later batches.

/// Cost of one batch on a device.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BatchTiming {
    /// Seconds of compute passes: by timestamps of the device if it has them, else from submission
    /// to end.
    pub device_s: f64,
    /// True if all of `device_s` is from timestamps.
    pub has_timestamps: bool,
    /// Number of submissions.
    pub submissions: u32,
    /// Seconds of the longest submission.
    pub longest_s: f64,
    /// Bytes of inputs and targets uploaded to the device, without those that are cached there.
    pub uploaded_bytes: u64,
    /// Bytes read back.
    pub read_bytes: u64,
    /// True if a pipeline of the program's own was used.
    pub own_pipeline: bool,
}

impl BatchTiming {
    /// Adds one submission.
    pub(crate) fn add(&mut self, seconds: f64, is_timestamp: bool) {
        self.has_timestamps = is_timestamp && (self.submissions == 0 || self.has_timestamps);
        self.device_s += seconds;
        self.submissions += 1;
        self.longest_s = self.longest_s.max(seconds);
    }
}

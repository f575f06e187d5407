//! What a batch cost, for benchmarks and for the pace of the next.

/// What one batch took of a device.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BatchTiming {
    /// Seconds that compute passes ran: by the device's timestamps where it has them, else from submission to end.
    pub device_s: f64,
    /// Whether `device_s` is from timestamps throughout.
    pub has_timestamps: bool,
    /// Submissions.
    pub submissions: u32,
    /// The longest of them.
    pub longest_s: f64,
    /// Bytes of inputs and targets sent to the device; those of a set that is there already are not.
    pub uploaded_bytes: u64,
    /// Bytes read back.
    pub read_bytes: u64,
    /// Whether a pipeline of the program's own ran.
    pub own_pipeline: bool,
}

impl BatchTiming {
    /// Counts one submission.
    pub(crate) fn add(&mut self, seconds: f64, is_timestamp: bool) {
        self.has_timestamps = is_timestamp && (self.submissions == 0 || self.has_timestamps);
        self.device_s += seconds;
        self.submissions += 1;
        self.longest_s = self.longest_s.max(seconds);
    }
}

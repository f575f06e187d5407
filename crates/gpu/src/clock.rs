//! Timestamps of the device: the time that a submission ran, without the time it waited.

use crate::GpuError;
use crate::device::Device;

/// Two timestamps around a compute pass.
#[derive(Debug)]
pub(crate) struct Clock {
    /// Timestamps at the beginning and the end of the pass.
    queries: wgpu::QuerySet,
    /// Both timestamps in ticks, on the device.
    resolved: wgpu::Buffer,
    /// Copy of them that the CPU can map.
    staging: wgpu::Buffer,
    /// Length of a tick in nanoseconds.
    tick_ns: f64,
}

const BYTES: u64 = 2 * wgpu::QUERY_SIZE as u64;

impl Clock {
    /// Creates the queries; `None` if the adapter has no timestamps.
    pub(crate) fn new(device: &Device) -> Result<Option<Self>, GpuError> {
        use wgpu::BufferUsages as Usage;
        let tick_ns = f64::from(device.queue.get_timestamp_period());
        if !device.api.features().contains(wgpu::Features::TIMESTAMP_QUERY) || tick_ns <= 0.0 {
            return Ok(None);
        }
        device.scoped(|| {
            let descriptor = wgpu::QuerySetDescriptor {
                label: Some("clock"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            };
            Some(Self {
                queries: device.api.create_query_set(&descriptor),
                resolved: device.buffer("clock", BYTES, Usage::QUERY_RESOLVE | Usage::COPY_SRC),
                staging: device.buffer("clock reading", BYTES, Usage::MAP_READ | Usage::COPY_DST),
                tick_ns,
            })
        })
    }

    /// Returns the timestamp writes of a pass.
    pub(crate) fn writes(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Resolves the timestamps; encoded after the pass.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.staging, 0, BYTES);
    }

    /// Returns the seconds that the pass of a finished submission took on the device. `None` if the
    /// two readings are implausible, as when a counter restarts or stands still.
    pub(crate) fn read(
        &self,
        device: &Device,
        submission: wgpu::SubmissionIndex,
        wall_s: f64,
    ) -> Result<Option<f64>, GpuError> {
        let mut ticks = [0u64; 2];
        device.read(&self.staging, BYTES, submission, |bytes| {
            bytemuck::bytes_of_mut(&mut ticks).copy_from_slice(bytes);
        })?;
        Ok(seconds(ticks, self.tick_ns, wall_s))
    }
}

fn seconds([begin, end]: [u64; 2], tick_ns: f64, wall_s: f64) -> Option<f64> {
    let ticks = end.checked_sub(begin).filter(|ticks| *ticks > 0)?;
    let seconds = ticks as f64 * tick_ns * 1e-9;
    // Work cannot have run longer than the CPU waited for it.
    (seconds <= wall_s).then_some(seconds)
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn readings_count_only_when_they_are_plausible() {
        let measured = seconds([1000, 3000], 0.5, 1.0).unwrap();
        assert!((measured - 1e-6).abs() < 1e-12, "{measured}");
        assert_eq!(seconds([3000, 1000], 0.5, 1.0), None, "the counter restarted");
        assert_eq!(seconds([7, 7], 0.5, 1.0), None, "the counter stands still");
        assert_eq!(seconds([0, u64::MAX], 1.0, 1.0), None, "longer than the wait");
    }
}

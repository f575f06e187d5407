//! Cache of inputs of sample sets on the device, with a bound in bytes.

use std::ops::Range;

use brood_brdf::{Input, InputMask};

use crate::GpuError;
use crate::device::Device;
use crate::plan::padded;

/// The inputs of a batch.
pub(crate) struct Rows<'a> {
    /// Identity of the set; without one nothing is cached.
    pub set: Option<u64>,
    /// Inputs that programs read.
    pub mask: InputMask,
    /// Number of samples.
    pub len: usize,
    /// Returns the values of an input on all samples.
    pub row: &'a dyn Fn(Input) -> &'a [f32],
}

/// Rows of one set, or of a slab of it, on the device.
#[derive(Debug)]
struct Resident {
    set: u64,
    /// Index of the first sample of the slab.
    first_sample: usize,
    mask: InputMask,
    buffer: wgpu::Buffer,
    /// Value of the clock at the last use.
    last_use: u64,
}

/// Sets whose inputs are on the device, evicted least recently used first.
#[derive(Debug)]
pub(crate) struct Residency {
    /// Largest number of bytes on the device.
    most_bytes: u64,
    residents: Vec<Resident>,
    /// Number of look-ups so far.
    clock: u64,
}

impl Residency {
    pub(crate) fn new(most_bytes: u64) -> Self {
        Self { most_bytes, residents: Vec::new(), clock: 0 }
    }

    /// Returns the inputs whose rows the device will have for a batch: those of `rows` and those
    /// already there, so that batches that read different inputs of one set do not evict each
    /// other.
    pub(crate) fn mask(&self, rows: &Rows<'_>) -> InputMask {
        let same_set = self.residents.iter().filter(|resident| Some(resident.set) == rows.set);
        same_set.fold(rows.mask, |mask, resident| mask.union(resident.mask))
    }

    /// Returns a buffer of the rows of `mask` over some samples, one after another, each padded to
    /// whole blocks; and the number of bytes uploaded.
    pub(crate) fn inputs(
        &mut self,
        device: &Device,
        rows: &Rows<'_>,
        mask: InputMask,
        samples: &Range<usize>,
    ) -> Result<(wgpu::Buffer, u64), GpuError> {
        self.clock += 1;
        let found = self.residents.iter().position(|resident| {
            Some(resident.set) == rows.set && resident.first_sample == samples.start
        });
        if let Some(found) = found {
            let resident = &mut self.residents[found];
            if resident.mask == mask {
                resident.last_use = self.clock;
                return Ok((resident.buffer.clone(), 0));
            }
            self.residents.swap_remove(found);
        }
        let row_bytes = padded(samples.len()) * 4;
        // A binding must not be empty, even if no program of the batch reads an input.
        let bytes = row_bytes * mask.len().max(1) as u64;
        if rows.set.is_some() {
            self.make_room(bytes);
        }
        let buffer = device.scoped(|| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let buffer = device.buffer("inputs", bytes, usage);
            for (input, offset) in mask.iter().zip((0..).step_by(row_bytes as usize)) {
                let values = &(rows.row)(input)[samples.clone()];
                device.queue.write_buffer(&buffer, offset, bytemuck::cast_slice(values));
            }
            buffer
        })?;
        if let Some(set) = rows.set.filter(|_| bytes <= self.most_bytes) {
            self.residents.push(Resident {
                set,
                first_sample: samples.start,
                mask,
                buffer: buffer.clone(),
                last_use: self.clock,
            });
        }
        Ok((buffer, mask.len() as u64 * row_bytes))
    }

    /// Evicts the least recently used rows until `bytes` more fit.
    fn make_room(&mut self, bytes: u64) {
        while self.bytes() + bytes > self.most_bytes {
            let oldest = (0..self.residents.len()).min_by_key(|at| self.residents[*at].last_use);
            let Some(oldest) = oldest else { return };
            self.residents.swap_remove(oldest);
        }
    }

    /// Returns the number of bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.residents.iter().map(|resident| resident.buffer.size()).sum()
    }
}

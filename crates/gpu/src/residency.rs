//! Inputs of sample sets on the device, kept from batch to batch within a bound.

use std::ops::Range;

use brood_brdf::{Input, InputMask};

use crate::GpuError;
use crate::device::Device;
use crate::plan::padded;

/// The inputs of a batch.
pub(crate) struct Rows<'a> {
    /// The identity of the set; without one nothing is kept.
    pub set: Option<u64>,
    /// The inputs that programs read.
    pub mask: InputMask,
    /// Samples.
    pub len: usize,
    /// The values of an input.
    pub row: &'a dyn Fn(Input) -> &'a [f32],
}

/// Rows of one set, or of a slab of it, on the device.
#[derive(Debug)]
struct Resident {
    set: u64,
    first_sample: usize,
    mask: InputMask,
    buffer: wgpu::Buffer,
    last_use: u64,
}

/// The sets whose inputs are on the device; the least recently used ones make room.
#[derive(Debug)]
pub(crate) struct Residency {
    most_bytes: u64,
    residents: Vec<Resident>,
    clock: u64,
}

impl Residency {
    pub(crate) fn new(most_bytes: u64) -> Self {
        Self { most_bytes, residents: Vec::new(), clock: 0 }
    }

    /// The inputs that rows on the device stand for when a batch needs those of `rows`: with what is there already, so
    /// that batches that read different inputs of one set do not push each other out.
    pub(crate) fn mask(&self, rows: &Rows<'_>) -> InputMask {
        let there = self.residents.iter().filter(|resident| Some(resident.set) == rows.set);
        there.fold(rows.mask, |mask, resident| mask.union(resident.mask))
    }

    /// A buffer of the rows of `mask` over some samples, one after another, each padded to whole blocks; and how many
    /// bytes were sent for it.
    pub(crate) fn inputs(
        &mut self,
        device: &Device,
        rows: &Rows<'_>,
        mask: InputMask,
        samples: &Range<usize>,
    ) -> Result<(wgpu::Buffer, u64), GpuError> {
        self.clock += 1;
        let place = self.residents.iter().position(|resident| {
            Some(resident.set) == rows.set && resident.first_sample == samples.start
        });
        if let Some(place) = place {
            let resident = &mut self.residents[place];
            if resident.mask == mask {
                resident.last_use = self.clock;
                return Ok((resident.buffer.clone(), 0));
            }
            self.residents.swap_remove(place);
        }
        let row_bytes = padded(samples.len()) * 4;
        // A binding must not be empty, even where no program of the batch reads an input.
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

    /// Drops what was used longest ago until `bytes` more fit.
    fn make_room(&mut self, bytes: u64) {
        while self.bytes() + bytes > self.most_bytes {
            let oldest = (0..self.residents.len()).min_by_key(|at| self.residents[*at].last_use);
            let Some(oldest) = oldest else { return };
            self.residents.swap_remove(oldest);
        }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.residents.iter().map(|resident| resident.buffer.size()).sum()
    }
}

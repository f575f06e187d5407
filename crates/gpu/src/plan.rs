//! Division of a batch of programs over a set of samples. Pure arithmetic, independent of a device.
//!
//! - A slab is a range of samples whose rows of inputs fit a buffer.
//! - A group is a range of programs whose outputs over a slab, and whose words, fit a buffer.
//! - A pass evaluates a group over a slab; its outputs are read back together.
//! - A tile is the part of a pass that one dispatch evaluates in a bounded time.
//! - A block is the samples that one invocation evaluates together, 1 or 4.
//! - A sum adds the errors of 256 samples, a block of the CPU evaluator.

use std::ops::Range;

use crate::encode::Encoded;
use crate::shader::{Kernel, SUM_SAMPLES, Style};

/// Largest number of workgroups along one axis of a dispatch that every device supports.
const MAX_GROUPS: u64 = 65_535;
/// Smallest number of samples of a workgroup in any layout.
const LEAST_SAMPLES: u64 = 64;
/// Rows are padded to a multiple of this, the largest block of any layout.
const BLOCK: u64 = 4;
/// Number of bytes of a number.
const BYTES: u64 = 4;
const CHANNELS: u64 = 3;

/// Limits of the buffers of one pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// Largest number of bytes of one buffer.
    pub buffer_bytes: u64,
}

impl Bounds {
    /// Returns the number of samples of a slab: the largest whole number of sums, at least one, for
    /// which `rows` rows fit a buffer, and the reflectances of one program another.
    pub(crate) fn slab(&self, rows: usize) -> usize {
        let sum = u64::from(SUM_SAMPLES);
        let rows = CHANNELS.max(rows as u64);
        let most = MAX_GROUPS * LEAST_SAMPLES / sum;
        let sums = (self.buffer_bytes / (BYTES * rows * sum)).clamp(1, most);
        usize::try_from(sums * sum).expect("a buffer's bytes fit an address")
    }

    /// Divides programs into groups whose outputs, `output_bytes` each, and whose words fit a
    /// buffer. Every group has at least one program.
    pub(crate) fn groups(&self, programs: &[Encoded], output_bytes: u64) -> Vec<Range<usize>> {
        let outputs = self.buffer_bytes / output_bytes.max(1);
        let most = outputs.clamp(1, MAX_GROUPS);
        let mut groups = Vec::new();
        let mut start = 0;
        let mut bytes = 0;
        for (index, program) in programs.iter().enumerate() {
            let more = program.words() * BYTES;
            let full = (index - start) as u64 == most || bytes + more > self.buffer_bytes;
            if full && index > start {
                groups.push(start..index);
                (start, bytes) = (index, 0);
            }
            bytes += more;
        }
        groups.push(start..programs.len());
        groups
    }
}

/// Returns the number of samples in a row, padded to whole blocks.
pub(crate) fn padded(samples: usize) -> u64 {
    (samples as u64).next_multiple_of(BLOCK)
}

/// Returns the number of bytes of the reflectances of one program.
pub(crate) fn reflectance_bytes(samples: usize) -> u64 {
    BYTES * CHANNELS * padded(samples)
}

/// The samples of a slab as a shader counts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Grid {
    /// Number of blocks in a row.
    pub blocks: u32,
    /// Number of samples in a block.
    pub lanes: u32,
    /// Number of blocks per workgroup.
    pub group: u32,
}

/// Returns the samples of a slab as a kernel counts them.
pub(crate) fn grid(samples: usize, style: Style, kernel: Kernel) -> Grid {
    let lanes = style.shape.lanes();
    let blocks = padded(samples) / u64::from(lanes);
    Grid {
        blocks: u32::try_from(blocks).expect("samples of a slab fit a buffer"),
        lanes,
        group: kernel.workgroup(lanes),
    }
}

/// Returns a number of samples or sums as a shader counts them.
pub(crate) fn count(samples: usize) -> u32 {
    u32::try_from(samples).expect("samples of a slab fit a buffer")
}

/// One dispatch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Tile {
    /// Programs of the group.
    pub programs: Range<u32>,
    /// Blocks of the slab.
    pub blocks: Range<u32>,
    /// Samples times iterations of the interpreter loop, as estimated.
    pub work: u64,
}

/// Returns the next tile of at most `budget` sample iterations (at least one program on one
/// workgroup of blocks), starting at program and block `from`. A tile consists of whole programs if
/// those fit, otherwise of a part of one program.
pub(crate) fn next_tile(
    programs: &[Encoded],
    grid: Grid,
    from: (u32, u32),
    budget: u64,
) -> Option<Tile> {
    let (first, block) = from;
    let rounds = |program: &Encoded| program.rounds() * u64::from(grid.lanes);
    let here = rounds(programs.get(first as usize)?);
    let left = u64::from(grid.blocks - block);
    if block > 0 || here * left > budget {
        let group = u64::from(grid.group);
        let fits = (budget / here / group * group).max(group).min(left);
        let end = block + u32::try_from(fits).expect("no more than the blocks left");
        return Some(Tile { programs: first..first + 1, blocks: block..end, work: here * fits });
    }
    let mut work = 0;
    let mut end = first;
    for program in &programs[first as usize..] {
        let more = rounds(program) * left;
        if work + more > budget {
            break;
        }
        work += more;
        end += 1;
    }
    Some(Tile { programs: first..end, blocks: 0..grid.blocks, work })
}

/// Returns program and block at which the tile after this one starts.
pub(crate) fn after(tile: &Tile, blocks: u32) -> (u32, u32) {
    if tile.blocks.end < blocks {
        (tile.programs.start, tile.blocks.end)
    } else {
        (tile.programs.end, 0)
    }
}

/// Measures how much work a device does in the time of one tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TileBudget {
    /// Target time of a tile, in seconds.
    target_s: f64,
    /// Sample iterations of the next tile.
    work: u64,
}

impl TileBudget {
    /// First guess, low enough for a software adapter.
    const FIRST: u64 = 4_000_000;
    /// Smallest budget.
    const LEAST: u64 = 100_000;

    pub(crate) fn new(target_s: f64) -> Self {
        Self { target_s, work: Self::FIRST }
    }

    /// Returns the work of the next tile.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// Records the duration of a tile. The budget grows at most by a factor of 4, because small
    /// tiles measure the overhead.
    pub(crate) fn note(&mut self, work: u64, seconds: f64) {
        let factor = (self.target_s / seconds.max(1e-6)).clamp(1.0 / 16.0, 4.0);
        let fitting = (work as f64 * factor) as u64;
        // A tile below the budget reduces the budget only if it was slow.
        self.work = if factor < 1.0 { fitting } else { fitting.max(self.work) };
        self.work = self.work.max(Self::LEAST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brood_brdf::InputMask;
    use brood_genome::{BirthKey, Dialect, Variation};
    use brood_program::Program;

    fn programs(count: u32) -> Vec<Encoded> {
        let random = Variation::random(Dialect::default());
        let genome = |slot| random.birth(BirthKey { seed: 3, slot, attempt: 0 });
        let programs: Vec<_> = (0..count).map(|slot| Program::lower(&genome(slot))).collect();
        let inputs = programs.iter().fold(InputMask::EMPTY, |mask, p| mask.union(p.inputs()));
        programs.iter().map(|p| Encoded::new(p, inputs).unwrap()).collect()
    }

    #[test]
    fn tiles_cover_every_program_and_block_once_for_every_budget() {
        let programs = programs(7);
        for (blocks, budget) in [(1, 1), (1000, 1), (1000, 40_000), (1000, 200_000), (64, u64::MAX)]
        {
            let grid = Grid { blocks, lanes: 4, group: 64 };
            let mut seen = vec![0; programs.len() * blocks as usize];
            let mut from = (0, 0);
            while let Some(tile) = next_tile(&programs, grid, from, budget) {
                for program in tile.programs.clone() {
                    for block in tile.blocks.clone() {
                        seen[(program * blocks + block) as usize] += 1;
                    }
                }
                let least = tile.programs.len() == 1 && tile.blocks.len() <= 64;
                assert_eq!(tile.blocks.start % 64, 0);
                assert!(tile.work <= budget || least, "{tile:?} {budget}");
                from = after(&tile, blocks);
            }
            assert!(seen.iter().all(|times| *times == 1), "{blocks} {budget}");
        }
    }

    #[test]
    fn groups_and_slabs_fit_the_buffers() {
        let programs = programs(50);
        let bounds = Bounds { buffer_bytes: 100_000 };
        let slab = bounds.slab(8);
        assert!(slab * 8 * 4 <= 100_000 && slab > 2000, "{slab}");
        let groups = bounds.groups(&programs, reflectance_bytes(slab));
        assert_eq!(groups.iter().map(ExactSizeIterator::len).sum::<usize>(), 50);
        assert!(groups.iter().all(|group| !group.is_empty()));
        assert!(groups.iter().all(|group| group.len() * slab * 12 <= 100_000));
        assert_eq!(bounds.slab(0) % SUM_SAMPLES as usize, 0);
    }

    #[test]
    fn tile_budget_adapts_to_the_device() {
        let mut tile_budget = TileBudget::new(0.05);
        let first = tile_budget.work();
        tile_budget.note(first, 0.001);
        assert_eq!(tile_budget.work(), 4 * first);
        tile_budget.note(10, 0.000_01);
        assert_eq!(tile_budget.work(), 4 * first, "a small tile does not shrink the budget");
        tile_budget.note(4 * first, 0.5);
        assert!(tile_budget.work() < first);
    }
}

//! Places in the unit square at which lights are sampled: spread evenly, and differently for each pixel.
//!
//! Integers alone until the last step, so that every machine and any number of threads have the same places.

/// The seed of a ray: the pixel in the whole picture, and which of its rays. All rays of a pixel that is integrated have
/// that of its centre, so that their samples can be put into groups.
pub(super) fn ray_seed(x: u32, y: u32, ray: usize) -> u64 {
    mix(mix((u64::from(y) << 32) | u64::from(x)) ^ ray as u64)
}

/// The samples of one light at one place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places {
    seeds: [u32; 2],
}

impl Places {
    /// Those of the light of that number.
    pub fn new(seed: u64, light: usize) -> Self {
        let bits = mix(seed ^ mix(light as u64 + 1));
        // Each half of it.
        Self { seeds: [(bits >> 32) as u32, bits as u32] }
    }

    /// The place of a sample, both coordinates within (0, 1): the first two dimensions of Sobol's sequence, each
    /// scrambled. Of any 2^k samples that begin at a multiple of 2^k there is one in every column and in every row of
    /// width 2^-k.
    ///
    /// # Source
    /// Owen 1995; as hashes of the bits: Laine and Karras 2011, Burley 2020, *Practical Hash-based Owen Scrambling*.
    pub fn at(&self, sample: u32) -> [f64; 2] {
        let mut second = 0;
        let (mut left, mut direction) = (sample, 1u32 << 31);
        while left != 0 {
            if left & 1 == 1 {
                second ^= direction;
            }
            direction ^= direction >> 1;
            left >>= 1;
        }
        // In the first dimension the reversed bits of the number are the place.
        let first = scramble(sample, self.seeds[0]);
        let second = scramble(second.reverse_bits(), self.seeds[1]);
        [first, second].map(|place| (f64::from(place) + 0.5) / 4_294_967_296.0)
    }
}

/// The place whose reversed bits are given, scrambled: each bit is turned over by what the bits above it are.
fn scramble(reversed: u32, seed: u32) -> u32 {
    let mut bits = reversed.wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        bits ^= bits.wrapping_mul(factor);
    }
    bits.reverse_bits()
}

/// Steele, Lea and Flood 2014, the finaliser of SplitMix64.
fn mix(seed: u64) -> u64 {
    let mut bits = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_row_and_cell_has_its_share_of_the_places() {
        for seed in 0..20 {
            let places = Places::new(ray_seed(seed, 7, 0), 0);
            for (first, count) in [(0u32, 16u32), (16, 16), (0, 64), (64, 64)] {
                let at = |sample| places.at(sample);
                let all: Vec<[f64; 2]> = (first..first + count).map(at).collect();
                // Cells of any shape of that area: 2^a columns and 2^b rows.
                for bits in 0..=count.ilog2() {
                    let columns = f64::from(1u32 << bits);
                    let rows = f64::from(count) / columns;
                    let mut cells: Vec<u32> = all
                        .iter()
                        .map(|[x, y]| (x * columns) as u32 + (y * rows) as u32 * count)
                        .collect();
                    cells.sort_unstable();
                    cells.dedup();
                    assert_eq!(cells.len(), count as usize, "{seed} {first} {columns}");
                }
            }
        }
    }

    #[test]
    fn places_differ_by_pixel_ray_and_light() {
        let at = |x, y, ray, light| Places::new(ray_seed(x, y, ray), light).at(0);
        let all = [at(0, 0, 0, 0), at(1, 0, 0, 0), at(0, 1, 0, 0), at(0, 0, 1, 0), at(0, 0, 0, 1)];
        for (index, one) in all.iter().enumerate() {
            assert!(one.iter().all(|place| *place > 0.0 && *place < 1.0));
            assert!(all[..index].iter().all(|other| other != one), "{all:?}");
        }
    }
}

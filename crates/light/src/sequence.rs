//! Scrambled Sobol points in the unit square, by which light samples are drawn.
//!
//! Integer arithmetic up to the last step: points are equal on every machine and for any number of
//! threads.

/// Returns the seed of a ray: a hash of the pixel in the whole picture and the ray's index. All
/// rays of an edge or curved pixel use the seed of index 0, so that samples of equal index have
/// similar directions and can be grouped.
#[must_use]
pub fn ray_seed(x: u32, y: u32, ray: usize) -> u64 {
    mix(mix((u64::from(y) << 32) | u64::from(x)) ^ ray as u64)
}

/// Points for the samples of one light at one hit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SamplePoints {
    seeds: [u32; 2],
}

impl SamplePoints {
    /// Points for the light of that index in the scene.
    #[inline]
    pub fn new(seed: u64, light: usize) -> Self {
        let bits = mix(seed ^ mix(light as u64 + 1));
        // One half of the hash per dimension.
        Self { seeds: [(bits >> 32) as u32, bits as u32] }
    }

    /// Returns the point of a sample, both coordinates within (0, 1): the first two dimensions of
    /// the Sobol sequence with Owen scrambling. 2^k samples from a multiple of 2^k on have one
    /// point in every elementary interval of area 2^-k.
    ///
    /// # Source
    /// Owen 1995; by hashing of bits: Laine and Karras 2011, Burley 2020, *Practical Hash-based
    /// Owen Scrambling*.
    #[inline]
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
        // The first dimension is the bit-reversed index, and `scramble` takes reversed bits.
        let first = scramble(sample, self.seeds[0]);
        let second = scramble(second.reverse_bits(), self.seeds[1]);
        [first, second].map(|bits| (f64::from(bits) + 0.5) / 4_294_967_296.0)
    }
}

/// Owen-scrambles the number whose reversed bits are given: each bit is flipped depending on the
/// bits above it.
fn scramble(reversed: u32, seed: u32) -> u32 {
    let mut bits = reversed.wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        bits ^= bits.wrapping_mul(factor);
    }
    bits.reverse_bits()
}

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014).
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
    fn elementary_intervals_have_one_point_each() {
        for seed in 0..20 {
            let points = SamplePoints::new(ray_seed(seed, 7, 0), 0);
            for (first, count) in [(0u32, 16u32), (16, 16), (0, 64), (64, 64)] {
                let at = |sample| points.at(sample);
                let all: Vec<[f64; 2]> = (first..first + count).map(at).collect();
                // Elementary intervals of every shape: 2^a columns and 2^b rows.
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
    fn points_differ_by_pixel_ray_and_light() {
        let at = |x, y, ray, light| SamplePoints::new(ray_seed(x, y, ray), light).at(0);
        let all = [at(0, 0, 0, 0), at(1, 0, 0, 0), at(0, 1, 0, 0), at(0, 0, 1, 0), at(0, 0, 0, 1)];
        for (index, one) in all.iter().enumerate() {
            assert!(one.iter().all(|t| *t > 0.0 && *t < 1.0));
            assert!(all[..index].iter().all(|other| other != one), "{all:?}");
        }
    }
}

//! Counter-based random numbers: every draw is a pure function of (seed, slot, attempt, operator,
//! position).
//!
//! There is no shared state, so a child depends only on its own key; not on the number of threads,
//! the order or earlier births.

/// Key of a birth: seed of the brood, slot, and number of earlier draws for the slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BirthKey {
    /// Seed of the brood.
    pub seed: u64,
    /// Index in the brood, from 0.
    pub slot: u32,
    /// 0 for the first draw; incremented for each redraw.
    pub attempt: u32,
}

/// Use of random numbers; each has its own stream. Changing a number changes all broods of existing
/// seeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Operator {
    /// Instructions of random genomes.
    RandomInstructions = 1,
    /// Constants of random genomes.
    RandomConstants = 2,
    /// Mutation of instructions.
    MutateInstructions = 3,
    /// Mutation of constants.
    MutateConstants = 4,
    /// Choice of blocks in crossover.
    Recombine = 5,
    /// The order of the samples of a target.
    Shuffle = 6,
    /// Models of random genomes.
    RandomLayers = 7,
    /// Mutation of models.
    MutateLayers = 8,
    /// Crossover of models.
    RecombineLayers = 9,
    /// Pairs of directions for sampling a material.
    Directions = 10,
    /// Starts of a fit of lobes.
    Lobes = 11,
    /// Selection and variation in a genetic search.
    Genetic = 12,
    /// Believable programs.
    Believable = 13,
    /// Mutation of believable programs.
    MutateBelievable = 14,
    /// Crossover of believable programs.
    RecombineBelievable = 15,
    /// Modules of believable programs.
    BelievableStructure = 16,
    /// Mutation of the modules.
    MutateStructure = 17,
    /// Crossover of the modules.
    RecombineStructure = 18,
    /// Steps in the directions of a steer.
    Toward = 19,
    /// Starts of a fit of models.
    Analytic = 20,
    /// Effects of random genomes.
    RandomEffects = 21,
    /// Mutation of effects.
    MutateEffects = 22,
    /// Crossover of effects.
    RecombineEffects = 23,
    /// Colours of a painting for effects.
    Painting = 24,
    /// Random bumps.
    RandomBump = 25,
    /// Mutation of bumps.
    MutateBump = 26,
    /// Choice between the bumps of two parents.
    RecombineBump = 27,
}

/// Computes one block of Philox4x32-10.
///
/// # Source
/// Salmon, Moraes, Dror and Shaw, *Parallel Random Numbers: As Easy as 1, 2, 3* (2011); checked
/// against the published answers in `philox_gives_the_published_answers`.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "the low half of a product is what is meant")]
pub fn philox4x32(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let a = u64::from(counter[0]) * 0xD251_1F53;
        let b = u64::from(counter[2]) * 0xCD9E_8D57;
        counter = [
            (b >> 32) as u32 ^ counter[1] ^ key[0],
            b as u32,
            (a >> 32) as u32 ^ counter[3] ^ key[1],
            a as u32,
        ];
        key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
    }
    counter
}

/// Stream of random numbers of one operator for one birth.
#[derive(Debug, Clone)]
pub struct Stream {
    key: [u32; 2],
    counter: [u32; 4],
    block: [u32; 4],
    used: usize,
}

impl Stream {
    /// Creates the stream of a key.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "the seed is taken in two halves")]
    pub fn new(key: BirthKey, operator: Operator) -> Self {
        Self {
            key: [key.seed as u32, (key.seed >> 32) as u32],
            counter: [0, operator as u32, key.slot, key.attempt],
            block: [0; 4],
            used: 4,
        }
    }

    /// Returns 32 uniform bits.
    pub fn bits(&mut self) -> u32 {
        if self.used == 4 {
            self.block = philox4x32(self.counter, self.key);
            self.counter[0] = self.counter[0].wrapping_add(1);
            self.used = 0;
        }
        self.used += 1;
        self.block[self.used - 1]
    }

    /// Returns a uniform integer below `bound` (at most 2^16), as the high half of a product: the
    /// bias is below 2^-16.
    ///
    /// # Panics
    /// If `bound` is 0.
    pub fn below(&mut self, bound: u32) -> u32 {
        assert!(bound > 0, "`bound` must be above 0");
        u32::try_from((u64::from(self.bits()) * u64::from(bound)) >> 32).expect("below 2^32")
    }

    /// As [`Stream::below`], for `u8`.
    pub fn below_u8(&mut self, bound: u8) -> u8 {
        u8::try_from(self.below(u32::from(bound))).expect("below a u8")
    }

    /// Returns a multiple of 2^-24 in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }

    /// Returns true with this probability (to 2^-24).
    pub fn chance(&mut self, probability: f32) -> bool {
        self.unit() < probability
    }

    /// Returns a bell-shaped number with mean 0 and variance 1 in (-6, 6): the sum of twelve
    /// uniform numbers minus 6, exact in f32.
    pub fn bell(&mut self) -> f32 {
        let sum: f32 = (0..12).map(|_| self.bits() >> 20).map(|v| v as f32).sum();
        sum / 4096.0 - 6.0 + 12.0 / 8192.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_answers() {
        assert_eq!(
            philox4x32([0; 4], [0; 2]),
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]
        );
        assert_eq!(
            philox4x32([u32::MAX; 4], [u32::MAX; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            philox4x32(
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0]
            ),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn streams_differ_in_every_part_of_the_key() {
        let key = BirthKey { seed: 5, slot: 1, attempt: 0 };
        let first = |key, operator| Stream::new(key, operator).bits();
        let here = first(key, Operator::Recombine);
        assert_ne!(here, first(key, Operator::MutateConstants));
        assert_ne!(here, first(BirthKey { seed: 5 << 32, ..key }, Operator::Recombine));
        assert_ne!(here, first(BirthKey { slot: 2, ..key }, Operator::Recombine));
        assert_ne!(here, first(BirthKey { attempt: 1, ..key }, Operator::Recombine));
        assert_eq!(here, first(key, Operator::Recombine));
    }

    #[test]
    fn draws_have_their_moments() {
        let key = BirthKey { seed: 9, slot: 0, attempt: 0 };
        let mut stream = Stream::new(key, Operator::Recombine);
        let draws: Vec<f64> = (0..20_000).map(|_| f64::from(stream.bell())).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let variance = draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
        let share = (0..20_000).filter(|_| stream.chance(0.25)).count();
        assert!((4_700..5_300).contains(&share), "{share}");
        assert!((0..1000).all(|_| stream.below(13) < 13));
    }
}

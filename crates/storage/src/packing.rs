//! Packing of genomes: Zstandard with the genomes of up to two parents as dictionary, since most of
//! a child's bytes are those of its parents.
//!
//! [docs/decisions/0071](../../../docs/decisions/0071-packed-genomes.md) compares the alternatives.

use std::io;

use zstd::bulk::{Compressor, Decompressor};
use zstd::zstd_safe;

/// Largest number of genomes that one is packed against.
pub(crate) const BASES_MAX: usize = 2;
/// Level of Zstandard. Higher ones are slower and gain nothing on genomes of 3 KB.
const LEVEL: i32 = 3;
/// Largest genome that is unpacked, fifty times the largest that is valid: damaged bytes do not
/// allocate more.
const UNPACKED_MAX_BYTES: usize = 1 << 20;

/// Packer of genomes with the same bases.
pub(crate) struct Packer(Compressor<'static>);

impl Packer {
    /// Creates a packer of genomes that have parts in common with `bases`, the nearest first.
    pub(crate) fn new(bases: &[&[u8]]) -> io::Result<Self> {
        let mut compressor = Compressor::with_dictionary(LEVEL, &dictionary(bases))?;
        // Genomes have a hash.
        compressor.include_checksum(false)?;
        Ok(Self(compressor))
    }

    /// Packs a genome.
    pub(crate) fn pack(&mut self, bytes: &[u8]) -> io::Result<Vec<u8>> {
        self.0.compress(bytes)
    }
}

/// Returns the genome of packed bytes. `bases` are those that it was packed against, in that order.
pub(crate) fn unpack(packed: &[u8], bases: &[&[u8]]) -> io::Result<Vec<u8>> {
    let size = zstd_safe::get_frame_content_size(packed).ok().flatten();
    let size = size.and_then(|size| usize::try_from(size).ok());
    let size = size.filter(|size| *size <= UNPACKED_MAX_BYTES);
    let size = size.ok_or_else(|| io::Error::from(io::ErrorKind::InvalidData))?;
    Decompressor::with_dictionary(&dictionary(bases))?.decompress(packed, size)
}

/// Returns the content that genomes refer to. Zstandard refers to the end with the fewest bits.
fn dictionary(bases: &[&[u8]]) -> Vec<u8> {
    bases.iter().rev().flat_map(|base| base.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use brood_genome::{BirthKey, Dialect, Start, Variation};

    use super::{Packer, unpack};

    #[test]
    fn genome_is_unpacked_when_it_was_packed_against_none_one_or_two() {
        let random = Variation::random(Dialect::default()).with_start(Start::Wild);
        let key = |slot| BirthKey { seed: 3, slot, attempt: 0 };
        let (first, second) = (random.birth(key(0)), random.birth(key(1)));
        let child = Variation::crossover(&first, &second, 0.5, 0.3).birth(key(2));
        let [first, second, child] = [first, second, child].map(|genome| genome.canonical_bytes());
        let mut sizes = Vec::new();
        for bases in [vec![], vec![&*first], vec![&*first, &*second]] {
            let packed = Packer::new(&bases).unwrap().pack(&child).unwrap();
            assert_eq!(unpack(&packed, &bases).unwrap(), child);
            sizes.push(packed.len());
        }
        // Half of the child is the second parent's.
        assert!(sizes[2] * 8 < child.len(), "{sizes:?} of {}", child.len());
        assert!(sizes[2] * 4 < sizes[1] && sizes[1] < sizes[0], "{sizes:?}");
    }

    #[test]
    fn damaged_bytes_do_not_panic_and_truncated_ones_are_an_error() {
        let genome: Vec<u8> = (0..3000_u32).map(|at| ((at * at) >> 5) as u8).collect();
        let packed = Packer::new(&[]).unwrap().pack(&genome).unwrap();
        for at in 1..packed.len() {
            let mut damaged = packed.clone();
            damaged[at] ^= 0x41;
            let _ = unpack(&damaged, &[]);
            assert!(unpack(&packed[..at], &[]).is_err(), "{at} bytes");
        }
    }
}

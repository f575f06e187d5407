//! Reader of MERL's `.binary` files: an isotropic material as a table over half and difference
//! angles.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::angle::Angles;
use crate::{Brdf, Claims, DirectionPair};

/// Entries along theta_h, theta_d, and phi_d over half a turn.
const SIZES: [usize; 3] = [90, 90, 180];
const HEAD_BYTES: usize = 12;
const ENTRIES: usize = SIZES[0] * SIZES[1] * SIZES[2];
/// Factors from stored numbers to f in red, green and blue.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// A measured isotropic material.
///
/// # Source
/// Matusik et al. 2003, "A data-driven reflectance model"; the file's layout as in the database's
/// own reader.
pub struct Merl {
    /// Red, green, blue of each entry; the azimuth changes fastest.
    table: Vec<[f32; 3]>,
}

/// Error of [`Merl::read`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MerlError {
    /// The file is shorter than its header.
    #[error("a MERL file must begin with three sizes (12 bytes), got {0} bytes")]
    Short(usize),
    /// The table has another size.
    #[error("a MERL table must be 90 x 90 x 180, got {0} x {1} x {2}")]
    Size(i32, i32, i32),
    /// The file has the wrong length.
    #[error("a MERL file must have {wanted} bytes, got {found}")]
    Length {
        /// Required number of bytes.
        wanted: usize,
        /// Number of bytes of the file.
        found: usize,
    },
    /// An entry is not finite.
    #[error("entry {0} of the MERL table is not a finite number")]
    NotFinite(usize),
}

impl Merl {
    /// Reads a file. Entries below 0, which mark missing measurements, become 0.
    ///
    /// # Errors
    /// Returns [`MerlError`] if the size is wrong or an entry is not finite.
    pub fn read(bytes: &[u8]) -> Result<Self, MerlError> {
        let head = bytes.get(..HEAD_BYTES).ok_or(MerlError::Short(bytes.len()))?;
        let size = |k: usize| i32::from_le_bytes([head[k], head[k + 1], head[k + 2], head[k + 3]]);
        let sizes = [size(0), size(4), size(8)];
        if sizes.map(usize::try_from) != SIZES.map(Ok) {
            return Err(MerlError::Size(sizes[0], sizes[1], sizes[2]));
        }
        let wanted = HEAD_BYTES + 8 * 3 * ENTRIES;
        if bytes.len() != wanted {
            return Err(MerlError::Length { wanted, found: bytes.len() });
        }
        let numbers = bytes[HEAD_BYTES..].as_chunks::<8>().0;
        let mut table = vec![[0.0; 3]; ENTRIES];
        for (channel, scale) in SCALES.into_iter().enumerate() {
            for (entry, place) in table.iter_mut().enumerate() {
                let number = f64::from_le_bytes(numbers[channel * ENTRIES + entry]);
                let value = nearest(number.max(0.0) * scale);
                if !number.is_finite() || !value.is_finite() {
                    return Err(MerlError::NotFinite(channel * ENTRIES + entry));
                }
                place[channel] = value;
            }
        }
        Ok(Self { table })
    }

    /// Index of the bin that holds the angles, as in the database's own reader.
    fn entry(angles: &Angles) -> usize {
        // Bins of the half angle follow its square root: narrow near the highlight.
        let along_h = (angles.theta_h / FRAC_PI_2).sqrt() * SIZES[0] as f64;
        let along_d = angles.theta_d / FRAC_PI_2 * SIZES[1] as f64;
        let around = angles.phi_d / PI * SIZES[2] as f64;
        let [h, d, phi] = [(along_h, 0), (along_d, 1), (around, 2)]
            .map(|(at, axis)| whole(at).min(SIZES[axis] - 1));
        (h * SIZES[1] + d) * SIZES[2] + phi
    }
}

impl Brdf for Merl {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let Some(angles) = Angles::of(pair) else { return DVec3::ZERO };
        DVec3::from_array(self.table[Self::entry(&angles)].map(f64::from))
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
fn nearest(value: f64) -> f32 {
    value as f32
}

/// Integer part of a number that is at least 0.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 180")]
fn whole(value: f64) -> usize {
    value as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file with entries computed from their bins.
    fn file(value: impl Fn(usize, [usize; 3]) -> f64) -> Vec<u8> {
        let mut bytes: Vec<u8> = [90_i32, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect();
        for channel in 0..3 {
            for h in 0..90 {
                for d in 0..90 {
                    for phi in 0..180 {
                        bytes.extend(value(channel, [h, d, phi]).to_le_bytes());
                    }
                }
            }
        }
        bytes
    }

    #[test]
    fn entries_are_indexed_by_angles_and_scaled() {
        let merl = Merl::read(&file(|channel, [h, d, phi]| {
            (channel + 1) as f64 * (h * 20_000 + d * 200 + phi) as f64
        }))
        .unwrap();
        for [h, d, phi] in [[0, 0, 0], [10, 3, 179], [44, 20, 90], [5, 80, 33]] {
            let theta_h = ((h as f64 + 0.5) / 90.0).powi(2) * FRAC_PI_2;
            let angles = Angles {
                theta_h,
                theta_d: (d as f64 + 0.5) / 90.0 * FRAC_PI_2,
                phi_d: (phi as f64 + 0.5) / 180.0 * PI,
            };
            let found = merl.table[Merl::entry(&angles)];
            let wanted = (h * 20_000 + d * 200 + phi) as f64;
            for (channel, found) in found.into_iter().enumerate() {
                let wanted = wanted * (channel + 1) as f64 * SCALES[channel];
                assert!((f64::from(found) - wanted).abs() <= 1e-6 * wanted, "{found} {wanted}");
            }
        }
    }

    #[test]
    fn missing_measurements_are_black_and_swapping_changes_no_bit() {
        let merl =
            Merl::read(&file(|_, [h, d, phi]| if h == 0 { -1.0 } else { (h + d + phi) as f64 }))
                .unwrap();
        let at = |wi: DVec3, wo: DVec3| DirectionPair::new(wi.normalize(), wo.normalize()).unwrap();
        assert_eq!(merl.f(&at(DVec3::Z, DVec3::Z)), DVec3::ZERO);
        let pair = at(DVec3::new(0.3, 0.1, 0.8), DVec3::new(-0.4, 0.6, 0.5));
        assert!(merl.f(&pair).x > 0.0);
        assert_eq!(merl.f(&pair), merl.f(&pair.swapped()));
        assert_eq!(merl.f(&at(DVec3::Z, DVec3::NEG_Z)), DVec3::ZERO);
    }

    #[test]
    fn other_files_are_rejected_with_a_reason() {
        let refused = |bytes: &[u8]| Merl::read(bytes).err().unwrap().to_string();
        assert!(refused(b"abc").contains("got 3 bytes"));
        let mut bytes = file(|_, _| 1.0);
        bytes.truncate(1000);
        assert!(refused(&bytes).contains("must have 34992012 bytes, got 1000"));
        bytes[0] = 91;
        assert!(refused(&bytes).contains("got 91 x 90 x 180"));
        let bytes = file(|channel, [h, ..]| if (channel, h) == (1, 0) { f64::NAN } else { 1.0 });
        assert!(refused(&bytes).contains("entry 1458000"));
    }
}

//! Files of lit spheres for the page: radiance as 16-bit floats.

use brood_scene::SphereLayout;
use half::f16;

/// Writer and reader of files of lit spheres: the radiance of a material in environments, for all
/// normals, seen from several places of a picture.
///
/// # Shapes
/// Little-endian: the magic `broodlit`, u32 version, u32 texels along the side of a sphere, u32
/// turns of the environments, f32 unit, then red, green and blue of each texel as 16-bit floats.
/// Texels are as [`brood_scene::PrefilteredLight::on_spheres`] orders them. Then, if the scene has
/// environments as its backdrop, f32 unit and their radiance behind the object in a square picture
/// of [`BACKDROP_TEXELS`] a side, row by row from the top.
///
/// # Units
/// Numbers are radiance divided by the unit, W/(m2 sr).
///
/// # Error
/// At most 2^-11 of a value; values below 2^-29 of the largest lose digits.
#[derive(Debug)]
pub struct LitSpheres;

const MAGIC: &[u8; 8] = b"broodlit";
const VERSION: u32 = 3;
/// Texels along the side of a backdrop.
pub const BACKDROP_TEXELS: u32 = 64;
/// Bytes before the texels.
const HEAD: usize = 24;
const TEXEL: usize = 6;
/// Exponent of the largest value in units: 16-bit floats end at 65,504.
const LARGEST: i32 = 14;
/// Least exponent of a unit.
const UNIT_MIN: i32 = -126;

impl LitSpheres {
    /// Encodes the radiance of all texels, and of the backdrop if there is one. Values that are not
    /// finite or below 0 become 0.
    #[must_use]
    pub fn encode(
        layout: SphereLayout,
        radiance: &[[f32; 3]],
        backdrop: Option<&[[f32; 3]]>,
    ) -> Vec<u8> {
        let [without, with] = Self::sizes(layout);
        let mut bytes = Vec::with_capacity(if backdrop.is_some() { with } else { without });
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(layout.texels.to_le_bytes());
        bytes.extend(layout.turns.to_le_bytes());
        push_texels(radiance, &mut bytes);
        if let Some(backdrop) = backdrop {
            push_texels(backdrop, &mut bytes);
        }
        bytes
    }

    /// Returns the size of a file in bytes, without and with a backdrop.
    #[must_use]
    pub fn sizes(layout: SphereLayout) -> [usize; 2] {
        let without = HEAD + TEXEL * layout.size_px().pixels() as usize;
        [without, without + size_of::<f32>() + TEXEL * (BACKDROP_TEXELS as usize).pow(2)]
    }

    /// Returns the layout of a file; `None` if it is of another kind.
    #[must_use]
    pub fn layout_of(bytes: &[u8]) -> Option<SphereLayout> {
        let rest = bytes.strip_prefix(MAGIC)?.strip_prefix(&VERSION.to_le_bytes())?;
        let (texels, rest) = rest.split_first_chunk()?;
        let turns = u32::from_le_bytes(*rest.first_chunk()?);
        Some(SphereLayout { texels: u32::from_le_bytes(*texels), turns })
    }
}

/// Adds the unit of texels and the texels.
fn push_texels(radiance: &[[f32; 3]], bytes: &mut Vec<u8>) {
    let clean = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
    let largest = radiance.iter().flatten().fold(0.0f32, |largest, v| largest.max(clean(*v)));
    let exponent = if largest > 0.0 { libm::ilogbf(largest) } else { LARGEST };
    // A power of two, so that division is exact.
    let unit = libm::scalbnf(1.0, (exponent - LARGEST).max(UNIT_MIN));
    bytes.extend(unit.to_le_bytes());
    for value in radiance.iter().flatten() {
        bytes.extend(f16::from_f32(clean(*value) / unit).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_radiance_is_encoded() {
        for brightest in [1e-38, 1e-30, 0.7, 3e38] {
            let mut texels = [[0.0; 3]; 9];
            texels[0] = [f32::NAN, -1.0, f32::INFINITY];
            texels[1] = [brightest, brightest / 3e4, 0.0];
            let layout = SphereLayout { texels: 1, turns: 1 };
            let bytes = LitSpheres::encode(layout, &texels, None);
            assert_eq!(bytes.len(), LitSpheres::sizes(layout)[0]);
            let backdrop = vec![[0.5; 3]; 64 * 64];
            let more = LitSpheres::encode(layout, &texels, Some(&backdrop));
            let expected = (LitSpheres::sizes(layout)[1], &bytes[..]);
            assert_eq!((more.len(), &more[..bytes.len()]), expected);
            assert_eq!(LitSpheres::layout_of(&bytes), Some(layout));
            let unit = f64::from(f32::from_le_bytes(*bytes[20..].first_chunk().unwrap()));
            let read = |at: usize| {
                let number = *bytes[HEAD + 2 * at..].first_chunk().unwrap();
                f64::from(f16::from_le_bytes(number)) * unit
            };
            assert_eq!([read(0), read(1), read(2), read(5)], [0.0; 4]);
            for (at, value) in [(3, brightest), (4, brightest / 3e4)] {
                let error = (read(at) / f64::from(value) - 1.0).abs();
                assert!(error <= 1.0 / 2048.0, "{value} is read as {}", read(at));
            }
        }
    }

    #[test]
    fn file_of_another_kind_has_no_layout() {
        assert_eq!(LitSpheres::layout_of(b"broodlit"), None);
        assert_eq!(LitSpheres::layout_of(&[0; 40]), None);
        let layout = SphereLayout { texels: 2, turns: 4 };
        let turned = LitSpheres::encode(layout, &[[0.5; 3]; 48], None);
        assert_eq!(turned.len(), LitSpheres::sizes(layout)[0]);
        assert_eq!(LitSpheres::layout_of(&turned), Some(layout));
    }
}

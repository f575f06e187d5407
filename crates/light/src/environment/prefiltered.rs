//! Environment light as means of radiance around directions.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::EnvironmentMap;
use super::filtered::{SPOT_SIDES, Spots};
use super::sphere_map::{square, texel_angle, turns};

/// Spacing of tents from which nodes share the light of spots, divided by the size of the spots.
const SPACING_PER_SPOT: f64 = 1.8;
/// Place of the class among the bits of a level.
const CLASS_SHIFT: u8 = 4;
/// Least class of nodes that are wide: their spacing is above 3 degrees.
const WIDE_CLASS: u8 = 3;

/// Environment of a scene, prefiltered.
#[derive(Debug, Clone)]
pub struct PrefilteredEnvironment {
    pub(crate) map: Arc<EnvironmentMap>,
    /// Rotation from the unit frame to the map.
    pub(crate) turn: DMat3,
    pub(crate) scale: [f32; 3],
}

impl PrefilteredEnvironment {
    /// Returns the size in memory of its map in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.map.bytes()
    }

    /// Transforms a direction of the unit frame to one of the map.
    #[must_use]
    pub fn in_map(&self, towards: DVec3) -> DVec3 {
        self.turn * towards
    }

    /// Returns the level whose means are as wide as tents of that spacing in radians; fractions lie
    /// between levels.
    #[must_use]
    pub fn level(&self, spacing: f64) -> f32 {
        self.map.filtered().pyramids[0].level(spacing)
    }

    /// Returns the level and class of a node with tents of that spacing in radians. The means of
    /// the level are without the spots of the class and below, which the caller adds.
    #[must_use]
    pub fn node_level(&self, spacing: f64) -> u8 {
        let level = self.level_with_spots(spacing);
        let is_wide = |side: &&usize| spacing > SPACING_PER_SPOT * texel_angle(**side);
        let class = SPOT_SIDES.iter().take_while(is_wide).count();
        level | u8::try_from(class).expect("there are few classes") << CLASS_SHIFT
    }

    /// Returns the level whose means are about as wide as tents of that spacing in radians, and
    /// include all spots.
    #[must_use]
    pub fn level_with_spots(&self, spacing: f64) -> u8 {
        (self.level(spacing) + 0.5) as u8
    }

    /// Returns the class of a level from [`Self::node_level`].
    #[must_use]
    #[inline(always)]
    pub fn class(level: u8) -> u8 {
        level >> CLASS_SHIFT
    }

    /// True if a level from [`Self::node_level`] is that of a node with wide tents.
    #[must_use]
    #[inline(always)]
    pub fn is_wide(level: u8) -> bool {
        Self::class(level) >= WIDE_CLASS
    }

    /// Returns the spots, at most [`super::SPOTS_MAX`]; their irradiance is not
    /// yet scaled by [`Self::scale`].
    #[must_use]
    pub fn spots(&self) -> &Spots {
        &self.map.filtered().spots
    }

    /// Returns the irradiance of a surface that faces a direction of the map, W/m2.
    ///
    /// # Domain
    /// A unit vector.
    #[must_use]
    pub fn irradiance(&self, n: [f32; 3]) -> [f32; 3] {
        let irradiance = self.map.filtered().irradiance.radiance(square(n));
        [0, 1, 2].map(|c| irradiance[c] * self.scale[c])
    }

    /// Factor of irradiances and radiances of the map.
    #[must_use]
    pub fn scale(&self) -> [f32; 3] {
        self.scale
    }

    /// Returns the angle of a vector as a share of a full turn, within [0, 1].
    ///
    /// # Error
    /// At most 1e-6.
    #[must_use]
    #[inline(always)]
    pub fn turns(x: f32, y: f32) -> f32 {
        turns(x, y)
    }

    /// Returns the point of the map's square for a direction of the map.
    ///
    /// # Domain
    /// A unit vector.
    #[must_use]
    #[inline(always)]
    pub fn square(towards: [f32; 3]) -> [f32; 2] {
        square(towards)
    }

    /// Calls `put` with the mean radiance around each point of the map's square, at its level.
    ///
    /// # Domain
    /// Points from [`Self::square`], levels from [`Self::node_level`]. A point whose level is below
    /// `finest` is read at `finest`, between two levels.
    ///
    /// # Units
    /// W/(m2 sr).
    #[inline(always)]
    pub fn radiance(
        &self,
        points: (&[f32], &[f32]),
        levels: &[u8],
        finest: f32,
        mut put: impl FnMut(usize, [f32; 3]),
    ) {
        let filtered = self.map.filtered();
        let below = finest as u8;
        let share = finest - f32::from(below);
        let [red, green, blue] = self.scale;
        for (k, ((u, v), level)) in points.0.iter().zip(points.1).zip(levels).enumerate() {
            let pyramid = &filtered.pyramids[usize::from(Self::class(*level))];
            let level = level & ((1 << CLASS_SHIFT) - 1);
            let mean = if f32::from(level) < finest {
                let sharp = pyramid.radiance([*u, *v], below);
                let blurred = pyramid.radiance([*u, *v], below + 1);
                let mut mean = sharp;
                for c in 0..4 {
                    mean[c] += (blurred[c] - sharp[c]) * share;
                }
                mean
            } else {
                pyramid.radiance([*u, *v], level)
            };
            put(k, [mean[0] * red, mean[1] * green, mean[2] * blue]);
        }
    }
}

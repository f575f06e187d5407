//! Surface points of a picture that prefiltered light shades.

use glam::DVec3;

use super::facing::{Facing, FacingGroup, groups};
use super::nodes::LobeNodes;

/// Surface point, or several similar ones of a pixel together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LitPoint {
    /// Index of the pixel in the image.
    pub pixel: u32,
    /// Share of the pixel.
    pub weight: f32,
    /// Normal on the side that faces the eye, and direction to the eye; unit vectors.
    pub(crate) n: [f32; 3],
    pub(crate) eye: [f32; 3],
    /// Angle between the normals at the edges of the pixel, in radians.
    pub(crate) spread: f32,
    pub(super) row: u16,
    /// Distance from the row towards the next.
    pub(super) share: f32,
}

impl LitPoint {
    pub(crate) fn new((pixel, weight): (u32, f64), (n, eye): (DVec3, DVec3), spread: f64) -> Self {
        let (row, share) = LobeNodes::row(n.dot(eye));
        Self {
            pixel,
            weight: weight as f32,
            n: n.as_vec3().to_array(),
            eye: eye.as_vec3().to_array(),
            spread: spread as f32,
            row: u16::try_from(row).expect("there are few rows"),
            share,
        }
    }

    /// Adds the mean of each group of similar points of a pixel.
    pub(crate) fn push_groups(
        pixel: u32,
        points: impl Iterator<Item = (Option<Facing>, f64)>,
        out: &mut Vec<Self>,
    ) {
        out.extend(groups(points).map(|FacingGroup { facing, weight, spread }| {
            Self::new((pixel, weight), (facing.frame.n(), facing.eye), spread)
        }));
    }

    /// Row of tables below the angle to the eye, and distance from it towards the next.
    #[must_use]
    #[inline(always)]
    pub fn row(&self) -> (usize, f32) {
        (usize::from(self.row), self.share)
    }
}

//! Surface points of a picture that prefiltered light shades.

use glam::DVec3;

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

/// Similar points of a pixel.
#[derive(Default)]
struct Group {
    first: DVec3,
    n: DVec3,
    eye: DVec3,
    weight: f64,
    /// Largest distance of normals from the first.
    spread: f64,
}

/// Distance of normals from the first of a group, up to which points are similar.
const MAX_DISTANCE: f64 = 0.12;
/// Largest number of groups of a pixel; further points join the nearest.
const MAX_GROUPS: usize = 4;

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

    /// Groups the weighted points of a pixel by their normals, and adds the mean of each group.
    pub(crate) fn push_groups(
        pixel: u32,
        points: impl Iterator<Item = (Option<(DVec3, DVec3)>, f64)>,
        out: &mut Vec<Self>,
    ) {
        let mut groups: Vec<Group> = Vec::with_capacity(MAX_GROUPS);
        for (facing, weight) in points {
            let Some((n, eye)) = facing.filter(|_| weight > 0.0) else { continue };
            let distance = |group: &Group| (group.first - n).length();
            let nearest = (0..groups.len())
                .min_by(|a, b| distance(&groups[*a]).total_cmp(&distance(&groups[*b])));
            let joins = nearest
                .filter(|k| distance(&groups[*k]) <= MAX_DISTANCE || groups.len() == MAX_GROUPS);
            let k = joins.unwrap_or_else(|| {
                groups.push(Group { first: n, ..Group::default() });
                groups.len() - 1
            });
            let group = &mut groups[k];
            group.spread = group.spread.max((group.first - n).length());
            group.n += n * weight;
            group.eye += eye * weight;
            group.weight += weight;
        }
        for group in groups {
            let n = group.n.try_normalize().unwrap_or(group.first);
            let eye = group.eye.normalize();
            out.push(Self::new((pixel, group.weight), (n, eye), group.spread));
        }
    }

    /// Row of tables below the angle to the eye, and distance from it towards the next.
    #[must_use]
    #[inline(always)]
    pub fn row(&self) -> (usize, f32) {
        (usize::from(self.row), self.share)
    }
}

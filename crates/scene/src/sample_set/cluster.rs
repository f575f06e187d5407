//! Grouping of similar light samples of one pixel: f is evaluated once per group, irradiance is
//! integrated over all rays.

use glam::{DVec2, DVec3};

use super::point::{SampleBuffer, SurfacePoint};

/// Largest distance of directions from those of the group's first member: root of the sum of the
/// squared chords of `wi` and `wo`.
const MAX_DIRECTION_DISTANCE: f64 = 0.15;
/// Largest distance of texture positions from the group's first; separates the sides of a seam.
const MAX_UV_DISTANCE: f64 = 0.05;
/// Largest number of groups per light sample. Further members add only their irradiance to the
/// nearest group, and do not change its mean directions.
const MAX_GROUPS: usize = 6;

/// Similar surface points in the light of one light sample.
#[derive(Debug, Clone, Copy)]
struct Group {
    first: (DVec3, DVec3, DVec2),
    wi: DVec3,
    wo: DVec3,
    uv: DVec2,
    weight: f64,
    irradiance: [f64; 3],
}

/// Groups of one pixel: per slot (sample of a light), in order of first appearance.
#[derive(Default)]
pub(super) struct Groups(Vec<Vec<Group>>);

impl Groups {
    /// Groups weighted points and adds one sample per group, with irradiance integrated over the
    /// pixel.
    ///
    /// Returns the covered fraction of the pixel.
    pub fn push_all<'a>(
        &mut self,
        points: impl Iterator<Item = (&'a SurfacePoint, f64)>,
        out: &mut SampleBuffer,
    ) -> f64 {
        self.0.iter_mut().for_each(Vec::clear);
        let mut coverage = 0.0;
        for (point, weight) in points {
            if point.features.covered {
                coverage += weight;
                self.add(point, weight);
            }
        }
        for group in self.0.iter().flatten() {
            out.push(
                group.wi.normalize(),
                group.wo.normalize(),
                group.uv / group.weight,
                group.irradiance,
            );
        }
        coverage
    }

    fn add(&mut self, point: &SurfacePoint, weight: f64) {
        for lit in &point.lit {
            if self.0.len() <= lit.slot {
                self.0.resize_with(lit.slot + 1, Vec::new);
            }
            let groups = &mut self.0[lit.slot];
            let found = find(groups, lit.wi, point.wo, point.uv);
            let (index, similar) = found.unwrap_or_else(|| {
                groups.push(Group {
                    first: (lit.wi, point.wo, point.uv),
                    wi: DVec3::ZERO,
                    wo: DVec3::ZERO,
                    uv: DVec2::ZERO,
                    weight: 0.0,
                    irradiance: [0.0; 3],
                });
                (groups.len() - 1, true)
            });
            let group = &mut groups[index];
            for (sum, e) in group.irradiance.iter_mut().zip(lit.irradiance) {
                *sum += weight * e;
            }
            if !similar {
                // At a pole of the texture, tangents turn by a full circle: the mean of such
                // directions represents none of them.
                continue;
            }
            // Means are weighted by the cosine, so that directions at grazing incidence, which
            // receive little light, do not shift them.
            let share = weight * lit.wi.z;
            group.wi += lit.wi * share;
            group.wo += point.wo * share;
            group.uv += point.uv * share;
            group.weight += share;
        }
    }
}

/// Returns the group that a point joins, and true if the point is similar to it; `None` if the
/// point starts a new group.
fn find(groups: &[Group], wi: DVec3, wo: DVec3, uv: DVec2) -> Option<(usize, bool)> {
    let mut nearest: Option<(usize, f64)> = None;
    for (index, group) in groups.iter().enumerate() {
        let (first_wi, first_wo, first_uv) = group.first;
        let directions = (first_wi - wi).length_squared() + (first_wo - wo).length_squared();
        let texture = (first_uv - uv).abs().max_element();
        if directions <= MAX_DIRECTION_DISTANCE * MAX_DIRECTION_DISTANCE
            && texture <= MAX_UV_DISTANCE
        {
            return Some((index, true));
        }
        let distance = directions / (MAX_DIRECTION_DISTANCE * MAX_DIRECTION_DISTANCE)
            + texture / MAX_UV_DISTANCE;
        if nearest.is_none_or(|nearest| distance < nearest.1) {
            nearest = Some((index, distance));
        }
    }
    nearest.filter(|_| groups.len() >= MAX_GROUPS).map(|nearest| (nearest.0, false))
}

//! Groups of similar points of one pixel: reflectance is evaluated once for each, light is integrated over all.

use glam::{DVec2, DVec3};

use super::point::{Gathered, Point};

/// Directions of a group are within this of its first: the square of the sum of both chords.
const SPREAD: f64 = 0.15;
/// So are texture positions; also keeps apart the two sides of a seam.
const UV_SPREAD: f64 = 0.05;
/// Groups of one sample of a light at most; what comes later gives its light to the nearest and leaves that one's directions alone.
const MOST: usize = 6;

/// Points in the light of one sample of a lamp.
#[derive(Debug, Clone, Copy)]
struct Group {
    first: (DVec3, DVec3, DVec2),
    wi: DVec3,
    wo: DVec3,
    uv: DVec2,
    weight: f64,
    irradiance: [f64; 3],
}

/// The groups of one pixel: of each sample of each light, in the order of first appearance.
#[derive(Default)]
pub(super) struct Groups(Vec<Vec<Group>>);

impl Groups {
    /// Adds the samples that stand for weighted points; their irradiance is integrated over the pixel.
    ///
    /// Returns the share of the pixel that is covered.
    pub fn push_all<'a>(
        &mut self,
        points: impl Iterator<Item = (&'a Point, f64)>,
        out: &mut Gathered,
    ) -> f64 {
        self.0.iter_mut().for_each(Vec::clear);
        let mut coverage = 0.0;
        for (point, weight) in points {
            if point.mark.covered {
                coverage += weight;
                self.take(point, weight);
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

    fn take(&mut self, point: &Point, weight: f64) {
        for lit in &point.lit {
            if self.0.len() <= lit.slot {
                self.0.resize_with(lit.slot + 1, Vec::new);
            }
            let groups = &mut self.0[lit.slot];
            let found = find(groups, lit.wi, point.wo, point.uv);
            let (index, alike) = found.unwrap_or_else(|| {
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
            if !alike {
                // At a pole of the texture tangents turn all the way round: the mean of such directions is none of them.
                continue;
            }
            // The mean place is that of the light received, so that what is nearly dark does not pull at it.
            let share = weight * lit.wi.z;
            group.wi += lit.wi * share;
            group.wo += point.wo * share;
            group.uv += point.uv * share;
            group.weight += share;
        }
    }
}

/// The group that a point joins, if it need not open a new one, and whether it is like that group.
fn find(groups: &[Group], wi: DVec3, wo: DVec3, uv: DVec2) -> Option<(usize, bool)> {
    let mut nearest: Option<(usize, f64)> = None;
    for (index, group) in groups.iter().enumerate() {
        let (first_wi, first_wo, first_uv) = group.first;
        let directions = (first_wi - wi).length_squared() + (first_wo - wo).length_squared();
        let texture = (first_uv - uv).abs().max_element();
        if directions <= SPREAD * SPREAD && texture <= UV_SPREAD {
            return Some((index, true));
        }
        let distance = directions / (SPREAD * SPREAD) + texture / UV_SPREAD;
        if nearest.is_none_or(|nearest| distance < nearest.1) {
            nearest = Some((index, distance));
        }
    }
    nearest.filter(|_| groups.len() >= MOST).map(|nearest| (nearest.0, false))
}

//! Filtered environment: means over parts of the sphere, small bright parts, and irradiances.

use glam::DVec3;

use super::grid::PixelGrid;
use super::pyramid::{Level, Pyramid, irradiance, means};
use super::sphere_map::{direction, texel_angle};
use crate::units::luminance;

/// Luminance, relative to the mean of the map, above which light belongs to spots.
const SPOT_LEVEL: f64 = 2.0;
/// Largest mean radiance, so that sums of brighter maps do not overflow.
const RADIANCE_MAX: f32 = 1e25;
/// Largest number of spots; the level of maps with more is raised.
pub const SPOTS_MAX: usize = 768;
/// Texels of a side of the squares whose texels are spots, by class from 1 on: 0.4 to 3.2 degrees a
/// texel.
pub(super) const SPOT_SIDES: [usize; 4] = [512, 256, 128, 64];

/// Filtered map, and its light in spots.
///
/// Means over tents that are wider than a small bright source would show the tents. For such nodes
/// the source is a spot, whose light is shared among the nodes around it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filtered {
    /// Without the spots of classes up to the index.
    pub pyramids: Vec<Pyramid>,
    pub spots: Spots,
    /// Irradiance of surfaces by the direction that they face.
    pub irradiance: Level,
}

/// Small bright parts of an environment, as a structure of arrays of one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spots {
    /// Unit directions of the map: x, y and z.
    pub towards: [Vec<f32>; 3],
    /// Irradiance at normal incidence in red, green and blue, W/m2 up to the scale of the light.
    pub irradiance: [Vec<f32>; 3],
    /// Class of the size: nodes of this class and above share the light.
    pub classes: Vec<u8>,
}

impl Spots {
    fn push(&mut self, towards: DVec3, irradiance: DVec3, class: u8) {
        for axis in 0..3 {
            self.towards[axis].push(towards[axis] as f32);
            self.irradiance[axis].push(irradiance[axis] as f32);
        }
        self.classes.push(class);
    }
}

impl Filtered {
    /// Upper bound of its memory in bytes.
    pub const BYTES: usize = (SPOT_SIDES.len() + 1) * Pyramid::BYTES;

    /// Filters pixels; `mean` is their mean radiance.
    pub fn new(grid: &PixelGrid, mean: [f64; 3]) -> Self {
        let (mut texels, side) = means(grid);
        texels.iter_mut().flatten().for_each(|channel| *channel = channel.min(RADIANCE_MAX));
        let (facing, facing_side) = irradiance(&texels, side);
        let mut level = SPOT_LEVEL * luminance(mean);
        let found = loop {
            if let Some(found) = spots(&texels, side, level) {
                break found;
            }
            level *= 1.25;
        };
        let mut rest = texels;
        let mut pyramids = vec![Pyramid::new(rest.clone(), side)];
        for class in 1..=SPOT_SIDES.len() {
            let is_spot = |index: &usize| usize::from(found.classes[*index]) == class;
            let indices: Vec<usize> = (0..rest.len()).filter(is_spot).collect();
            for index in &indices {
                rest[*index] = darkened(rest[*index], level);
            }
            let pyramid = match pyramids.last() {
                Some(last) if indices.is_empty() => last.clone(),
                _ => Pyramid::new(rest.clone(), side),
            };
            pyramids.push(pyramid);
        }
        Self { pyramids, spots: found.spots, irradiance: Level::new(facing_side, &facing) }
    }
}

/// Limits the luminance of a radiance.
fn darkened(radiance: [f32; 3], level: f64) -> [f32; 3] {
    let scale = (level / luminance(radiance.map(f64::from)).max(level)) as f32;
    radiance.map(|channel| channel * scale)
}

/// Spots, and the class of the spot of each texel; 0 for none.
struct Found {
    spots: Spots,
    classes: Vec<u8>,
}

/// Light above a level within a texel of one of [`SPOT_SIDES`].
#[derive(Clone, Copy)]
struct Leaf {
    class: usize,
    x: usize,
    y: usize,
    /// Sum of directions times luminous irradiance.
    towards: DVec3,
    irradiance: DVec3,
}

/// Finds the spots of what is brighter than a level: the brightest are split, so that no spot has
/// much more light than the others. `None` if there are more than [`SPOTS_MAX`].
fn spots(texels: &[[f32; 3]], side: usize, level: f64) -> Option<Found> {
    let solid_angle = texel_angle(side) * texel_angle(side);
    let gather = |class: usize, x: usize, y: usize| {
        let across = (side / SPOT_SIDES[class - 1]).max(1);
        let mut leaf = Leaf { class, x, y, towards: DVec3::ZERO, irradiance: DVec3::ZERO };
        for row in y * across..(y + 1) * across {
            for column in x * across..(x + 1) * across {
                let radiance = DVec3::from(texels[row * side + column].map(f64::from));
                let bright = luminance(radiance.to_array());
                if bright > level {
                    let excess = radiance * ((1.0 - level / bright) * solid_angle);
                    let at = |texel: usize| (texel as f64 + 0.5) / side as f64;
                    leaf.towards += direction([at(column), at(row)]) * luminance(excess.to_array());
                    leaf.irradiance += excess;
                }
            }
        }
        leaf
    };
    let is_lit = |leaf: &Leaf| leaf.irradiance != DVec3::ZERO;
    let light = |leaf: &Leaf| luminance(leaf.irradiance.to_array());
    // Classes finer than the map do not exist.
    let finest =
        SPOT_SIDES.iter().position(|spots| *spots <= side).map_or(SPOT_SIDES.len(), |k| k + 1);
    let coarsest = SPOT_SIDES.len();
    let spot_side = SPOT_SIDES[coarsest - 1].min(side);
    let mut leaves: Vec<Leaf> = (0..spot_side * spot_side)
        .map(|k| gather(coarsest, k % spot_side, k / spot_side))
        .filter(is_lit)
        .collect();
    if leaves.len() > SPOTS_MAX {
        return None;
    }
    while leaves.len() + 3 <= SPOTS_MAX {
        let divisible = leaves.iter().enumerate().filter(|(_, leaf)| leaf.class > finest);
        let brightest = divisible.max_by(|a, b| light(a.1).total_cmp(&light(b.1)));
        let Some((index, Leaf { class, x, y, .. })) = brightest.map(|(k, leaf)| (k, *leaf)) else {
            break;
        };
        leaves.swap_remove(index);
        let parts = [(0, 0), (1, 0), (0, 1), (1, 1)];
        let parts = parts.map(|(right, below)| gather(class - 1, 2 * x + right, 2 * y + below));
        leaves.extend(parts.into_iter().filter(is_lit));
    }
    let mut classes = vec![0; texels.len()];
    let mut spots = Spots::default();
    for leaf in &leaves {
        let class = u8::try_from(leaf.class).expect("there are few classes");
        let across = (side / SPOT_SIDES[leaf.class - 1]).max(1);
        for row in leaf.y * across..(leaf.y + 1) * across {
            classes[row * side + leaf.x * across..][..across].fill(class);
        }
        if let Some(towards) = leaf.towards.try_normalize() {
            spots.push(towards, leaf.irradiance, class);
        }
    }
    Some(Found { spots, classes })
}

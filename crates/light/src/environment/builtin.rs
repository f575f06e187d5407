//! Built-in environments, made by code.
//!
//! Radiances are relative: 1 is the radiance of a bright white wall. The default camera looks from
//! azimuth 30 degrees, so a key light at azimuth 65 to 80 comes from its right.

use std::sync::{Arc, OnceLock};

use brood_mesh::angle::orbit_direction;
use glam::DVec3;

use super::EnvironmentMap;

/// Columns and rows of the maps.
const SIZE: (usize, usize) = (768, 384);

/// Built-in environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BuiltinEnvironment {
    /// Dim photographic studio with three soft boxes.
    Studio,
    /// Overcast sky over dull ground.
    Overcast,
    /// Clear sky with a hazy sun 12 degrees above the horizon.
    LowSun,
    /// Room with a window and a lamp.
    Interior,
}

impl BuiltinEnvironment {
    /// All built-in environments.
    pub const ALL: [Self; 4] = [Self::Studio, Self::Overcast, Self::LowSun, Self::Interior];

    /// Returns the name used in scenes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Overcast => "overcast",
            Self::LowSun => "low-sun",
            Self::Interior => "interior",
        }
    }

    /// Returns the environment of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|environment| environment.name() == name)
    }

    /// Returns the map, which is made once.
    #[must_use]
    pub fn map(self) -> Arc<EnvironmentMap> {
        static MAPS: [OnceLock<Arc<EnvironmentMap>>; 4] = [const { OnceLock::new() }; 4];
        MAPS[self as usize]
            .get_or_init(|| Arc::new(EnvironmentMap::drawn(SIZE, |w| self.radiance(w))))
            .clone()
    }

    /// Returns the radiance from a direction.
    fn radiance(self, towards: DVec3) -> [f64; 3] {
        match self {
            Self::Studio => studio(towards),
            Self::Overcast => overcast(towards),
            Self::LowSun => low_sun(towards),
            Self::Interior => interior(towards),
        }
    }
}

/// Rectangular soft box at a distance of 1.
struct SoftBox {
    /// Azimuth and elevation of its centre, degrees.
    centre_deg: [f64; 2],
    /// Half width and half height.
    half: [f64; 2],
    radiance: [f64; 3],
}

impl SoftBox {
    /// Adds its light: brightest in the middle, fading within a narrow border.
    fn add(&self, towards: DVec3, sum: &mut [f64; 3]) {
        let z = orbit_direction(self.centre_deg[0], self.centre_deg[1]);
        let along = towards.dot(z);
        if along <= 0.0 {
            return;
        }
        let up = if z.y.abs() > 0.9 { DVec3::NEG_Z } else { DVec3::Y };
        let x = up.cross(z).normalize();
        let y = z.cross(x);
        let at = [towards.dot(x) / along / self.half[0], towards.dot(y) / along / self.half[1]];
        let inside = |at: f64, half: f64| {
            let border = 0.04 / half;
            smooth((1.0 - at.abs()) / border)
        };
        let shape = inside(at[0], self.half[0]) * inside(at[1], self.half[1]);
        let glow = 1.0 - 0.3 * (at[0] * at[0] + at[1] * at[1]).min(2.0);
        sum.iter_mut().zip(self.radiance).for_each(|(sum, channel)| *sum += channel * shape * glow);
    }
}

/// Rises smoothly from 0 at 0 to 1 at 1.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * t)
}

fn studio(towards: DVec3) -> [f64; 3] {
    let wall = mix([0.10, 0.10, 0.105], [0.20, 0.20, 0.21], smooth(towards.y));
    let floor = mix([0.26, 0.255, 0.25], [0.12, 0.12, 0.12], smooth(-1.4 * towards.y));
    let mut sum = mix(floor, wall, smooth(4.0 * towards.y + 0.5));
    let boxes = [
        SoftBox { centre_deg: [78.0, 42.0], half: [0.42, 0.34], radiance: [9.0, 8.6, 8.0] },
        SoftBox { centre_deg: [-35.0, 18.0], half: [0.13, 0.62], radiance: [4.2, 4.6, 5.2] },
        SoftBox { centre_deg: [190.0, 38.0], half: [0.62, 0.16], radiance: [5.5, 5.5, 5.5] },
        SoftBox { centre_deg: [20.0, 88.0], half: [0.5, 0.3], radiance: [2.2, 2.2, 2.3] },
    ];
    boxes.iter().for_each(|soft_box| soft_box.add(towards, &mut sum));
    sum
}

/// # Source
/// The CIE standard overcast sky: three times as bright at the zenith as at the horizon.
fn overcast(towards: DVec3) -> [f64; 3] {
    let height = towards.y.max(0.0);
    let sky = [0.93, 0.97, 1.05].map(|channel| channel * (1.0 + 2.0 * height) / 3.0 * 1.6);
    let ground = [0.17, 0.155, 0.135];
    mix(ground, sky, smooth(12.0 * towards.y + 0.5))
}

fn low_sun(towards: DVec3) -> [f64; 3] {
    let sun = orbit_direction(80.0, 12.0);
    let cos = towards.dot(sun).clamp(-1.0, 1.0);
    let height = towards.y.max(0.0);
    let zenith = [0.16, 0.30, 0.62];
    let horizon = mix([0.62, 0.60, 0.62], [1.7, 1.05, 0.55], smooth(0.5 + 0.5 * cos));
    let haze = (1.0 - height) * (1.0 - height);
    let mut sky = mix(zenith, horizon, haze * haze);
    // The disc is 4 degrees wide: sampled pictures need many samples for a smaller one.
    let angle = libm::acos(cos).to_degrees();
    let glow = 1.0 / (1.0 + (angle / 5.0) * (angle / 5.0));
    let disc = smooth((2.4 - angle) / 0.8);
    for (sky, warm) in sky.iter_mut().zip([1.0, 0.78, 0.5]) {
        *sky += warm * (3.0 * glow * glow + 420.0 * disc);
    }
    let ground = mix([0.11, 0.09, 0.07], [0.30, 0.20, 0.11], smooth(0.5 + 0.5 * cos));
    mix(ground, sky, smooth(20.0 * towards.y + 0.5))
}

fn interior(towards: DVec3) -> [f64; 3] {
    // A room of 6 x 3 x 5 metres, seen from 1.2 metres above its floor.
    let (low, high) = (DVec3::new(-3.0, -1.2, -2.5), DVec3::new(3.0, 1.8, 2.5));
    let distance = |axis: usize| {
        let bound = if towards[axis] < 0.0 { low[axis] } else { high[axis] };
        if towards[axis] == 0.0 { f64::INFINITY } else { bound / towards[axis] }
    };
    let axis =
        (0..3).fold(0, |best, axis| if distance(axis) < distance(best) { axis } else { best });
    let hit = towards * distance(axis);
    let within =
        |at: f64, low: f64, high: f64| smooth((at - low) / 0.05) * smooth((high - at) / 0.05);
    let window_light = 1.0 / (1.0 + (hit - DVec3::new(3.0, 0.4, 0.3)).length_squared() / 3.0);
    let lamp_light = 1.0 / (1.0 + (hit - DVec3::new(-1.2, 1.7, 0.8)).length_squared());
    let shade = 0.16 + 0.9 * window_light;
    let wall = [0, 1, 2].map(|c| {
        [0.62, 0.58, 0.52][c]
            * (shade * [0.9, 0.97, 1.1][c] + 0.5 * lamp_light * [1.2, 0.9, 0.6][c])
    });
    match axis {
        0 if hit.x > 0.0 => {
            let pane = |low: f64, high: f64| within(hit.z, low, high);
            let open = within(hit.y, -0.4, 1.3) * (pane(-0.95, 0.25) + pane(0.35, 1.55));
            mix(wall, [9.0, 10.0, 11.5], open)
        }
        1 if hit.y > 0.0 => {
            let lamp = DVec3::new(-1.2, 1.8, 0.8);
            let near = (hit - lamp).length();
            let ceiling = wall.map(|channel| 1.15 * channel);
            mix(ceiling, [16.0, 11.5, 7.0], smooth((0.32 - near) / 0.06))
        }
        1 => [0, 1, 2].map(|c| wall[c] * [0.52, 0.34, 0.2][c]),
        _ => wall,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_distinct_and_maps_are_lit_from_above() {
        for environment in BuiltinEnvironment::ALL {
            assert_eq!(BuiltinEnvironment::from_name(environment.name()), Some(environment));
            let map = environment.map();
            let mean = map.mean();
            assert!(mean.iter().all(|c| (0.1..3.0).contains(c)), "{environment:?} {mean:?}");
            let mut sums = [0.0; 2];
            for row in 0..SIZE.1 {
                let (cos, area) = map.grid().row(row);
                let sum: f64 =
                    (0..SIZE.0).map(|column| map.grid().pixel(row, column)[1] * area).sum();
                sums[usize::from(cos < 0.0)] += sum;
            }
            assert!(sums[0] > 1.5 * sums[1], "{environment:?} {sums:?}");
        }
        assert_eq!(BuiltinEnvironment::from_name("sky"), None);
    }
}

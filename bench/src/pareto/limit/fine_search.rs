//! The largest directional albedo of a program by brute force, with the quadratures of
//! [`fine_albedo`](super::fine_albedo): no grid, rule or step is that of the energy limit.

use brood_brdf::{Input, Model, PreparedModel};
use brood_eval::{Level, is_anisotropic};
use brood_genome::Output;
use brood_program::Program;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::fine_albedo::{Adaptive, Lattice, LatticeSamples};

/// Sine of the flattest angle with equal steps of the angle; beyond it the logarithm of the cosine
/// has equal steps.
const BEND: f64 = 0.26;

/// Inputs that vary fast near the mirror direction.
const HIGHLIGHTS: [Input; 4] =
    [Input::LogTanHalf, Input::NormalDotHalf, Input::CosineDifference, Input::MirrorAsymmetry];

/// Number of directions and positions.
#[derive(Debug, Clone, Copy)]
pub struct FineEffort {
    /// Elevations with equal steps of the angle.
    pub elevations: usize,
    /// Elevations with equal steps of the logarithm of the cosine.
    pub flat: usize,
    /// Azimuths over half a turn.
    pub azimuths: usize,
    /// Texture positions along an axis.
    pub side: usize,
    /// Directions of the lattice for the scan.
    pub scan_nodes: usize,
    /// Directions of the lattice for the refinement.
    pub nodes: usize,
    /// Directions of the lattice for the result.
    pub final_nodes: usize,
    /// Places that are refined.
    pub starts: usize,
    /// Elevations and azimuths for layers alone.
    pub layer_grid: (usize, usize),
}

impl FineEffort {
    /// Effort of the recorded runs.
    pub const FULL: Self = Self {
        elevations: 30,
        flat: 12,
        azimuths: 13,
        side: 9,
        scan_nodes: 233,
        nodes: 610,
        final_nodes: 17_711,
        starts: 12,
        layer_grid: (48, 9),
    };

    /// Effort of quick runs, which only show that everything works.
    pub const SHORT: Self = Self {
        elevations: 8,
        flat: 4,
        azimuths: 4,
        side: 4,
        scan_nodes: 55,
        nodes: 89,
        final_nodes: 987,
        starts: 3,
        layer_grid: (12, 3),
    };
}

/// A place: cosine of the incident direction as its elevation coordinate, azimuth in turns, texture
/// position.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Angle above the horizon in radians down to [`BEND`], then 2 [`BEND`] below it for the
    /// flattest cosine.
    elevation: f64,
    turn: f64,
    uv: DVec2,
}

/// The largest albedo that was found.
#[derive(Debug, Clone, Copy)]
pub struct FineAlbedo {
    /// Largest albedo of the channels.
    pub albedo: f64,
    /// Where it is.
    pub place: Place,
}

/// Brute-force search with the samples that all programs share.
pub struct FineSearch {
    effort: FineEffort,
    /// Least cosine of the incident direction.
    flattest: f64,
    level: Level,
    lattices: [Lattice; 3],
    /// Directions of the scan and their samples: isotropic, then anisotropic, without highlights;
    /// then with.
    scans: [(Vec<Place>, LatticeSamples); 4],
}

impl Place {
    /// Cosine of the angle from the normal.
    pub fn cos(&self, flattest: f64) -> f64 {
        if self.elevation >= BEND {
            return libm::sin(self.elevation);
        }
        let bend = libm::sin(BEND);
        bend * libm::exp(libm::log(flattest / bend) * (BEND - self.elevation) / (2.0 * BEND))
    }

    /// Incident direction.
    fn direction(&self, flattest: f64) -> DVec3 {
        let cos = self.cos(flattest);
        let across = if self.elevation >= BEND {
            libm::cos(self.elevation)
        } else {
            ((1.0 - cos) * (1.0 + cos)).sqrt()
        };
        let (sin, cosine) = libm::sincos(std::f64::consts::TAU * self.turn);
        DVec3::new(across * cosine, across * sin, cos)
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { elevation, turn, uv } = self;
        write!(f, "elevation {elevation:.4} turn {turn:.4} u {:.4} v {:.4}", uv.x, uv.y)
    }
}

/// A program taken apart: its steps, its layers, the output stage.
struct Parts<'a> {
    squares: Option<Program>,
    layers: Vec<PreparedModel>,
    output: &'a Output,
    /// True if an input varies fast near the mirror direction.
    highlights: bool,
}

impl FineSearch {
    /// Prepares a search of all directions whose cosine is at least `flattest`.
    pub fn new(effort: FineEffort, flattest: f64) -> Self {
        let lattices = [effort.scan_nodes, effort.nodes, effort.final_nodes].map(Lattice::new);
        let scan = |azimuths: usize, more: usize, highlights: bool| {
            let places = grid(effort.elevations * more, effort.flat * more, azimuths, 0.37);
            let incident: Vec<_> =
                places.iter().map(|place| (place.direction(flattest), DVec2::ZERO)).collect();
            let set = LatticeSamples::new(&incident, &lattices[0], highlights);
            (places, set)
        };
        let turns = effort.azimuths;
        let scans =
            [scan(1, 6, false), scan(turns, 1, false), scan(1, 6, true), scan(turns, 1, true)];
        Self { effort, flattest, level: Level::best(), lattices, scans }
    }

    /// Returns the largest albedo of a program, output stage included.
    pub fn largest(&self, program: &Program) -> FineAlbedo {
        let parts = Parts {
            squares: (program.operations() > 0).then(|| program.bare()),
            layers: program.layers().iter().map(Model::prepare).collect(),
            output: program.output(),
            highlights: HIGHLIGHTS.into_iter().any(|input| program.inputs().contains(input)),
        };
        let reads = |input| program.inputs().contains(input);
        let (u, v, turns) = (reads(Input::U), reads(Input::V), is_anisotropic(program));
        let mut starts = match &parts.squares {
            Some(squares) => self.scan(squares, &parts, (u, v, turns)),
            None => self.scan_layers(&parts, turns),
        };
        starts.sort_by(|a, b| b.albedo.total_cmp(&a.albedo));
        starts.truncate(self.effort.starts);
        self.refine(&parts, starts, (u, v, turns))
    }

    fn scan(
        &self,
        squares: &Program,
        parts: &Parts<'_>,
        (u, v, turns): (bool, bool, bool),
    ) -> Vec<FineAlbedo> {
        let (places, set) = &self.scans[usize::from(turns) + 2 * usize::from(parts.highlights)];
        let of_layers: Vec<DVec3> =
            places.iter().map(|place| self.layers(parts, place, 3e-4)).collect();
        let side = match (u, v) {
            (true, true) => self.effort.side,
            _ => 3 * self.effort.side,
        };
        let along = |on: bool| -> Vec<f64> {
            let count = if on { side } else { 1 };
            (0..count).map(|at| at as f64 / (side - 1) as f64).collect()
        };
        let positions: Vec<DVec2> = along(u)
            .into_iter()
            .flat_map(|u| along(v).into_iter().map(move |v| DVec2::new(u, v)))
            .collect();
        let at = |uv: &DVec2| {
            let fixed = squares.at_texture_position(uv.x as f32, uv.y as f32);
            let albedos = set.albedos(&fixed);
            let both = albedos.into_iter().zip(&of_layers).zip(places);
            let mut found: Vec<FineAlbedo> = both
                .map(|((squares, layers), place)| FineAlbedo {
                    albedo: stage(parts.output, squares + *layers),
                    place: Place { uv: *uv, ..*place },
                })
                .collect();
            found.sort_by(|a, b| b.albedo.total_cmp(&a.albedo));
            found.truncate(self.effort.starts);
            found
        };
        positions.par_iter().map(at).collect::<Vec<_>>().concat()
    }

    fn scan_layers(&self, parts: &Parts<'_>, turns: bool) -> Vec<FineAlbedo> {
        let (elevations, azimuths) = self.effort.layer_grid;
        let azimuths = if turns { azimuths } else { 1 };
        let places = grid(elevations / 2, elevations / 2, azimuths, 0.0);
        let found = places.par_iter().map(|place| FineAlbedo {
            albedo: stage(parts.output, self.layers(parts, place, 1e-4)),
            place: *place,
        });
        found.collect()
    }

    /// Albedo of all layers, each cell of the quadrature within `tolerance`, relative.
    fn layers(&self, parts: &Parts<'_>, place: &Place, tolerance: f64) -> DVec3 {
        let wi = place.direction(self.flattest);
        let of = |model: &PreparedModel| Adaptive::albedo(model, self.level, wi, tolerance);
        parts.layers.iter().map(of).sum()
    }

    fn measure(&self, parts: &Parts<'_>, places: &[Place], lattice: usize) -> Vec<f64> {
        let nodes = &self.lattices[lattice];
        let tolerance = if lattice == 2 { 1e-6 } else { 3e-5 };
        let at = |places: &[Place]| -> Vec<f64> {
            let squares = parts.squares.as_ref().map(|squares| {
                let incident: Vec<_> =
                    places.iter().map(|place| (place.direction(self.flattest), place.uv)).collect();
                LatticeSamples::new(&incident, nodes, parts.highlights).albedos(squares)
            });
            let squares = squares.unwrap_or_else(|| vec![DVec3::ZERO; places.len()]);
            let both = places.iter().zip(squares);
            both.map(|(place, squares)| {
                stage(parts.output, squares + self.layers(parts, place, tolerance))
            })
            .collect()
        };
        places.par_chunks(4).flat_map_iter(at).collect()
    }

    fn refine(
        &self,
        parts: &Parts<'_>,
        starts: Vec<FineAlbedo>,
        (u, v, turns): (bool, bool, bool),
    ) -> FineAlbedo {
        let places: Vec<Place> = starts.iter().map(|found| found.place).collect();
        let albedos = self.measure(parts, &places, 1);
        let mut climbers: Vec<FineAlbedo> = places
            .into_iter()
            .zip(albedos)
            .map(|(place, albedo)| FineAlbedo { albedo, place })
            .collect();
        let mut step = Place {
            elevation: 0.6 / self.effort.elevations as f64,
            turn: 0.2 / self.effort.azimuths as f64,
            uv: DVec2::splat(0.4 / (self.effort.side - 1) as f64),
        };
        for round in 0..10 {
            climbers.sort_by(|a, b| b.albedo.total_cmp(&a.albedo));
            climbers.truncate((self.effort.starts >> (round / 2)).max(2));
            let around: Vec<Vec<Place>> = climbers
                .iter()
                .map(|found| neighbours(&found.place, &step, (u, v, turns)))
                .collect();
            let values = self.measure(parts, &around.concat(), 1);
            let mut values = around.iter().flatten().zip(values);
            for (found, around) in climbers.iter_mut().zip(&around) {
                for (place, albedo) in values.by_ref().take(around.len()) {
                    if albedo > found.albedo {
                        *found = FineAlbedo { albedo, place: *place };
                    }
                }
            }
            step.elevation *= 0.6;
            step.turn *= 0.6;
            step.uv *= 0.6;
        }
        climbers.sort_by(|a, b| b.albedo.total_cmp(&a.albedo));
        climbers.truncate(2);
        let places: Vec<Place> = climbers.iter().map(|found| found.place).collect();
        let albedos = self.measure(parts, &places, 2);
        let finals = places.into_iter().zip(albedos);
        finals
            .map(|(place, albedo)| FineAlbedo { albedo, place })
            .max_by(|a, b| a.albedo.total_cmp(&b.albedo))
            .expect("there are two")
    }
}

fn neighbours(place: &Place, step: &Place, (u, v, turns): (bool, bool, bool)) -> Vec<Place> {
    let mut all = Vec::new();
    for sign in [-1.0, 1.0] {
        let elevation =
            (place.elevation + sign * step.elevation).clamp(-BEND, std::f64::consts::FRAC_PI_2);
        all.push(Place { elevation, ..*place });
        if turns {
            all.push(Place { turn: place.turn + sign * step.turn, ..*place });
        }
        for axis in [u.then_some(DVec2::X), v.then_some(DVec2::Y)].into_iter().flatten() {
            let uv = (place.uv + axis * step.uv * sign).clamp(DVec2::ZERO, DVec2::ONE);
            all.push(Place { uv, ..*place });
        }
    }
    all
}

/// Places of a grid: the normal, the horizon, and what is between.
fn grid(elevations: usize, flat: usize, azimuths: usize, shift: f64) -> Vec<Place> {
    let steep = (0..elevations).map(|at| {
        let share = (at as f64 + 1.0) / elevations as f64;
        BEND + (std::f64::consts::FRAC_PI_2 - BEND) * share
    });
    let below = (0..flat).map(|at| -BEND + 2.0 * BEND * at as f64 / flat as f64);
    let within = [0.2, 0.5, 0.8, 1.1].map(|ramp| std::f64::consts::FRAC_PI_2 - ramp / 1_048_576.0);
    let elevations: Vec<f64> = below.chain(steep).chain(within).collect();
    let turn = move |at: usize| 0.5 * (at as f64 + shift) / azimuths as f64;
    let row = |elevation: f64| {
        (0..azimuths).map(move |at| Place { elevation, turn: turn(at), uv: DVec2::ZERO })
    };
    elevations.into_iter().flat_map(row).collect()
}

fn stage(output: &Output, albedo: DVec3) -> f64 {
    let channel = |channel: usize| {
        let mixed = DVec3::from(output.matrix()[channel].map(f64::from)).dot(albedo);
        let offset = std::f64::consts::PI * f64::from(output.offset()[channel]);
        f64::from(output.scale()[channel]) * mixed + offset
    };
    (0..3).map(channel).fold(0.0, f64::max)
}

//! Search for the largest directional albedo of a program.

use std::sync::OnceLock;

use brood_brdf::Input;
use brood_program::Program;
use brood_scene::SampleSet;
use glam::DVec2;

use super::hemisphere::Quadrature;
use super::limit::{EnergyLimit, Incidence};
use super::subject::{self, Subject};

/// Inputs that change when the surface turns about its normal; a program without them is isotropic.
const AZIMUTHAL: [Input; 4] = [Input::SmoothP5, Input::SmoothP6, Input::PaperP5, Input::PaperP6];
/// Largest angle of incidence in degrees; the integral is ill-defined at grazing incidence.
const THETA_MAX_DEG: f64 = 89.5;
/// Highest order of the measurement.
pub const ALBEDO_ORDER: usize = 128;
/// Orders of the measurement, each twice the one before.
const ORDERS: [usize; 4] = [16, 32, 64, ALBEDO_ORDER];
/// Relative error of f32 values and of the divided output stage.
const ROUNDING: f64 = 1.0 / (1u64 << 20) as f64;
/// Relative change at which the measurement ends, from one order to twice that order.
const SETTLED: f64 = 1e-4;

/// Number of directions, positions and steps of the search before the albedo is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Number of angles from the normal on the grid.
    pub thetas: usize,
    /// Number of azimuths on the grid, over half a turn: the other half changes no input.
    pub azimuths: usize,
    /// Number of texture positions along a side of [0, 1]^2.
    pub uv_side: usize,
    /// Order of the quadrature on the grid.
    pub grid_order: usize,
    /// Number of places of the grid that the pattern search starts from.
    pub starts: usize,
    /// Number of halvings of the step of the pattern search.
    pub halvings: u32,
    /// Order of the quadrature of the pattern search.
    pub search_order: usize,
}

impl Effort {
    /// Effort of the energy limit, chosen by `brood bench pareto --sweep albedo`.
    pub const USUAL: Self = Self {
        thetas: 16,
        azimuths: 8,
        uv_side: 5,
        grid_order: 8,
        starts: 8,
        halvings: 6,
        search_order: 16,
    };
}

/// The places of the grid at one texture position, and their samples: the same for all programs.
type Tile = (Vec<Incidence>, SampleSet);

/// Search for the largest albedo, with the data that all programs share.
#[derive(Debug)]
pub struct LimitSearch {
    effort: Effort,
    grid_rule: Quadrature,
    search_rule: Quadrature,
    /// Quadratures of the measurement, by [`ORDERS`], created at first use.
    measuring: [OnceLock<Quadrature>; ORDERS.len()],
    /// Tiles without azimuths, then those with; each by texture position.
    tiles: [Vec<OnceLock<Tile>>; 2],
}

impl LimitSearch {
    /// Prepares a search.
    ///
    /// # Panics
    /// If the effort has no directions or starts.
    #[must_use]
    pub fn new(effort: Effort) -> Self {
        assert!(effort.thetas > 1 && effort.uv_side > 1 && effort.starts > 0, "{effort:?}");
        let tiles = || (0..effort.uv_side * effort.uv_side).map(|_| OnceLock::new()).collect();
        Self {
            effort,
            grid_rule: Quadrature::new(effort.grid_order),
            search_rule: Quadrature::new(effort.search_order),
            measuring: Default::default(),
            tiles: [tiles(), tiles()],
        }
    }

    /// Returns the limit of a program and the place where its albedo is largest.
    #[must_use]
    pub fn run(&self, program: &Program) -> (EnergyLimit, Incidence) {
        let axes = Axes::of(program);
        let subject = Subject::new(program);
        let mut samples = 0;
        let starts = self.best_of_grid(&subject, axes, &mut samples);
        let (place, gain) = self.climb(&subject, starts, axes, &mut samples);
        let (albedo, change) = self.measure(&subject, place, &mut samples);
        // The gain of the last step bounds that of further steps.
        let error_bound = if albedo > 0.0 { (change + gain) / albedo + ROUNDING } else { 0.0 };
        let divisor = (albedo * (1.0 + error_bound)).max(1.0);
        let theta_deg = place.theta_deg;
        (EnergyLimit { albedo, error_bound, divisor, theta_deg, samples }, place)
    }

    /// Returns the places of the grid with the largest albedos, largest first.
    fn best_of_grid(
        &self,
        subject: &Subject<'_>,
        axes: Axes,
        samples: &mut usize,
    ) -> Vec<Incidence> {
        let mut ranked: Vec<(Incidence, f64)> = Vec::new();
        for (places, set) in self.grid(axes) {
            *samples += places.len() * subject.samples(&self.grid_rule);
            let found = subject.albedos(places, set, &self.grid_rule);
            ranked.extend(places.iter().copied().zip(found));
        }
        // A stable sort keeps the first of equal places first.
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        ranked.into_iter().take(self.effort.starts).map(|(place, _)| place).collect()
    }

    /// Runs a pattern search from each start and returns the best place and the gain of the last
    /// step.
    fn climb(
        &self,
        subject: &Subject<'_>,
        starts: Vec<Incidence>,
        axes: Axes,
        samples: &mut usize,
    ) -> (Incidence, f64) {
        let mut measure = |places: &[Incidence]| {
            *samples += places.len() * subject.samples(&self.search_rule);
            subject.albedos_at(places, &self.search_rule)
        };
        let at_start = measure(&starts);
        let mut ranked: Vec<(Incidence, f64)> = starts.into_iter().zip(at_start).collect();
        let mut step = self.first_step();
        let mut gain = 0.0;
        for _ in 0..self.effort.halvings {
            let before = best(&ranked).1;
            let candidates: Vec<Vec<Incidence>> =
                ranked.iter().map(|(place, _)| neighbours(place, &step, axes)).collect();
            let all = candidates.concat();
            let mut found = all.iter().copied().zip(measure(&all));
            for ((place, albedo), candidates) in ranked.iter_mut().zip(&candidates) {
                for (other, value) in found.by_ref().take(candidates.len()) {
                    if value > *albedo {
                        (*place, *albedo) = (other, value);
                    }
                }
            }
            gain = best(&ranked).1 - before;
            step.theta_deg *= 0.5;
            step.turn *= 0.5;
            step.uv *= 0.5;
        }
        (best(&ranked).0, gain)
    }

    /// Measures the albedo at a place with growing orders and returns it with an error estimate.
    fn measure(&self, subject: &Subject<'_>, place: Incidence, samples: &mut usize) -> (f64, f64) {
        let mut measure = |(order, rule): (&usize, &OnceLock<Quadrature>)| {
            let rule = rule.get_or_init(|| Quadrature::new(*order));
            *samples += subject.samples(rule);
            subject.albedos_at(&[place], rule)[0]
        };
        let mut rules = ORDERS.iter().zip(&self.measuring);
        let mut albedo = rules.next().map_or(0.0, &mut measure);
        let mut changes = [0.0; 2];
        for rule in rules {
            let finer = measure(rule);
            changes = [changes[1], (finer - albedo).abs()];
            albedo = finer;
            if changes[1] <= SETTLED * albedo {
                break;
            }
        }
        // Clamps cause kinks in f, where errors do not fall evenly, so one small change is not
        // enough evidence.
        (albedo, f64::max(changes[1], 0.25 * changes[0]))
    }

    /// Returns half of the spacing of the grid.
    fn first_step(&self) -> Incidence {
        let Effort { thetas, azimuths, uv_side, .. } = self.effort;
        Incidence {
            theta_deg: 0.5 * THETA_MAX_DEG / (thetas - 1) as f64,
            turn: 0.25 / azimuths as f64,
            uv: DVec2::splat(0.5 / (uv_side - 1) as f64),
        }
    }

    /// Returns the tiles of the grid, one if the program reads no texture position.
    fn grid(&self, axes: Axes) -> impl Iterator<Item = &Tile> {
        let tiles = &self.tiles[usize::from(axes.azimuth)];
        let side = self.effort.uv_side;
        let matters = move |index: &usize| {
            (axes.u || index.is_multiple_of(side)) && (axes.v || index / side == 0)
        };
        let tile = move |index: usize| {
            tiles[index].get_or_init(|| {
                let along = |index: usize| index as f64 / (side - 1) as f64;
                let uv = DVec2::new(along(index % side), along(index / side));
                self.tile(axes.azimuth, uv)
            })
        };
        (0..side * side).filter(matters).map(tile)
    }

    /// Creates the places at one texture position and their samples.
    fn tile(&self, azimuth: bool, uv: DVec2) -> Tile {
        let Effort { thetas, azimuths, .. } = self.effort;
        let azimuths = if azimuth { azimuths } else { 1 };
        let angles = (0..thetas).map(|ring| THETA_MAX_DEG * ring as f64 / (thetas - 1) as f64);
        let turns = |theta_deg| {
            let turn = move |step| 0.5 * step as f64 / azimuths as f64;
            (0..azimuths).map(move |step| Incidence { theta_deg, turn: turn(step), uv })
        };
        let places: Vec<Incidence> = angles.flat_map(turns).collect();
        let set = subject::samples(&places, &self.grid_rule);
        (places, set)
    }
}

/// True if anything that the program reads changes when the surface turns about its normal;
/// otherwise the program is isotropic.
#[must_use]
pub fn is_anisotropic(program: &Program) -> bool {
    let inputs = program.inputs();
    AZIMUTHAL.into_iter().any(|input| inputs.contains(input))
        || program.layers().iter().any(|model| *model != model.isotropic())
}

/// Coordinates of a place that can change the result of a program.
#[derive(Debug, Clone, Copy)]
struct Axes {
    azimuth: bool,
    u: bool,
    v: bool,
}

impl Axes {
    fn of(program: &Program) -> Self {
        let inputs = program.inputs();
        let reads = |input| inputs.contains(input);
        Self { azimuth: is_anisotropic(program), u: reads(Input::U), v: reads(Input::V) }
    }
}

/// Returns the places one step away along each axis.
fn neighbours(place: &Incidence, step: &Incidence, axes: Axes) -> Vec<Incidence> {
    let mut all = Vec::new();
    for sign in [-1.0, 1.0] {
        let theta_deg = (place.theta_deg + sign * step.theta_deg).clamp(0.0, THETA_MAX_DEG);
        all.push(Incidence { theta_deg, ..*place });
        if axes.azimuth {
            all.push(Incidence { turn: place.turn + sign * step.turn, ..*place });
        }
        for (_, axis) in [(axes.u, DVec2::X), (axes.v, DVec2::Y)].into_iter().filter(|(on, _)| *on)
        {
            let uv = (place.uv + axis * step.uv * sign).clamp(DVec2::ZERO, DVec2::ONE);
            all.push(Incidence { uv, ..*place });
        }
    }
    all
}

fn best(found: &[(Incidence, f64)]) -> (Incidence, f64) {
    // The first of equal places, for any number of places.
    let best = found.iter().reduce(|best, other| if other.1 > best.1 { other } else { best });
    *best.expect("a search has at least one start")
}

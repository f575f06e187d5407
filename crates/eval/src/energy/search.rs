//! Search for the largest directional albedo of a program.

use std::sync::OnceLock;

use brood_program::Program;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::axes::{Axes, UNBOUNDED_COS};
use super::evidence::Evidence;
use super::hemisphere::Quadrature;
use super::lattice::Lattice;
use super::limit::{EnergyLimit, Incidence, tilt_of};
use super::lobe::LobeRule;
use super::scatter::Scatter;
use super::subject::{Fineness, ProgramRule, Samples, Subject, largest};

/// Tilts near the normal that are searched for programs. Within 2^-20 radians, normalised
/// tangential parts fade to 0; reciprocals and logarithms of inputs that are 0 at the normal vary
/// in equal ratios of the tilt.
const NEAR_TILTS: [f64; 6] = [2e-7, 5e-7, 8e-7, 1e-5, 4e-4, 6e-3];
/// Highest order of the measurement.
pub const ALBEDO_ORDER: usize = 128;
/// Orders of the measurement, each twice the one before; see [`rule`] for highlights.
const ORDERS: [usize; 3] = [32, 64, ALBEDO_ORDER];
/// Spacings of the nodes for layers in the measurement, each half the one before. The last two are
/// for layers alone.
const SPACINGS: [f64; 5] = [0.25, 0.125, 0.0625, 0.03125, 0.015625];
/// Order of the quadrature at scattered places, which only ranks them.
const SCATTERED_ORDER: usize = 5;
/// Relative change at which the measurement ends, from one order to twice that order.
const SETTLED: f64 = 1e-4;

/// Number of directions, positions and steps of the search before the albedo is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Number of steps of the angle from the normal to 80 degrees.
    pub steep: usize,
    /// Number of steps of the logarithm of the cosine from there to the horizon.
    pub flat: usize,
    /// Number of azimuths on the grid, over half a turn: the other half changes no input.
    pub azimuths: usize,
    /// Number of texture positions along a side of [0, 1]^2, if both are read.
    pub uv_side: usize,
    /// Order of the quadrature on the grid.
    pub grid_order: usize,
    /// Spacing of the nodes for layers on the grid.
    pub grid_spacing: f64,
    /// Number of scattered places, whose coordinates are all different: they meet ridges that are
    /// narrower than the spacing of the grid.
    pub scattered: usize,
    /// Number of places of the grid that the climb starts from.
    pub starts: usize,
    /// Number of scattered places that it starts from.
    pub scattered_starts: usize,
    /// Stages of the climb.
    pub stages: [ClimbStage; 2],
}

/// A stage of the climb: each of its steps is half as long as the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClimbStage {
    /// Order of the quadrature.
    pub order: usize,
    /// Spacing of the nodes for layers.
    pub spacing: f64,
    /// Number of places that each step starts from.
    pub climbers: [usize; 3],
}

impl Effort {
    /// Effort of the energy limit, chosen by `brood bench pareto --sweep limit`.
    pub const USUAL: Self = Self {
        steep: 16,
        flat: 10,
        azimuths: 8,
        uv_side: 5,
        grid_order: 8,
        grid_spacing: 0.5,
        scattered: 2048,
        starts: 24,
        scattered_starts: 12,
        stages: [
            ClimbStage { order: 16, spacing: 0.35, climbers: [10, 6, 4] },
            ClimbStage { order: 32, spacing: 0.25, climbers: [4, 2, 2] },
        ],
    };
}

/// The incident directions of the grid and their samples: the same for all programs.
#[derive(Debug)]
struct Tile {
    /// Tilts, ascending.
    tilts: Vec<f64>,
    azimuths: usize,
    /// By tilt, then by azimuth.
    places: Vec<Incidence>,
    samples: Samples,
}

/// Quadratures over outgoing directions.
#[derive(Debug)]
struct Rules {
    grid: ProgramRule,
    /// By [`Effort::stages`].
    climb: [ProgramRule; 2],
    /// Quadratures of the measurement, by [`ORDERS`], created at first use.
    measuring: [OnceLock<ProgramRule>; ORDERS.len()],
}

/// Search for the largest albedo, with the data that all programs share.
#[derive(Debug)]
pub struct LimitSearch {
    effort: Effort,
    /// For programs without highlights, and with.
    rules: [Rules; 2],
    /// By highlights (without, with), then by azimuths, then by programs.
    tiles: [OnceLock<Tile>; 8],
    /// By highlights, then by azimuths.
    scatters: [OnceLock<Scatter>; 4],
}

impl LimitSearch {
    /// Prepares a search.
    ///
    /// # Panics
    /// If the effort has no directions or starts.
    #[must_use]
    pub fn new(effort: Effort) -> Self {
        assert!(effort.steep > 1 && effort.uv_side > 1 && effort.starts > 0, "{effort:?}");
        Self {
            effort,
            rules: [false, true].map(|highlight| Rules {
                grid: rule(effort.grid_order, highlight),
                climb: effort.stages.map(|stage| rule(stage.order, highlight)),
                measuring: Default::default(),
            }),
            tiles: Default::default(),
            scatters: Default::default(),
        }
    }

    /// Returns the limit of a program and the place where its albedo is largest.
    #[must_use]
    pub fn run(&self, program: &Program) -> (EnergyLimit, Incidence) {
        let axes = Axes::of(program);
        let subject = Subject::new(program);
        let mut samples = 0;
        let mut starts = self.best_of_grid(&subject, axes, &mut samples);
        starts.extend(self.best_scattered(&subject, axes, &mut samples));
        let Some((place, evidence)) = self.climb(&subject, starts, axes, &mut samples) else {
            // No light is reflected from any direction of the grid.
            let place = Incidence { tilt: 0.0, turn: 0.0, uv: DVec2::ZERO };
            let none = EnergyLimit {
                albedo: 0.0,
                error_bound: 0.0,
                divisor: 1.0,
                theta_deg: 0.0,
                samples,
            };
            return (none, place);
        };
        let (albedo, change) = self.measure(&subject, place, axes, &mut samples);
        let error_bound = evidence.error_bound(change / albedo, subject.squares().is_some());
        let divisor = (albedo * (1.0 + error_bound)).max(1.0);
        let theta_deg = place.theta_deg();
        (EnergyLimit { albedo, error_bound, divisor, theta_deg, samples }, place)
    }

    /// Returns the peaks of the grid, best first: places with no larger neighbour, in the order of
    /// the albedos that parabolas through the neighbours reach between the places of the grid.
    fn best_of_grid(
        &self,
        subject: &Subject<'_>,
        axes: Axes,
        samples: &mut usize,
    ) -> Vec<(Incidence, f64)> {
        let tile = self.tile(axes);
        let (of_layers, nodes) = self.layers_on(tile, subject, axes);
        *samples += nodes;
        let (across, up) = (self.along(axes, axes.u), self.along(axes, axes.v));
        let positions: Vec<DVec2> =
            across.iter().flat_map(|u| up.iter().map(move |v| DVec2::new(*u, *v))).collect();
        let albedos = match subject.squares() {
            None => of_layers.iter().map(|layers| largest(subject.stage(*layers))).collect(),
            Some(squares) => {
                *samples += positions.len() * tile.samples.len();
                let at = |uv: &DVec2| -> Vec<f64> {
                    #[expect(clippy::cast_possible_truncation, reason = "rounded as inputs are")]
                    let squares = squares.at_texture_position(uv.x as f32, uv.y as f32);
                    let found = tile.samples.albedos(&squares);
                    let both = found.into_iter().zip(&of_layers);
                    both.map(|(squares, layers)| largest(subject.stage(squares + *layers)))
                        .collect()
                };
                positions.par_iter().map(at).collect::<Vec<_>>().concat()
            }
        };
        let rings = tile.tilts.iter().take_while(|tilt| **tilt <= axes.tilt_max).count();
        let lattice = Lattice {
            sides: [across.len(), up.len(), tile.tilts.len(), tile.azimuths],
            rings,
            albedos: &albedos,
        };
        let place = |index: usize| {
            let uv = positions[index / tile.places.len()];
            (Incidence { uv, ..tile.places[index % tile.places.len()] }, albedos[index])
        };
        let mut starts = lattice.peaks(self.effort.starts);
        if subject.squares().is_none() {
            // On the grid, the quadrature of layers is too coarse to decide between near values.
            lattice.add_largest(&mut starts, self.effort.starts);
        }
        starts.into_iter().map(place).collect()
    }

    /// Returns the scattered places where the albedo of the program without its layers is largest.
    fn best_scattered(
        &self,
        subject: &Subject<'_>,
        axes: Axes,
        samples: &mut usize,
    ) -> Vec<(Incidence, f64)> {
        let Some(squares) = subject.squares() else { return Vec::new() };
        let scatter = self.scatter(axes);
        *samples += scatter.samples();
        let mut found = scatter.albedos(subject, squares);
        found.retain(|(place, _)| place.tilt <= axes.tilt_max);
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.truncate(self.effort.scattered_starts);
        let places: Vec<Incidence> = found.into_iter().map(|(place, _)| place).collect();
        let rule = &self.rules[usize::from(axes.highlight)].grid;
        let fineness = Fineness { rule, spacing: self.effort.grid_spacing };
        let (albedos, count) = subject.albedos_at(&places, fineness);
        *samples += count;
        places.into_iter().zip(albedos.into_iter().map(largest)).collect()
    }

    /// Returns the albedos of the layers on the grid. They are the same at opposite azimuths.
    fn layers_on(&self, tile: &Tile, subject: &Subject<'_>, axes: Axes) -> (Vec<DVec3>, usize) {
        let azimuths = tile.azimuths;
        // Models are symmetric about the u axis, so half of the azimuths suffice.
        let mirrored = |index: usize| {
            let (ring, step) = (index / azimuths, index % azimuths);
            ring * azimuths + step.min((azimuths - step) % azimuths)
        };
        let wanted: Vec<usize> = (0..tile.places.len())
            .filter(|index| mirrored(*index) == *index && tile.places[*index].tilt <= axes.tilt_max)
            .collect();
        let places: Vec<Incidence> = wanted.iter().map(|index| tile.places[*index]).collect();
        let (found, samples) = subject.layers_at(&places, self.effort.grid_spacing);
        let at = |index: usize| {
            wanted.binary_search(&mirrored(index)).map_or(DVec3::ZERO, |found_at| found[found_at])
        };
        ((0..tile.places.len()).map(at).collect(), samples)
    }

    /// Runs a pattern search from each start and returns the best place, or `None` if no light is
    /// reflected at any of them.
    fn climb(
        &self,
        subject: &Subject<'_>,
        starts: Vec<(Incidence, f64)>,
        axes: Axes,
        samples: &mut usize,
    ) -> Option<(Incidence, Evidence)> {
        if starts.is_empty() {
            return None;
        }
        let mut ranked: Vec<(Incidence, f64)> = starts;
        let mut step = self.first_step(axes);
        let mut evidence = Evidence::default();
        let mut first = 0.0;
        for (index, stage) in self.effort.stages.iter().enumerate() {
            let rule = &self.rules[usize::from(axes.highlight)].climb[index];
            let fineness = Fineness { rule, spacing: stage.spacing };
            let mut measure = |places: &[Incidence]| -> Vec<f64> {
                let (albedos, count) = subject.albedos_at(places, fineness);
                *samples += count;
                albedos.into_iter().map(largest).collect()
            };
            evidence.noise[index] = remeasure(&mut ranked, &mut measure);
            if index == 0 {
                first = best(&ranked);
            }
            for climbers in stage.climbers {
                ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
                ranked.truncate(climbers);
                let before = best(&ranked);
                climb_step(&mut ranked, &step, axes, &mut measure);
                evidence.gain = best(&ranked) / before - 1.0;
                step.tilt *= 0.5;
                step.turn *= 0.5;
                step.uv *= 0.5;
            }
            ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
        }
        evidence.rise = libm::log(best(&ranked) / first).max(0.0);
        (best(&ranked) > 0.0).then(|| (ranked[0].0, evidence))
    }

    /// Measures the albedo at a place with growing orders and returns it with an error estimate.
    fn measure(
        &self,
        subject: &Subject<'_>,
        place: Incidence,
        axes: Axes,
        samples: &mut usize,
    ) -> (f64, f64) {
        let rules = &self.rules[usize::from(axes.highlight)].measuring;
        let mut albedo = 0.0;
        let mut changes = [0.0; 2];
        let is_program = subject.squares().is_some();
        let steps = if is_program { ORDERS.len() } else { SPACINGS.len() };
        for (index, spacing) in SPACINGS.into_iter().take(steps).enumerate() {
            let last = index.min(ORDERS.len() - 1);
            let rule = rules[last].get_or_init(|| rule(ORDERS[last], axes.highlight));
            let (found, count) = subject.albedos_at(&[place], Fineness { rule, spacing });
            *samples += count;
            let finer = largest(found[0]);
            if index > 0 {
                changes = [changes[1], (finer - albedo).abs()];
            }
            albedo = finer;
            if index > 0 && changes[1] <= SETTLED * albedo {
                break;
            }
        }
        // Clamps cause kinks in f, where errors do not fall evenly, so one small change is not
        // enough evidence.
        (albedo, f64::max(changes[1], 0.25 * changes[0]))
    }

    /// Returns half of the spacing of the grid.
    fn first_step(&self, axes: Axes) -> Incidence {
        let Effort { steep, azimuths, .. } = self.effort;
        let along = |on: bool| if on { 0.5 / (self.side(axes) - 1) as f64 } else { 0.0 };
        Incidence {
            tilt: 0.5 / steep as f64,
            turn: 0.25 / azimuths as f64,
            uv: DVec2::new(along(axes.u), along(axes.v)),
        }
    }

    /// Number of texture positions along an axis that is read: more if fewer axes are searched.
    fn side(&self, axes: Axes) -> usize {
        let Effort { uv_side, .. } = self.effort;
        match (axes.azimuth, axes.u && axes.v) {
            (true, true) => uv_side,
            (true, false) => 4 * uv_side,
            (false, true) => 2 * uv_side + uv_side / 2,
            (false, false) => 16 * uv_side,
        }
    }

    /// Returns the texture positions of the grid along an axis.
    fn along(&self, axes: Axes, on: bool) -> Vec<f64> {
        let side = self.side(axes);
        let count = if on { side } else { 1 };
        (0..count).map(|index| index as f64 / (side - 1) as f64).collect()
    }

    /// Returns the scattered places, between the tilts of the grid.
    fn scatter(&self, axes: Axes) -> &Scatter {
        let kind = 2 * usize::from(axes.highlight) + usize::from(axes.azimuth);
        self.scatters[kind].get_or_init(|| {
            let tilts = &self.tile(Axes { program: true, ..axes }).tilts;
            let rule = rule(SCATTERED_ORDER, axes.highlight);
            Scatter::new(self.effort.scattered, tilts, axes.azimuth, &rule)
        })
    }

    /// Returns the directions of the grid.
    fn tile(&self, axes: Axes) -> &Tile {
        let kind = [axes.highlight, axes.azimuth, axes.program];
        let kind = kind.into_iter().fold(0, |kind, on| 2 * kind + usize::from(on));
        self.tiles[kind].get_or_init(|| {
            let Effort { steep, flat, azimuths, .. } = self.effort;
            let azimuths = if axes.azimuth { azimuths } else { 1 };
            let steep = (0..=steep).map(|step| step as f64 / steep as f64);
            let flat = (1..=flat).map(|step| 1.0 + step as f64 / flat as f64);
            let mut tilts: Vec<f64> = steep.chain(flat).chain([tilt_of(UNBOUNDED_COS)]).collect();
            if axes.program {
                tilts.extend(NEAR_TILTS);
            }
            tilts.sort_by(f64::total_cmp);
            let turns = |tilt: &f64| {
                let (tilt, turn) = (*tilt, move |step| 0.5 * step as f64 / azimuths as f64);
                (0..azimuths).map(move |step| Incidence { tilt, turn: turn(step), uv: DVec2::ZERO })
            };
            let places: Vec<Incidence> = tilts.iter().flat_map(turns).collect();
            let samples = self.rules[usize::from(axes.highlight)].grid.samples(&places);
            Tile { tilts, azimuths, places, samples }
        })
    }
}

/// Largest albedo of some places.
fn best(ranked: &[(Incidence, f64)]) -> f64 {
    ranked.iter().map(|(_, albedo)| *albedo).fold(0.0, f64::max)
}

/// Measures places again and returns the largest change of the logarithm of the albedo, among those
/// with at least half of the largest albedo.
fn remeasure(
    ranked: &mut [(Incidence, f64)],
    measure: &mut impl FnMut(&[Incidence]) -> Vec<f64>,
) -> f64 {
    let places: Vec<Incidence> = ranked.iter().map(|(place, _)| *place).collect();
    let found = measure(&places);
    let before: Vec<f64> = ranked.iter().map(|(_, albedo)| *albedo).collect();
    for ((_, albedo), found) in ranked.iter_mut().zip(found) {
        *albedo = found;
    }
    let enough = 0.5 * best(ranked);
    let both = ranked.iter().map(|(_, albedo)| *albedo).zip(before);
    both.filter(|(albedo, _)| *albedo > enough)
        .map(|(albedo, before)| libm::log(albedo / before.max(f64::MIN_POSITIVE)).abs())
        .fold(0.0, f64::max)
}

/// Moves each place to the best of its neighbours and of the top of the parabolas through them, if
/// that is better.
fn climb_step(
    ranked: &mut [(Incidence, f64)],
    step: &Incidence,
    axes: Axes,
    measure: &mut impl FnMut(&[Incidence]) -> Vec<f64>,
) {
    let around: Vec<Vec<[Incidence; 2]>> =
        ranked.iter().map(|(place, _)| axes.neighbours(place, step)).collect();
    let places: Vec<Incidence> = around.iter().flatten().flatten().copied().collect();
    let found = measure(&places);
    let mut found = found.chunks_exact(2);
    let mut peaks = Vec::with_capacity(ranked.len());
    for ((place, albedo), pairs) in ranked.iter_mut().zip(&around) {
        let centre = (*place, *albedo);
        let mut peak = centre.0;
        for pair in pairs {
            let values = found.next().expect("each neighbour has been measured");
            for (other, value) in pair.iter().zip(values) {
                if *value > *albedo {
                    (*place, *albedo) = (*other, *value);
                }
            }
            peak = towards_peak(peak, &centre.0, pair, [values[0], centre.1, values[1]]);
        }
        peaks.push(axes.clamped(peak));
    }
    let values = measure(&peaks);
    for ((place, albedo), (other, value)) in ranked.iter_mut().zip(peaks.into_iter().zip(values)) {
        if value > *albedo {
            (*place, *albedo) = (other, value);
        }
    }
}

/// Moves `peak` along the axis of a pair of neighbours to the top of the parabola through the
/// albedos at the first neighbour, the centre and the second.
fn towards_peak(
    peak: Incidence,
    centre: &Incidence,
    [below, above]: &[Incidence; 2],
    [low, middle, high]: [f64; 3],
) -> Incidence {
    let log =
        |albedo: f64| libm::log((albedo / middle.max(f64::MIN_POSITIVE)).max(f64::MIN_POSITIVE));
    let (low, high) = (log(low), log(high));
    let middle = 0.0;
    let bend = low - 2.0 * middle + high;
    let share = if bend < 0.0 {
        (0.5 * (low - high) / bend).clamp(-1.0, 1.0)
    } else if high > low {
        1.0
    } else {
        -1.0
    };
    let other = if share > 0.0 { above } else { below };
    let share = share.abs();
    Incidence {
        tilt: peak.tilt + share * (other.tilt - centre.tilt),
        turn: peak.turn + share * (other.turn - centre.turn),
        uv: peak.uv + share * (other.uv - centre.uv),
    }
}

/// Returns the quadrature of an order. For highlights, it has 5/8 of the order and about as
/// many nodes.
fn rule(order: usize, highlight: bool) -> ProgramRule {
    match highlight {
        true => ProgramRule::Highlight(LobeRule::new((5 * order).div_ceil(8))),
        false => ProgramRule::Even(Quadrature::new(order)),
    }
}

/// Returns the quadrature for a program.
pub(super) fn rule_for(program: &Program, order: usize) -> ProgramRule {
    rule(order, Axes::of(program).highlight)
}

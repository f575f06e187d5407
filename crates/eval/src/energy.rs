//! The energy limit: by how much f has to be divided so that no direction reflects more than it receives.
//!
//! The largest directional albedo is found on a grid of incident directions and texture positions, then by a pattern search
//! around the best of them, then measured at growing orders until it changes little. What a program does not read is not
//! searched: an isotropic one has no azimuths, a homogeneous one no texture positions. docs/maths/energy.md.

mod hemisphere;

use std::sync::{LazyLock, OnceLock};

use brood_brdf::{Input, InputMask};
use brood_genome::Genome;
use brood_program::{Child, Program};
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::{CanonicalEvaluator, Evaluator};

pub use hemisphere::{Quadrature, around, pair};

/// Inputs that turn with the surface; without them a program is isotropic.
const AZIMUTHAL: [Input; 4] = [Input::SmoothP5, Input::SmoothP6, Input::PaperP5, Input::PaperP6];
/// Incident directions of the grid: angles from the normal ...
const THETAS: usize = 12;
/// ... up to this, the last place before grazing incidence, where the integral loses its meaning ...
const THETA_MAX_DEG: f64 = 89.5;
/// ... and azimuths over half a turn: another half changes no input.
const AZIMUTHS: usize = 6;
/// Texture positions along a side of [0, 1]^2.
const UV_SIDE: usize = 4;
/// Order of the quadrature on the grid.
const GRID_ORDER: usize = 6;
/// Starting points of the search.
const STARTS: usize = 4;
/// Halvings of the search's steps.
const HALVINGS: u32 = 6;
/// Order of the search's quadrature.
const SEARCH_ORDER: usize = 12;
/// The highest order of the measurement.
pub const ALBEDO_ORDER: usize = 128;
/// Orders of the measurement, each twice the one before.
const ORDERS: [usize; 4] = [16, 32, 64, ALBEDO_ORDER];
/// Relative error that f32 adds, of the values and of the divided output stage.
const ROUNDING: f64 = 1.0 / (1u64 << 20) as f64;
/// The measurement ends where doubling the order changed the albedo by a smaller share.
const SETTLED: f64 = 1e-4;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyLimit {
    /// The largest directional albedo of any channel.
    pub albedo: f64,
    /// Relative error bound of it, estimated.
    pub error_bound: f64,
    /// max(1, albedo (1 + error bound)): what f is divided by.
    pub divisor: f64,
    /// Where it is largest, from the normal.
    pub theta_deg: f64,
    /// Reflectances that were computed.
    pub samples: usize,
}

/// An incident direction and a texture position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    theta_deg: f64,
    turn: f64,
    /// Texture position.
    pub uv: DVec2,
}

impl Place {
    /// The incident direction.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        let (sin, cos) = libm::sincos(self.theta_deg.to_radians());
        around(sin, cos, self.turn)
    }
}

/// What a genome is seen as: its code lowered and, where it asks for that, under the energy limit.
///
/// The limit is folded into the program's output stage, so whatever evaluates, exports or compares programs has it.
#[must_use]
pub fn express(genome: &Genome) -> Program {
    let program = Program::lower(genome);
    if genome.is_limited() { limited(program) } else { program }
}

/// The children as they are seen: those that ask for the energy limit are put under it.
#[must_use]
pub fn express_brood(children: Vec<Child>) -> Vec<Child> {
    let express = |child: Child| {
        if !child.genome.is_limited() {
            return child;
        }
        let program = limited(child.program);
        Child { program_hash: program.hash(), program, ..child }
    };
    children.into_par_iter().map(express).collect()
}

/// The program under the energy limit.
#[must_use]
pub fn limited(program: Program) -> Program {
    let divisor = energy_limit(&program).divisor;
    if divisor > 1.0 { program.divided(divisor) } else { program }
}

/// The limit of a program, its output stage included. The same bits on every machine.
#[must_use]
pub fn energy_limit(program: &Program) -> EnergyLimit {
    search(program).0
}

/// The largest albedo of the channels at a place, by a quadrature of that order.
#[must_use]
pub fn directional_albedo(program: &Program, place: &Place, order: usize) -> f64 {
    let rule = Quadrature::new(order);
    measure(program, &[*place], &rule)[0]
}

/// The limit, and the place where the albedo is largest.
#[must_use]
pub fn search(program: &Program) -> (EnergyLimit, Place) {
    let axes = Axes::of(program.inputs());
    let mut samples = 0;
    let mut ranked: Vec<(Place, f64)> = Vec::new();
    for (place, set) in grid(axes) {
        samples += set.len();
        let albedos = albedos(program, set, &GRID_RULE);
        ranked.extend(place.iter().copied().zip(albedos));
    }
    // A stable sort: of equals the first one stays first.
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.truncate(STARTS);
    let starts: Vec<Place> = ranked.iter().map(|(place, _)| *place).collect();
    samples += starts.len() * SEARCH_RULE.directions().len();
    let at_start = measure(program, &starts, &SEARCH_RULE);
    let mut ranked: Vec<(Place, f64)> = starts.into_iter().zip(at_start).collect();
    let mut gain = 0.0;
    let mut step = Place {
        theta_deg: 0.5 * THETA_MAX_DEG / (THETAS - 1) as f64,
        turn: 0.25 / AZIMUTHS as f64,
        uv: DVec2::splat(0.5 / (UV_SIDE - 1) as f64),
    };
    for _ in 0..HALVINGS {
        let before = best(&ranked).1;
        let around: Vec<Vec<Place>> =
            ranked.iter().map(|(place, _)| neighbours(place, &step, axes)).collect();
        let all: Vec<Place> = around.iter().flatten().copied().collect();
        samples += all.len() * SEARCH_RULE.directions().len();
        let mut found = all.iter().copied().zip(measure(program, &all, &SEARCH_RULE));
        for ((place, albedo), around) in ranked.iter_mut().zip(&around) {
            for (other, value) in found.by_ref().take(around.len()) {
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
    let (place, _) = best(&ranked);
    let mut changes = [0.0f64; 2];
    let mut albedo: Option<f64> = None;
    for order in ORDERS {
        let rule = rule(order);
        samples += rule.directions().len();
        let finer = measure(program, &[place], rule)[0];
        if let Some(coarser) = albedo {
            changes = [changes[1], (finer - coarser).abs()];
        }
        let settled = albedo.is_some() && changes[1] <= SETTLED * finer;
        albedo = Some(finer);
        if settled {
            break;
        }
    }
    let albedo = albedo.expect("there is an order");
    // Where clamps put kinks into f, errors do not fall evenly, and one small change proves little.
    let change = changes[1].max(0.25 * changes[0]) + gain;
    let error_bound = if albedo > 0.0 { change / albedo + ROUNDING } else { 0.0 };
    let divisor = (albedo * (1.0 + error_bound)).max(1.0);
    let theta_deg = place.theta_deg;
    (EnergyLimit { albedo, error_bound, divisor, theta_deg, samples }, place)
}

/// Which coordinates of a place can matter to a program.
#[derive(Debug, Clone, Copy)]
struct Axes {
    azimuth: bool,
    u: bool,
    v: bool,
}

impl Axes {
    fn of(inputs: InputMask) -> Self {
        let reads = |input| inputs.contains(input);
        Self { azimuth: AZIMUTHAL.into_iter().any(reads), u: reads(Input::U), v: reads(Input::V) }
    }
}

static GRID_RULE: LazyLock<Quadrature> = LazyLock::new(|| Quadrature::new(GRID_ORDER));
static SEARCH_RULE: LazyLock<Quadrature> = LazyLock::new(|| Quadrature::new(SEARCH_ORDER));
static RULES: LazyLock<[Quadrature; ORDERS.len()]> = LazyLock::new(|| ORDERS.map(Quadrature::new));

/// One of [`ORDERS`].
fn rule(order: usize) -> &'static Quadrature {
    let index = ORDERS.iter().position(|known| *known == order);
    &RULES[index.expect("one of the orders that are measured")]
}

/// The places of the grid at one texture position, and their samples: the same for all programs.
type Tile = (Vec<Place>, SampleSet);

/// Tiles without azimuths, then those with; each by texture position.
static GRID: [[OnceLock<Tile>; UV_SIDE * UV_SIDE]; 2] =
    [const { [const { OnceLock::new() }; UV_SIDE * UV_SIDE] }; 2];

/// The tiles that can matter.
fn grid(axes: Axes) -> impl Iterator<Item = &'static Tile> {
    let tiles = &GRID[usize::from(axes.azimuth)];
    let matters =
        move |index: &usize| (axes.u || index % UV_SIDE == 0) && (axes.v || index / UV_SIDE == 0);
    let tile = move |index: usize| tiles[index].get_or_init(|| tile(axes.azimuth, index));
    (0..UV_SIDE * UV_SIDE).filter(matters).map(tile)
}

fn tile(azimuth: bool, index: usize) -> Tile {
    let side = |index: usize| index as f64 / (UV_SIDE - 1) as f64;
    let uv = DVec2::new(side(index % UV_SIDE), side(index / UV_SIDE));
    let azimuths = if azimuth { AZIMUTHS } else { 1 };
    let thetas = (0..THETAS).map(|ring| THETA_MAX_DEG * ring as f64 / (THETAS - 1) as f64);
    let turns = |theta_deg| {
        let turn = |step| 0.5 * step as f64 / azimuths as f64;
        (0..azimuths).map(move |step| Place { theta_deg, turn: turn(step), uv })
    };
    let places: Vec<Place> = thetas.flat_map(turns).collect();
    let set = samples(&places, &GRID_RULE);
    (places, set)
}

/// Every direction of the rule for every place.
fn samples(places: &[Place], rule: &Quadrature) -> SampleSet {
    let mut pairs = Vec::with_capacity(places.len() * rule.directions().len());
    let mut uvs = Vec::with_capacity(pairs.capacity());
    for place in places {
        let wi = place.direction();
        pairs.extend(rule.directions().iter().map(|wo| pair(wi, *wo)));
        uvs.resize(pairs.len(), place.uv);
    }
    SampleSet::from_pairs(&pairs, &uvs)
}

/// The largest albedo of the channels at each place of such samples.
fn albedos(program: &Program, set: &SampleSet, rule: &Quadrature) -> Vec<f64> {
    let mut f = Vec::new();
    CanonicalEvaluator::default()
        .eval(&[program], set, &mut f)
        .expect("the CPU runs every program");
    let count = rule.directions().len();
    let albedo = |place: usize| {
        let channel = |channel: usize| {
            let start = channel * set.len() + place * count;
            rule.integrate(f[start..start + count].iter().map(|f| f64::from(*f)))
        };
        (0..3).map(channel).fold(0.0, f64::max)
    };
    (0..set.len() / count).map(albedo).collect()
}

fn measure(program: &Program, places: &[Place], rule: &Quadrature) -> Vec<f64> {
    albedos(program, &samples(places, rule), rule)
}

fn neighbours(place: &Place, step: &Place, axes: Axes) -> Vec<Place> {
    let mut all = Vec::new();
    for sign in [-1.0, 1.0] {
        let theta_deg = (place.theta_deg + sign * step.theta_deg).clamp(0.0, THETA_MAX_DEG);
        all.push(Place { theta_deg, ..*place });
        if axes.azimuth {
            all.push(Place { turn: place.turn + sign * step.turn, ..*place });
        }
        for (_, axis) in [(axes.u, DVec2::X), (axes.v, DVec2::Y)].into_iter().filter(|(on, _)| *on)
        {
            let uv = (place.uv + axis * step.uv * sign).clamp(DVec2::ZERO, DVec2::ONE);
            all.push(Place { uv, ..*place });
        }
    }
    all
}

fn best(found: &[(Place, f64)]) -> (Place, f64) {
    // Of equals the first one, whatever the number of places.
    let best = found.iter().reduce(|best, other| if other.1 > best.1 { other } else { best });
    *best.expect("there is always a place to look at")
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn program(code: &str) -> Program {
        let text = format!("brood 1\n.dialect paper smooth registers 7\n{code}\n");
        express(&text.parse().unwrap())
    }

    fn limit_of(code: &str) -> EnergyLimit {
        energy_limit(&program(code))
    }

    #[test]
    fn constant_is_divided_by_pi_times_it() {
        let found = limit_of(".const C0 2 1 0 0\nMOV R0, C0");
        assert!((found.divisor - 4.0 * PI).abs() < 1e-4, "{found:?}");
        assert!(limit_of(".const C0 0.5 0.5 0 0\nMOV R0, C0").divisor <= 1.0);
        assert_eq!(limit_of("SUB R0, R0, R0").albedo, 0.0);
    }

    #[test]
    fn maximum_at_normal_incidence_is_found() {
        // g = cos_i + cos_o: the albedo is pi (c^2 + 4 c / 3 + 1 / 2), largest at c = 1.
        let found = limit_of("MOV R0, R0.x");
        let expected = PI * (1.0 + 4.0 / 3.0 + 0.5);
        assert!((found.albedo - expected).abs() < 1e-6 * expected, "{found:?} {expected}");
        assert!(found.divisor >= expected * (1.0 - 1e-6), "{found:?}");
        assert!(found.theta_deg < 1.0, "{found:?}");
    }

    #[test]
    fn texture_positions_are_searched_when_they_are_read() {
        let found = limit_of("MOV R0, R1.z");
        assert!((found.albedo - PI).abs() < 1e-6, "u = 1: {found:?}");
        let v = limit_of("MOV R0, R1.w");
        assert!((v.albedo - PI).abs() < 1e-6, "v = 1: {v:?}");
        assert_eq!(found.samples, v.samples);
        assert!(
            limit_of("MOV R0, R0.x").samples < found.samples,
            "what is not read is not searched"
        );
    }

    #[test]
    fn limited_program_reflects_at_most_what_it_receives() {
        let bright = ".matrix 1 0 0 0 1 0 0 0.5 1\n.scale 2 1 1\n.offset 0.1 0 0\n.const C0 3 2 1 0\nMUL R0, R0.x, C0";
        let free = limit_of(bright);
        assert!(free.albedo > 1.0);
        let held = program(&format!(".limit on\n{bright}"));
        let found = energy_limit(&held);
        assert!(found.albedo <= 1.0 && found.albedo > 0.98, "{found:?}");
        assert_ne!(held.hash(), program(bright).hash());
        let dim = ".const C0 0.1 0.1 0.1 0\nMUL R0, R0.x, C0";
        assert_eq!(program(&format!(".limit on\n{dim}")), program(dim), "nothing to take away");
    }

    #[test]
    fn limit_has_the_same_bits_on_any_number_of_threads() {
        let program =
            program(".const C0 3 2 1 0\nMUL R1, R0.xwyz, C0\nSIN R0.xy, R1.x\nADD R0, R0, R1.zwxy");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(|| search(&program)), search(&program));
    }
}

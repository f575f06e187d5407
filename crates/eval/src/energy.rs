//! The energy limit: by how much f has to be divided so that no direction reflects more than it receives.
//!
//! The largest directional albedo is found on a grid of incident directions and texture positions, then by a pattern search
//! around the best of them, then measured at growing orders until it changes little. What a program does not read is not
//! searched: an isotropic one has no azimuths, a homogeneous one no texture positions. docs/maths/energy.md.

mod hemisphere;

use std::sync::LazyLock;

use brood_brdf::{Input, InputMask};
use brood_genome::Genome;
use brood_program::Program;
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};

use crate::{CanonicalEvaluator, Evaluator};

pub use hemisphere::{Quadrature, around, pair};

/// Inputs that turn with the surface; without them a program is isotropic.
const AZIMUTHAL: [Input; 4] =
    [Input::SmoothP5, Input::SmoothP6, Input::PaperP5, Input::PaperP6];
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
/// Orders of the measurement, each twice the one before.
const ORDERS: [usize; 4] = [16, 32, 64, 128];
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
    let error_bound = if albedo > 0.0 { change / albedo } else { 0.0 };
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
        Self {
            azimuth: AZIMUTHAL.into_iter().any(reads),
            u: reads(Input::U),
            v: reads(Input::V),
        }
    }
}

static GRID_RULE: LazyLock<Quadrature> = LazyLock::new(|| Quadrature::new(GRID_ORDER));
static SEARCH_RULE: LazyLock<Quadrature> = LazyLock::new(|| Quadrature::new(SEARCH_ORDER));
static RULES: LazyLock<[Quadrature; ORDERS.len()]> =
    LazyLock::new(|| ORDERS.map(Quadrature::new));

/// One of [`ORDERS`].
fn rule(order: usize) -> &'static Quadrature {
    let index = ORDERS.iter().position(|known| *known == order);
    &RULES[index.expect("one of the orders that are measured")]
}

/// The places of the grid at one texture position, and their samples: the same for all programs.
type Tile = (Vec<Place>, SampleSet);

/// Tiles without azimuths, then those with; each by texture position.
static GRID: [[LazyLock<Tile>; UV_SIDE * UV_SIDE]; 2] = [
    [const { LazyLock::new(|| unreachable!()) }; UV_SIDE * UV_SIDE],
    [const { LazyLock::new(|| unreachable!()) }; UV_SIDE * UV_SIDE],
];

//! The energy limit: the divisor of f with which no more light from any direction is reflected than
//! arrives from it.
//!
//! The largest directional albedo is found on a grid of incident directions and texture positions,
//! then by a pattern search from the best of them, then measured with quadratures of growing order
//! until it settles. Coordinates that a program does not read are not searched: an isotropic
//! program has no azimuths, a homogeneous one no texture positions. Layers are integrated by a
//! quadrature of their own. Derivation: docs/maths/energy.md.

mod axes;
mod evidence;
mod hemisphere;
mod lattice;
mod limit;
mod lobe;
mod scatter;
mod search;
mod slope;
mod subject;
#[cfg(test)]
mod tests;

use std::sync::LazyLock;

use brood_genome::Genome;
use brood_program::{Child, Program};
use glam::DVec2;
use rayon::prelude::*;

pub use axes::{UNBOUNDED_COS, is_anisotropic};
pub use hemisphere::{Quadrature, direction_at, direction_pair};
pub use limit::{EnergyLimit, FLATTEST_COS, Incidence};
pub use lobe::LobeRule;
pub use search::{ALBEDO_ORDER, ClimbStage, Effort, LimitSearch};

use subject::{Fineness, Subject, largest};

/// Search of the energy limit; its quadratures and samples are shared by all programs.
static DEFAULT_SEARCH: LazyLock<LimitSearch> = LazyLock::new(|| LimitSearch::new(Effort::USUAL));

/// Expresses a genome: lowers its code and applies the energy limit if the genome asks for it.
///
/// The limit is folded into the output stage of the program, so everything that evaluates, exports
/// or compares programs includes it.
#[must_use]
pub fn express(genome: &Genome) -> Program {
    let program = Program::lower(genome);
    if genome.is_limited() { limited(program) } else { program }
}

/// Expresses children in parallel.
#[must_use]
pub fn express_brood(children: Vec<Child>) -> Vec<Child> {
    children.into_par_iter().map(express_child).collect()
}

/// Expresses a child: applies the energy limit if its genome asks for it.
#[must_use]
pub fn express_child(child: Child) -> Child {
    if !child.genome.is_limited() {
        return child;
    }
    let program = limited(child.program);
    Child { program_hash: program.hash(), program, ..child }
}

/// Returns the program under the energy limit. A program without a BRDF stays as it is.
#[must_use]
pub fn limited(program: Program) -> Program {
    let Some(brdf) = program.brdf() else { return program };
    let divisor = energy_limit(&brdf).divisor;
    if divisor > 1.0 { program.divided(divisor) } else { program }
}

/// Returns the limit of a program, output stage included. The same bits on every machine.
#[must_use]
pub fn energy_limit(program: &Program) -> EnergyLimit {
    DEFAULT_SEARCH.run(program).0
}

/// Returns the directional albedo at a place, the largest of the channels, by a quadrature of that
/// order.
#[must_use]
pub fn directional_albedo(program: &Program, place: &Incidence, order: usize) -> f64 {
    largest(channel_albedos_at(program, place, order))
}

/// Returns the albedo of each channel for light at that angle from the normal, along u, at texture
/// position 0.
#[must_use]
pub fn channel_albedos(program: &Program, theta_deg: f64, order: usize) -> [f64; 3] {
    channel_albedos_at(program, &Incidence::at(theta_deg, 0.0, DVec2::ZERO), order)
}

/// Returns the albedo of each channel at a place, by a quadrature of that order.
#[must_use]
pub fn channel_albedos_at(program: &Program, place: &Incidence, order: usize) -> [f64; 3] {
    // Order 32 is as fine for programs as a spacing of 0.25 is for layers.
    let rule = &search::rule_for(program, order);
    let fineness = Fineness { rule, spacing: 8.0 / order as f64 };
    Subject::new(program).albedos_at(&[*place], fineness).0[0]
}

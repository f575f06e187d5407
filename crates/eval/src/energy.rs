//! The energy limit: the divisor of f with which no more light from any direction is reflected than
//! arrives from it.
//!
//! The largest directional albedo is found on a grid of incident directions and texture positions,
//! then by a pattern search from the best of them, then measured with quadratures of growing order
//! until it settles. Coordinates that a program does not read are not searched: an isotropic
//! program has no azimuths, a homogeneous one no texture positions. Layers are integrated by a
//! quadrature of their own. Derivation: docs/maths/energy.md.

mod hemisphere;
mod limit;
mod lobe;
mod search;
mod subject;

use std::sync::LazyLock;

use brood_genome::Genome;
use brood_program::{Child, Program};
use glam::DVec2;
use rayon::prelude::*;

pub use hemisphere::{Quadrature, direction_at, direction_pair};
pub use limit::{EnergyLimit, Incidence};
pub use lobe::LobeRule;
pub use search::{ALBEDO_ORDER, Effort, LimitSearch, is_anisotropic};

use subject::Subject;

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

/// Expresses children: applies the energy limit to those that ask for it.
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

/// Returns the program under the energy limit.
#[must_use]
pub fn limited(program: Program) -> Program {
    let divisor = energy_limit(&program).divisor;
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
    Subject::new(program).albedos_at(&[*place], &Quadrature::new(order))[0]
}

/// Returns the albedo of each channel for light at that angle from the normal, along u, at texture
/// position 0.
#[must_use]
pub fn channel_albedos(program: &Program, theta_deg: f64, order: usize) -> [f64; 3] {
    let place = Incidence { theta_deg, turn: 0.0, uv: DVec2::ZERO };
    Subject::new(program).channels_at(&[place], &Quadrature::new(order))[0]
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
    fn constant_is_divided_by_pi_times_itself() {
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
            "coordinates that are not read are not searched"
        );
    }

    #[test]
    fn limited_program_reflects_at_most_what_it_receives() {
        let bright = ".matrix 1 0 0 0 1 0 0 0.5 1\n.scale 2 1 1\n.offset 0.1 0 0\n.const C0 3 2 1 0\nMUL R0, R0.x, C0";
        let free = limit_of(bright);
        assert!(free.albedo > 1.0);
        let limited = program(&format!(".limit on\n{bright}"));
        let found = energy_limit(&limited);
        assert!(found.albedo <= 1.0 && found.albedo > 0.98, "{found:?}");
        assert_ne!(limited.hash(), program(bright).hash());
        let dim = ".const C0 0.1 0.1 0.1 0\nMUL R0, R0.x, C0";
        assert_eq!(
            program(&format!(".limit on\n{dim}")),
            program(dim),
            "a dim program is not divided"
        );
    }

    #[test]
    fn limit_has_the_same_bits_on_any_number_of_threads() {
        let program =
            program(".const C0 3 2 1 0\nMUL R1, R0.xwyz, C0\nSIN R0.xy, R1.x\nADD R0, R0, R1.zwxy");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(|| DEFAULT_SEARCH.run(&program)), DEFAULT_SEARCH.run(&program));
    }
}

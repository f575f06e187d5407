//! Tests of the energy limit: known maxima, and bounds against quadratures of their own.

use std::f64::consts::{PI, TAU};

use brood_brdf::{Brdf, DirectionPair, Parametrisation};
use brood_genome::{BirthKey, Dialect, Model, ModelKind, OpcodeSet, Operator, Stream, Variation};
use glam::DVec3;
use proptest::prelude::*;

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
    assert_eq!(program(&format!(".limit on\n{dim}")), program(dim), "a dim program is not divided");
}

#[test]
fn limit_has_the_same_bits_on_any_number_of_threads() {
    let program =
        program(".const C0 3 2 1 0\nMUL R1, R0.xwyz, C0\nSIN R0.xy, R1.x\nADD R0, R0, R1.zwxy");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| DEFAULT_SEARCH.run(&program)), DEFAULT_SEARCH.run(&program));
}

/// Albedo of a model by the midpoint rule over half vectors of slopes r (alpha_x cos, alpha_y sin),
/// in equal ratios of r: nothing of it is shared with the search.
fn midpoint_albedo(model: &Model, wi: DVec3, alpha: DVec2, side: u32) -> f64 {
    let brdf = model.prepare();
    let (low, high) = (libm::log(1e-5), libm::log(1e4 / alpha.max_element()));
    let step = (high - low) / f64::from(side) * TAU / f64::from(side);
    let mut sum = DVec3::ZERO;
    for ring in 0..side {
        let r = libm::exp(low + (high - low) * (f64::from(ring) + 0.5) / f64::from(side));
        for turn in 0..side {
            let (sin, cos) = libm::sincos(TAU * (f64::from(turn) + 0.5) / f64::from(side));
            let slope = r * alpha * DVec2::new(cos, sin);
            let length = (1.0 + slope.length_squared()).sqrt();
            let half = slope.extend(1.0) / length;
            let cos_d = wi.dot(half);
            let wo = 2.0 * cos_d * half - wi;
            if cos_d <= 0.0 || wo.z <= 0.0 {
                continue;
            }
            let area = alpha.x * alpha.y * r * r * step / length.powi(3);
            let pair = DirectionPair::new(wi, wo).unwrap();
            let f = brdf.f(&pair).clamp(DVec3::ZERO, DVec3::splat(65504.0 * 65504.0));
            sum += f * (4.0 * cos_d * wo.z * area);
        }
    }
    sum.max_element()
}

fn direction(theta_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    direction_at(sin, cos, azimuth_deg / 360.0)
}

fn limit_of_model(model: &Model) -> EnergyLimit {
    energy_limit(&Program::lower(&Genome::of_models(vec![model.clone()]).unwrap()))
}

#[test]
fn strongly_anisotropic_highlight_is_bounded_at_the_horizon() {
    let text = "brood 1\n.model ward\ndiffuse 0.4 0.4 0.4\nspecular 0.9 0.9 0.9\n\
                alpha_x 0.02\nalpha_y 0.8\nform bounded\n";
    let model = text.parse::<Genome>().unwrap().layers()[0].clone();
    let limit = limit_of_model(&model);
    let albedo = midpoint_albedo(&model, direction(89.8, 90.0), DVec2::new(0.02, 0.8), 900);
    assert!(albedo > 1.2, "{albedo}");
    assert!(albedo / limit.divisor <= 1.001, "{albedo} {limit:?}");
    let program = Program::lower(&Genome::of_models(vec![model]).unwrap());
    let found = directional_albedo(&program, &Incidence::at(89.8, 0.25, DVec2::ZERO), 64);
    assert!((found / albedo - 1.0).abs() < 2e-3, "{found} {albedo}");
}

#[test]
fn grazing_peak_of_grooves_is_bounded() {
    let text = "brood 1\n.model cook-torrance\ndiffuse 0.66 0.66 0.66\nf0 0.79 0.79 0.79\n\
                roughness 0.275\ndistribution gaussian\nshadowing v-groove\n";
    let model = text.parse::<Genome>().unwrap().layers()[0].clone();
    let limit = limit_of_model(&model);
    for theta_deg in [60.0, 80.0, 85.0, 88.0, 89.0, 89.5, 89.9, 89.99] {
        let wi = direction(theta_deg, 0.0);
        let albedo = midpoint_albedo(&model, wi, DVec2::splat(0.275), 500);
        assert!(albedo / limit.divisor <= 1.001, "{theta_deg}: {albedo} {limit:?}");
    }
    let near = midpoint_albedo(&model, direction(limit.theta_deg, 0.0), DVec2::splat(0.275), 700);
    assert!((near / limit.albedo - 1.0).abs() < 2e-3, "{near} {limit:?}");
}

#[test]
fn slopes_of_any_width_agree_with_closed_forms() {
    for theta_deg in [0.0, 30.0, 80.0, 89.0, 89.99, 89.9999] {
        let model = Model::new(ModelKind::Lambert).with("albedo", &[0.5; 3]).unwrap();
        let program = Program::lower(&Genome::of_models(vec![model]).unwrap());
        let albedo = directional_albedo(&program, &Incidence::at(theta_deg, 0.1, DVec2::ZERO), 64);
        assert!((albedo - 0.5).abs() < 1e-5, "lambert at {theta_deg}: {albedo}");
    }
    // A white mirror reflects everything that its facets do not hide.
    for roughness in [0.02, 1e-3, 1e-4] {
        let model = Model::new(ModelKind::CookTorrance)
            .with("f0", &[1.0; 3])
            .and_then(|model| model.with("roughness", &[roughness]))
            .unwrap();
        let program = Program::lower(&Genome::of_models(vec![model]).unwrap());
        let albedo = directional_albedo(&program, &Incidence::at(37.0, 0.1, DVec2::ZERO), 64);
        assert!((0.999..1.0001).contains(&albedo), "{roughness}: {albedo}");
    }
}

#[test]
fn unbounded_layers_are_limited_down_to_their_horizon() {
    for kind in [ModelKind::Phong, ModelKind::BlinnPhong, ModelKind::Sgd] {
        assert!(!Model::new(kind).is_bounded_at_horizon());
        let limit = limit_of_model(&Model::new(kind));
        assert!(libm::cos(limit.theta_deg.to_radians()) > 0.99 * UNBOUNDED_COS, "{limit:?}");
    }
    let limit = limit_of_model(&Model::new(ModelKind::BlinnPhong));
    assert!((limit.theta_deg - libm::acos(UNBOUNDED_COS).to_degrees()).abs() < 1e-3, "{limit:?}");
}

#[test]
fn black_programs_are_not_divided() {
    let limit = limit_of("SUB R0, R0, R0");
    assert_eq!((limit.albedo, limit.divisor), (0.0, 1.0));
}

/// A model with random values over the whole ranges of its parameters.
fn random_model(kind: ModelKind, seed: u64) -> Model {
    let mut stream = Stream::new(BirthKey { seed, slot: 0, attempt: 0 }, Operator::RandomLayers);
    kind.parameters().iter().fold(Model::new(kind), |model, parameter| {
        let mut value = || match parameter.words() {
            Some(words) => f64::from(stream.below(words.len() as u32)),
            None => parameter.at_share(1.2 * f64::from(stream.unit()) - 0.1),
        };
        let values: Vec<f64> = (0..parameter.count()).map(|_| value()).collect();
        model.with(parameter.name, &values).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn bound_of_a_random_model_holds_in_random_directions(
        kind in 0..ModelKind::ALL.len(),
        seed: u64,
        tilt in 0.0..1.6,
        turn in 0.0..0.5,
    ) {
        let model = random_model(ModelKind::ALL[kind], seed);
        let place = Incidence { tilt, turn, uv: DVec2::ZERO };
        let width = slope::highlight_width(&model);
        let albedo = midpoint_albedo(&model, place.direction(), width.max(DVec2::splat(1e-6)), 120);
        let bound = limit_of_model(&model).bound();
        // The midpoint rule has 1e-2 at horizons that cut narrow highlights.
        prop_assert!(albedo <= bound * 1.02 + 1e-9, "{model:?} {place:?}: {albedo} > {bound}");
    }

    #[test]
    fn bound_of_a_random_program_holds_in_random_directions(
        seed: u64,
        extended: bool,
        paper: bool,
        tilt in 0.0..2.0,
        (turn, u, v) in (0.0..0.5, 0.0..1.0, 0.0..1.0),
    ) {
        let (opcodes, registers) = match extended {
            true => (OpcodeSet::Extended, 10),
            false => (OpcodeSet::Paper, 7),
        };
        let parametrisation = if paper { Parametrisation::Paper } else { Parametrisation::Smooth };
        let dialect = Dialect { opcodes, registers, parametrisation, ..Dialect::default() };
        let key = BirthKey { seed, slot: 0, attempt: 0 };
        let program = Program::lower(&Variation::random(dialect).birth(key));
        let place = Incidence { tilt, turn, uv: DVec2::new(u, v) };
        let albedo = directional_albedo(&program, &place, 100);
        let bound = energy_limit(&program).bound();
        prop_assert!(albedo <= bound * 1.001, "{program:?} {place:?}: {albedo} > {bound}");
    }
}

#[test]
fn limits_of_many_programs_are_found_in_parallel() {
    let random = Variation::random(Dialect::default());
    let programs: Vec<Program> = (0..48)
        .map(|slot| {
            let key = BirthKey { seed: 3, slot, attempt: 0 };
            Program::lower(&random.birth(key))
        })
        .collect();
    let found: Vec<EnergyLimit> = programs.par_iter().map(energy_limit).collect();
    assert!(found.iter().all(|limit| limit.divisor >= 1.0));
}

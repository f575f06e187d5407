//! Physics of the models: exact reciprocity, finite and non-negative values at the corners, energy
//! conservation.

use std::f64::consts::PI;

use glam::DVec3;

use super::microfacet::{DISTRIBUTIONS, Distribution};
use super::*;
use crate::block::Half;
use crate::{Block, Branchless, Brdf, DirectionPair, HORIZON, Libm, Plain};

/// Deterministic random numbers in [0, 1): SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / 4_294_967_296.0
    }

    /// A model with random values, one in eight of them at an end of its range.
    fn model(&mut self, kind: ModelKind) -> Model {
        let mut model = Model::new(kind);
        for parameter in kind.parameters() {
            let (low, high) = parameter.range;
            let values: Vec<f64> = (0..parameter.count())
                .map(|_| match (self.next(), parameter.kind, parameter.scale) {
                    (_, ParameterKind::Choice { .. }, _) => (self.next() * (high + 1.0)).floor(),
                    (end, ..) if end < 0.0625 => low,
                    (end, ..) if end < 0.125 => high,
                    (_, _, ParameterScale::Linear) => low + (high - low) * self.next(),
                    (_, _, ParameterScale::Logarithmic) => {
                        (low * (high / low).powf(self.next())).clamp(low, high)
                    }
                })
                .collect();
            model = model.with(parameter.name, &values).unwrap();
        }
        model
    }

    /// A random direction above the surface, often at a grazing angle.
    fn direction(&mut self) -> DVec3 {
        let z = match self.next() {
            choice if choice < 0.1 => 1e-9 + 1e-6 * self.next(),
            choice if choice < 0.2 => 1.0 - 1e-7 * self.next(),
            _ => self.next().max(1e-9),
        };
        let (phi, r) = (2.0 * PI * self.next(), (1.0 - z * z).max(0.0).sqrt());
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }

    /// A random pair; some are equal, mirrored, or nearly opposite at the horizon.
    fn pair(&mut self) -> DirectionPair {
        let wi = self.direction();
        let wo = match self.next() {
            choice if choice < 0.1 => wi,
            choice if choice < 0.3 => {
                (DVec3::new(-wi.x, -wi.y, wi.z) + 1e-5 * self.direction()).normalize()
            }
            _ => self.direction(),
        };
        DirectionPair::new(wi, wo).unwrap()
    }
}

fn case(model: &Model, pair: &DirectionPair) -> String {
    format!("{model}wi {:?} wo {:?}", pair.wi(), pair.wo())
}

/// Number of models to test: a tenth for rough plastic, which prepares tables in milliseconds each.
fn tried(kind: ModelKind, count: u32) -> u32 {
    if kind == ModelKind::RoughPlastic { count / 10 } else { count }
}

/// Returns f with branch-free functions in a block of one lane.
fn branchless(model: &PreparedModel, pair: &DirectionPair) -> DVec3 {
    let machine = Plain::<Branchless>::new();
    let mut block = Block::<1>::new();
    block.fill(machine, std::slice::from_ref(pair));
    DVec3::from(model.f_block(machine, &block).map(|[value]| value))
}

fn bits(f: DVec3) -> [u64; 3] {
    f.to_array().map(f64::to_bits)
}

#[test]
fn lanes_have_the_bits_of_single_pairs_at_any_position() {
    const LANES: usize = 16;
    let mut random = Random(6);
    for kind in ModelKind::ALL {
        for length in [0, 1, 5, LANES, LANES + 3] {
            let model = random.model(kind).prepare();
            let mut pairs: Vec<DirectionPair> = (0..length).map(|_| random.pair()).collect();
            if let Some(pair) = pairs.get_mut(2) {
                *pair = DirectionPair::new(pair.wi(), -pair.wo()).unwrap();
            }
            let mut block = Block::<LANES>::new();
            // Previous contents of the block must have no effect.
            block.fill(Plain::<Libm>::new(), &[random.pair(); LANES]);
            block.fill(Plain::<Libm>::new(), &pairs);
            let exact = model.f_block(Plain::<Libm>::new(), &block);
            let fast = model.f_block(Plain::<Branchless>::new(), &block);
            for k in 0..LANES {
                let lane = |values: &[[f64; LANES]; 3]| DVec3::from(values.map(|row| row[k]));
                let (exact, fast) = (lane(&exact), lane(&fast));
                let Some(pair) = pairs.get(k) else {
                    assert_eq!((exact, fast), (DVec3::ZERO, DVec3::ZERO), "{kind} {k}");
                    continue;
                };
                assert_eq!(bits(exact), bits(model.f(pair)), "{kind} {k} {pair:?}");
                assert_eq!(bits(fast), bits(branchless(&model, pair)), "{kind} {k} {pair:?}");
            }
        }
    }
}

#[test]
fn branchless_values_match_the_reference_to_twelve_digits() {
    let mut random = Random(7);
    let mut worst_of_all: f64 = 0.0;
    for kind in ModelKind::ALL {
        let mut worst: f64 = 0.0;
        for _ in 0..tried(kind, 400) {
            let model = random.model(kind);
            let prepared = model.prepare();
            for _ in 0..50 {
                let pair = random.pair();
                let (exact, fast) = (prepared.f(&pair), branchless(&prepared, &pair));
                for (exact, fast) in exact.to_array().into_iter().zip(fast.to_array()) {
                    // 1e-60 is far below the least positive f32.
                    let off = (fast - exact).abs() / exact.abs().max(1e-60);
                    assert!(off < 4e-13, "{exact} {fast} {}", case(&model, &pair));
                    worst = worst.max(off);
                }
            }
        }
        println!("{kind}: {worst:.1e}");
        worst_of_all = worst_of_all.max(worst);
    }
    assert!(worst_of_all > 1e-15, "both paths evaluated the same functions");
}

#[test]
fn models_are_finite_and_not_negative_at_all_corners() {
    let mut random = Random(1);
    for kind in ModelKind::ALL {
        for _ in 0..tried(kind, 400) {
            let model = random.model(kind);
            let prepared = model.prepare();
            for _ in 0..50 {
                let pair = random.pair();
                for f in [prepared.f(&pair), branchless(&prepared, &pair)] {
                    assert!(f.is_finite(), "{f} {}", case(&model, &pair));
                    // The published fits of SGD are negative in places; the
                    // model keeps that.
                    assert!(
                        f.min_element() >= 0.0 || kind == ModelKind::Sgd,
                        "{f} {}",
                        case(&model, &pair)
                    );
                }
            }
        }
    }
}

#[test]
fn models_are_reciprocal_to_the_bit_exactly_where_they_claim_to_be() {
    let mut random = Random(2);
    for kind in ModelKind::ALL {
        let mut differing = 0;
        let mut claimed = true;
        for _ in 0..tried(kind, 200) {
            let model = random.model(kind);
            let brdf = model.prepare();
            claimed &= brdf.claims().reciprocal;
            for _ in 0..20 {
                let pair = random.pair();
                let back = pair.swapped();
                let exact = (brdf.f(&pair), brdf.f(&back));
                let fast = (branchless(&brdf, &pair), branchless(&brdf, &back));
                for (one, other) in [exact, fast] {
                    let same = bits(one) == bits(other);
                    differing += usize::from(!same);
                    let kept = same || !brdf.claims().reciprocal;
                    assert!(kept, "{one} {other} {}", case(&model, &pair));
                }
            }
        }
        assert!(claimed || differing > 1000, "{kind} is reciprocal but does not claim it");
    }
}

#[test]
fn values_are_finite_down_to_the_horizon() {
    let mut random = Random(8);
    let above = |x: f64, y: f64, z: f64| DirectionPair::new(DVec3::Z, DVec3::new(x, y, z)).unwrap();
    let low = [HORIZON, 1e-60, 1e-20].map(|z| above(1.0, 0.0, z).wo());
    for kind in ModelKind::ALL {
        for _ in 0..tried(kind, 100) {
            let model = random.model(kind);
            let prepared = model.prepare();
            for wi in low.into_iter().chain([DVec3::Z]) {
                for wo in low.iter().flat_map(|wo| [*wo, DVec3::new(-wo.x, 0.0, wo.z)]) {
                    let pair = DirectionPair::new(wi, wo).unwrap();
                    for f in [prepared.f(&pair), branchless(&prepared, &pair)] {
                        assert!(f.is_finite(), "{f} {}", case(&model, &pair));
                    }
                }
            }
        }
    }
}

#[test]
fn nothing_is_reflected_below_the_surface() {
    for kind in ModelKind::ALL {
        let brdf = Model::new(kind).prepare();
        let horizon = DVec3::new(1.0, 0.0, 0.5 * HORIZON);
        for wo in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.6, 0.0, -0.8), horizon] {
            let pair = DirectionPair::new(DVec3::Z, wo).unwrap();
            for pair in [pair, pair.swapped()] {
                assert_eq!(brdf.f(&pair), DVec3::ZERO, "{kind}");
                assert_eq!(branchless(&brdf, &pair), DVec3::ZERO, "{kind}");
            }
        }
    }
}

/// Integrates over the hemisphere by the midpoint rule in theta and phi.
fn over_hemisphere(steps: u32, value: impl Fn(DVec3) -> DVec3) -> DVec3 {
    let share = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
    let mut sum = DVec3::ZERO;
    for row in 0..steps {
        let (sine, cosine) = (0.5 * PI * share(row)).sin_cos();
        for column in 0..2 * steps {
            let phi = PI * share(column);
            sum += sine * value(DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine));
        }
    }
    sum * 0.5 * PI * PI / f64::from(steps * steps)
}

/// Directional albedo of the brightest channel.
fn albedo(brdf: &dyn Brdf, cos_i: f64, steps: u32) -> f64 {
    let wi = DVec3::new((1.0 - cos_i * cos_i).sqrt(), 0.0, cos_i);
    let reflected = |wo: DVec3| brdf.f(&DirectionPair::new(wi, wo).unwrap()) * wo.z;
    over_hemisphere(steps, reflected).max_element()
}

#[test]
fn albedo_is_at_most_one_where_models_claim_to_conserve_energy() {
    let mut random = Random(3);
    let mut checked = 0;
    for kind in ModelKind::ALL {
        for _ in 0..24 {
            let mut model = random.model(kind);
            // Widens highlights that are too narrow for this quadrature.
            for (name, least) in [("roughness", 0.25), ("alpha_x", 0.25), ("alpha_y", 0.25)] {
                if let Some([value]) = model.get(name).map(<[f64]>::to_vec).as_deref() {
                    model = model.with(name, &[value.max(least)]).unwrap();
                }
            }
            for (name, most) in [("exponent", 40.0), ("exponent_u", 40.0), ("exponent_v", 40.0)] {
                if let Some([value]) = model.get(name).map(<[f64]>::to_vec).as_deref() {
                    model = model.with(name, &[value.min(most)]).unwrap();
                }
            }
            if model.get("stretch").is_some() {
                model = model.with("stretch", &[0.5]).unwrap();
            }
            let brdf = model.brdf();
            if !brdf.claims().conserving {
                continue;
            }
            for cos_i in [1.0, 0.7, 0.2, 0.02] {
                let albedo = albedo(&*brdf, cos_i, 96);
                assert!(albedo <= 1.002, "{albedo} at {cos_i}: {model}");
                checked += 1;
            }
        }
    }
    assert!(checked > 300, "{checked}");
}

#[test]
fn models_without_the_claim_reflect_more_than_they_receive_somewhere() {
    let white = |kind, name: &str| Model::new(kind).with(name, &[1.0; 3]).unwrap();
    let phong = white(ModelKind::Phong, "specular").with("exponent", &[2.0]).unwrap();
    assert!(albedo(&*phong.brdf(), 0.05, 128) > 1.0);
    let duer = white(ModelKind::Ward, "specular").choose("form", "duer").unwrap();
    assert!(albedo(&*duer.brdf(), 0.02, 128) > 1.0);
    let rough = white(ModelKind::OrenNayar, "albedo").with("sigma", &[0.2]).unwrap();
    assert!(albedo(&*rough.brdf(), 0.02, 128) > 1.005);
    let grooved = white(ModelKind::CookTorrance, "f0").with("diffuse", &[1.0; 3]).unwrap();
    assert!(albedo(&*grooved.brdf(), 0.7, 128) > 1.5);
}

#[test]
fn facet_distributions_are_normalised() {
    for name in DISTRIBUTIONS {
        for alpha in [0.15, 0.4, 0.9] {
            let distribution = Distribution::named(name, glam::DVec2::new(alpha, 1.3 * alpha));
            let area = over_hemisphere(300, |h| {
                let half = Half { h, ..Half::of(DVec3::Z, DVec3::Z) };
                DVec3::splat(distribution.d::<Libm>(&half) * h.z)
            });
            let area = area.x;
            assert!((area - 1.0).abs() < 2e-3, "{name} {alpha}: {area}");
        }
    }
}

#[test]
fn cook_torrance_conserves_energy_with_a_quarter_and_not_with_one_over_pi() {
    let white = Model::new(ModelKind::CookTorrance)
        .with("f0", &[1.0; 3])
        .and_then(|model| model.with("roughness", &[0.3]))
        .and_then(|model| model.choose("distribution", "beckmann"))
        .and_then(|model| model.choose("shadowing", "v-groove"))
        .unwrap();
    let quarter = albedo(&*white.brdf(), 1.0, 256);
    assert!((0.95..1.0).contains(&quarter), "{quarter}");
    assert!((1.2..1.28).contains(&(quarter * 4.0 / PI)), "{quarter}");
}

/// Parses the text form that [`Model`] writes.
fn read(text: &str) -> Model {
    let mut lines = text.lines();
    let kind = lines.next().unwrap().strip_prefix(".model ").unwrap().parse().unwrap();
    lines.fold(Model::new(kind), |model, line| {
        let (name, values) = line.split_once(' ').unwrap();
        model.with_text(name, values).unwrap()
    })
}

#[test]
fn texts_and_values_round_trip_to_the_bit() {
    let mut random = Random(4);
    for kind in ModelKind::ALL {
        assert_eq!(kind.name().parse(), Ok(kind));
        assert_eq!(ModelKind::from_number(kind.number()), Some(kind));
        for _ in 0..20 {
            let model = random.model(kind);
            assert_eq!(read(&model.to_string()), model);
            assert_eq!(
                Model::from_parameter_values(kind, model.parameter_values()),
                Ok(model.clone())
            );
            let all: Vec<f64> =
                model.parameters().flat_map(|(_, values)| values).copied().collect();
            assert_eq!(all, model.parameter_values());
        }
        assert!(Model::from_parameter_values(kind, &[]).is_err());
    }
    assert_eq!(ModelKind::from_number(15), None);
}

#[test]
fn invalid_texts_are_rejected_with_the_valid_choices() {
    let error = "gold".parse::<ModelKind>().unwrap_err().to_string();
    assert!(error.starts_with("unknown model \"gold\"; known models: lambert,"), "{error}");
    let metal = || Model::new(ModelKind::CookTorrance);
    let error = |name: &str, values: &str| metal().with_text(name, values).unwrap_err().to_string();
    assert_eq!(
        error("f1", "1"),
        "cook-torrance has no parameter f1; it has diffuse, f0, roughness, stretch, distribution, shadowing"
    );
    assert_eq!(error("f0", "1"), "f0 takes three values, not 1");
    assert_eq!(error("roughness", "2"), "roughness must be between 0.0001 and 1, got 2");
    assert_eq!(error("roughness", "nan"), "roughness must be between 0.0001 and 1, got NaN");
    assert_eq!(error("roughness", "x"), "\"x\" is not a number");
    assert_eq!(
        error("distribution", "phong"),
        "distribution must be one of ggx, beckmann, gaussian, blinn-phong, got phong"
    );
    assert_eq!(error("distribution", ""), "distribution takes one word, not 0");
}

#[test]
fn share_and_at_share_are_inverses() {
    for parameter in ModelKind::ALL.into_iter().flat_map(ModelKind::parameters) {
        let (low, high) = parameter.range;
        for share in [0.0, 0.25, 0.5, 1.0] {
            let value = parameter.at_share(share);
            assert!((low..=high).contains(&value), "{parameter:?}");
            assert!((parameter.share(value) - share).abs() < 1e-12, "{parameter:?}");
        }
        assert_eq!((parameter.at_share(-1.0), parameter.at_share(2.0)), (low, high));
    }
}

#[test]
fn isotropic_models_are_unchanged_by_turns_about_the_normal() {
    let mut random = Random(9);
    for kind in ModelKind::ALL {
        let brdf = random.model(kind).isotropic().brdf();
        for _ in 0..50 {
            let pair = random.pair();
            let turn = glam::DQuat::from_rotation_z(1.0);
            let turned = DirectionPair::new(turn * pair.wi(), turn * pair.wo()).unwrap();
            let (a, b) = (brdf.f(&pair), brdf.f(&turned));
            assert!(
                (a - b).abs().max_element() <= 1e-6 * (1e-3 + a.max_element()),
                "{kind} {a} {b}"
            );
        }
    }
}

//! Inputs of programs.
//!
//! The inputs of BRDFs are scalars of a direction pair that do not change when the two directions
//! are swapped. Painted materials also read quantities of a surface point and its lights.
//!
//! Every input is a pure f64 function. Sample sets store it rounded to f32 once, so that all
//! evaluators read the same bits. An [`InputMask`] lists the inputs that a program reads; only
//! these are computed.

mod catalogue;
mod mask;

use glam::{DVec2, DVec3};

use crate::DirectionPair;
pub use catalogue::{Input, LightInput, Lighting, Parametrisation};
pub use mask::InputMask;

/// Lower bound of the arguments of logarithms; bounds every input over the closed hemisphere.
const LOG_FLOOR: f64 = 1.0 / (1u64 << 20) as f64;
/// Lower bound of squared lengths of tangential parts as divisors. The paper's parametrisation
/// fades to 0 at the poles.
const POLE_FLOOR: f64 = 1.0 / (1u64 << 40) as f64;
/// Largest magnitude of any number in a program: the range of the half-float registers of the
/// paper's hardware.
const RANGE: f64 = 65504.0;

impl Input {
    /// Returns the value for a pair of directions at texture position `uv`. For inputs of painted
    /// materials, the pair is a point at depth 0 that one white light at wi reaches, gradients are
    /// 0, and mirrored and refracted rays see nothing.
    ///
    /// # Domain
    /// Any direction pair and any finite `uv`; the result is finite and within [-65504, 65504].
    ///
    /// # Error
    /// Inputs of BRDFs are exactly symmetric: `evaluate(pair) == evaluate(pair.swapped())` bit for
    /// bit (`input_is_bit_equal_when_directions_are_swapped`).
    #[must_use]
    pub fn evaluate(self, pair: &DirectionPair, uv: DVec2) -> f64 {
        let (cos_i, cos_o) = (pair.cos_i(), pair.cos_o());
        let value = match self {
            Self::P1 => cos_o + cos_i,
            Self::U => uv.x,
            Self::V => uv.y,
            Self::SmoothP3 => azimuth(pair, Parametrisation::Smooth).p3,
            Self::SmoothP5 => azimuth(pair, Parametrisation::Smooth).p5,
            Self::SmoothP6 => azimuth(pair, Parametrisation::Smooth).p6,
            Self::SmoothQ1 => azimuth(pair, Parametrisation::Smooth).q1(cos_o - cos_i),
            Self::SmoothQ2 => azimuth(pair, Parametrisation::Smooth).q2(cos_o - cos_i),
            Self::PaperP3 => azimuth(pair, Parametrisation::Paper).p3,
            Self::PaperP5 => azimuth(pair, Parametrisation::Paper).p5,
            Self::PaperP6 => azimuth(pair, Parametrisation::Paper).p6,
            Self::PaperQ1 => azimuth(pair, Parametrisation::Paper).q1(cos_o - cos_i),
            Self::PaperQ2 => azimuth(pair, Parametrisation::Paper).q2(cos_o - cos_i),
            Self::LogTanHalf => {
                let s = half_sum(pair);
                let tan_squared = s.truncate().length_squared() / (s.z * s.z).max(POLE_FLOOR);
                0.5 * libm::log(tan_squared + 1e-7)
            }
            Self::HalfDotLight => half_dot_light(pair),
            Self::CosineDifference => {
                let difference = cos_o - cos_i;
                difference * difference / (4.0 * sin_squared_half(pair) + 1e-3)
            }
            Self::MirrorAsymmetry => {
                let q2 = azimuth(pair, Parametrisation::Smooth).q2(cos_o - cos_i);
                q2 / (sin_squared_half(pair) + 1e-3)
            }
            Self::CosineProduct => cos_i * cos_o,
            Self::LogHalfDotLight => libm::log(half_dot_light(pair).max(LOG_FLOOR)),
            Self::LogHalfAngle => 0.5 * libm::log((1.0 - half_dot_light(pair)).max(0.0) + 0.002),
            Self::LogCosineProduct => libm::log((cos_i * cos_o).max(LOG_FLOOR)),
            Self::LogCosineSum => libm::log((cos_i + cos_o).max(LOG_FLOOR)),
            Self::NormalDotHalf => {
                let s = half_sum(pair);
                s.z / s.length_squared().max(POLE_FLOOR).sqrt()
            }
            Self::NormalDotEye => cos_o,
            Self::Depth | Self::NormalDotEyeStep | Self::DepthStep => 0.0,
            Self::Way0Length | Self::Way1Length => RANGE,
            Self::Way0Share => 1.0,
            _ if Self::of_glass().any(|input| input == self) || self.is_of_image() => 0.0,
            Self::P2 => cos_o - cos_i,
            Self::SmoothP4 => azimuth(pair, Parametrisation::Smooth).p4,
            // Not known of a pair: sets of points have them as columns.
            Self::ReflectedLevel | Self::ReflectedStep => 0.0,
            Self::ReflectedRed | Self::ReflectedGreen | Self::ReflectedBlue => 0.0,
            _ => self.of_one_light(pair),
        };
        // Adding +0 turns -0 into +0: swapping directions could otherwise change the sign
        // of a zero.
        value.clamp(-RANGE, RANGE) + 0.0
    }

    /// Value of an input of lights where one white light at wi reaches the point.
    fn of_one_light(self, pair: &DirectionPair) -> f64 {
        let (light, quantity) = self.light().expect("the other inputs are functions of the pair");
        match quantity {
            LightInput::Visibility => 1.0,
            LightInput::CosStep | LightInput::MirrorStep => 0.0,
            _ if light > 0 => 0.0,
            LightInput::Cos => pair.cos_i(),
            LightInput::Mirror => mirror_cosine(pair),
            LightInput::Level | LightInput::Red | LightInput::Green | LightInput::Blue => 1.0,
        }
    }
}

/// r . wi, where r is wo mirrored at the normal.
fn mirror_cosine(pair: &DirectionPair) -> f64 {
    let (wi, wo) = (pair.wi(), pair.wo());
    (wi.z * wo.z - wi.x * wo.x - wi.y * wo.y).clamp(-1.0, 1.0)
}

/// p3..p6 in one parametrisation.
struct Azimuth {
    p3: f64,
    p4: f64,
    p5: f64,
    p6: f64,
}

impl Azimuth {
    fn q1(&self, p2: f64) -> f64 {
        p2 * p2 - self.p4 * self.p4
    }

    fn q2(&self, p2: f64) -> f64 {
        2.0 * (p2 * self.p4)
    }
}

fn azimuth(pair: &DirectionPair, parametrisation: Parametrisation) -> Azimuth {
    let (mut l, mut v) = pair.tangential();
    if parametrisation == Parametrisation::Paper {
        l /= l.length_squared().max(POLE_FLOOR).sqrt();
        v /= v.length_squared().max(POLE_FLOOR).sqrt();
    }
    Azimuth {
        p3: v.x * l.x + v.y * l.y,
        p4: v.y * l.x - v.x * l.y,
        p5: v.x * l.x - v.y * l.y,
        p6: v.x * l.y + v.y * l.x,
    }
}

/// The half vector before normalisation.
fn half_sum(pair: &DirectionPair) -> DVec3 {
    pair.wi() + pair.wo()
}

/// sin^2 theta_h; 0 if the half vector is undefined.
fn sin_squared_half(pair: &DirectionPair) -> f64 {
    let s = half_sum(pair);
    s.truncate().length_squared() / s.length_squared().max(POLE_FLOOR)
}

/// h . wi as sqrt((1 + wi . wo) / 2), which has the same bits for both directions.
fn half_dot_light(pair: &DirectionPair) -> f64 {
    (0.5 * (1.0 + pair.wi().dot(pair.wo()))).clamp(0.0, 1.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions at which such formulas tend to fail: poles, grazing, mirror plane, antipodal
    /// azimuths.
    fn hard_pairs() -> Vec<DirectionPair> {
        let mut pairs = Vec::new();
        let thetas = [0.0, 1e-9, 1e-4, 0.3, 1.0, 1.57, std::f64::consts::FRAC_PI_2];
        let phis = [0.0, 1e-7, 0.7, std::f64::consts::PI, 4.0, -1e-9];
        let direction = |theta: f64, phi: f64| {
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos().max(0.0))
        };
        for theta_i in thetas {
            for theta_o in thetas {
                for phi_i in phis {
                    for phi_o in phis {
                        let wi = direction(theta_i, phi_i);
                        let wo = direction(theta_o, phi_o);
                        pairs.push(DirectionPair::new(wi, wo).unwrap());
                    }
                }
            }
        }
        pairs
    }

    #[test]
    fn input_is_bit_equal_when_directions_are_swapped() {
        for pair in hard_pairs() {
            for input in Input::symmetric() {
                let here = input.evaluate(&pair, DVec2::new(0.25, -3.0));
                let there = input.evaluate(&pair.swapped(), DVec2::new(0.25, -3.0));
                assert!(
                    here.to_bits() == there.to_bits(),
                    "{} {pair:?}: {here} {there}",
                    input.name()
                );
                assert!(here.is_finite() && here.abs() <= RANGE, "{} {pair:?}", input.name());
            }
        }
    }

    #[test]
    fn paper_inputs_are_functions_of_the_azimuths() {
        for (phi_i, phi_o) in [(0.3f64, 1.9f64), (2.0, -1.0), (0.0, std::f64::consts::PI)] {
            let direction = |theta: f64, phi: f64| {
                DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
            };
            let pair = DirectionPair::new(direction(0.5, phi_i), direction(1.1, phi_o)).unwrap();
            let p2 = 1.1f64.cos() - 0.5f64.cos();
            let p4 = (phi_o - phi_i).sin();
            let expected = [
                (Input::PaperP3, (phi_o - phi_i).cos()),
                (Input::PaperP5, (phi_o + phi_i).cos()),
                (Input::PaperP6, (phi_o + phi_i).sin()),
                (Input::PaperQ1, p2 * p2 - p4 * p4),
                (Input::PaperQ2, 2.0 * p2 * p4),
            ];
            for (input, value) in expected {
                let got = input.evaluate(&pair, DVec2::ZERO);
                assert!((got - value).abs() < 1e-12, "{}: {got} {value}", input.name());
            }
        }
    }

    #[test]
    fn index_is_the_position_in_the_catalogue() {
        for (index, input) in Input::ALL.into_iter().enumerate() {
            assert_eq!(input.index(), index);
            assert_eq!(Input::from_index(index), Some(input));
        }
        assert_eq!(Input::from_index(Input::ALL.len()), None);
    }

    #[test]
    fn inputs_of_lights_are_found_by_light_and_quantity() {
        for light in 0..Input::LIGHTS {
            for quantity in LightInput::ALL {
                let input = Input::of_light(light, quantity);
                assert_eq!(input.light(), Some((light, quantity)));
                assert_eq!(input.name(), format!("{}.{light}", quantity.name()));
            }
        }
        assert!(Input::symmetric().all(|input| input.light().is_none()));
        assert_eq!(Input::symmetric().last(), Some(Input::NormalDotHalf));
    }

    #[test]
    fn inputs_of_painted_materials_are_finite_at_hard_pairs() {
        for pair in hard_pairs() {
            for input in Input::ALL.into_iter().skip(Input::SYMMETRIC) {
                let value = input.evaluate(&pair, DVec2::ZERO);
                let is_length = matches!(input, Input::Way0Length | Input::Way1Length);
                let most = if is_length { RANGE } else { 1.0 + 1e-12 };
                assert!(value.abs() <= most, "{}: {value} at {pair:?}", input.name());
            }
        }
    }

    #[test]
    fn mask_iterates_over_its_inputs_in_order() {
        let inputs = [Input::P1, Input::NormalDotHalf, Input::Depth, Input::Light7MirrorStep];
        let mask: InputMask = inputs.into_iter().rev().collect();
        assert_eq!(mask.iter().collect::<Vec<_>>(), inputs);
        assert_eq!(mask.len(), 4);
        assert_eq!(InputMask::EMPTY.iter().next(), None);
        assert_eq!(Input::ALL.into_iter().collect::<InputMask>().iter().count(), Input::ALL.len());
    }
}

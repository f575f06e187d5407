//! Catalogue of inputs: scalars of a direction pair that do not change when the two directions are
//! swapped.
//!
//! Every input is a pure f64 function. Sample sets store it rounded to f32 once, so that all
//! evaluators read the same bits. An [`InputMask`] lists the inputs that a program reads; only
//! these are computed.

use glam::{DVec2, DVec3};

use crate::DirectionPair;

/// Form of the azimuthal inputs p3..p6, which read the tangential parts of the directions.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Parametrisation {
    /// Tangential parts as they are: polynomial in the directions, without a singularity.
    #[default]
    Smooth,
    /// Normalised tangential parts, as in the paper: pure functions of the azimuths, singular
    /// at the poles.
    Paper,
}

crate::named_enum! {
    /// A scalar that a program may read. Symmetric under exchange of wi and wo, bit for bit.
    ///
    /// # Source
    /// `P1`..`Q2`: Meyer-Spradow and Loviscach, *Evolutionary Design of BRDFs*, section 3, in the
    /// product form of docs/maths/inputs.md. The inputs from `LogTanHalf` on belong to the extended
    /// dialect.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
    #[repr(u8)]
    pub enum Input {
        /// cos_o + cos_i.
        P1 => "p1",
        /// Texture coordinate u, unwrapped.
        U => "u",
        /// Texture coordinate v, unwrapped, upwards.
        V => "v",
        /// cos(phi_o - phi_i), weighted by sin_i sin_o.
        SmoothP3 => "p3",
        /// cos(phi_o + phi_i), weighted by sin_i sin_o.
        SmoothP5 => "p5",
        /// sin(phi_o + phi_i), weighted by sin_i sin_o.
        SmoothP6 => "p6",
        /// p2^2 - p4^2 with the weighted p4.
        SmoothQ1 => "q1",
        /// 2 p2 p4 with the weighted p4.
        SmoothQ2 => "q2",
        /// cos(phi_o - phi_i).
        PaperP3 => "p3.paper",
        /// cos(phi_o + phi_i).
        PaperP5 => "p5.paper",
        /// sin(phi_o + phi_i).
        PaperP6 => "p6.paper",
        /// p2^2 - p4^2.
        PaperQ1 => "q1.paper",
        /// 2 p2 p4.
        PaperQ2 => "q2.paper",
        /// 1/2 ln(tan^2 theta_h + 1e-7).
        LogTanHalf => "lt",
        /// h . wi.
        HalfDotLight => "h.wi",
        /// (cos_o - cos_i)^2 / (4 sin^2 theta_h + 1e-3).
        CosineDifference => "dx",
        /// 2 p2 p4 / (sin^2 theta_h + 1e-3) with the weighted p4.
        MirrorAsymmetry => "qn",
        /// cos_i cos_o.
        CosineProduct => "cos_i*cos_o",
        /// ln(h . wi).
        LogHalfDotLight => "ln(h.wi)",
        /// 1/2 ln(1 - h . wi + 0.002).
        LogHalfAngle => "ln(1-h.wi)/2",
        /// ln(cos_i cos_o).
        LogCosineProduct => "ln(cos_i*cos_o)",
        /// ln(cos_i + cos_o).
        LogCosineSum => "ln(cos_i+cos_o)",
        /// n . h.
        NormalDotHalf => "n.h",
    }
}

/// Lower bound of the arguments of logarithms; bounds every input over the closed hemisphere.
const LOG_FLOOR: f64 = 1.0 / (1u64 << 20) as f64;
/// Lower bound of squared lengths of tangential parts as divisors. The paper's parametrisation
/// fades to 0 at the poles.
const POLE_FLOOR: f64 = 1.0 / (1u64 << 40) as f64;
/// Largest magnitude of any number in a program: the range of the half-float registers of the
/// paper's hardware.
const RANGE: f64 = 65504.0;

impl Input {
    /// Position in [`Input::ALL`]; also the bit in an [`InputMask`] and the number in packed
    /// words.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// Returns the input with this index, or `None` if there is none.
    #[must_use]
    pub fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }

    /// Returns the value for a pair of directions at texture position `uv`.
    ///
    /// # Domain
    /// Any direction pair and any finite `uv`; the result is finite and within [-65504, 65504].
    ///
    /// # Error
    /// Exactly symmetric: `evaluate(pair) == evaluate(pair.swapped())` bit for bit
    /// (`input_is_bit_equal_when_directions_are_swapped`).
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
        };
        // Adding +0 turns -0 into +0: swapping directions could otherwise change the sign
        // of a zero.
        value.clamp(-RANGE, RANGE) + 0.0
    }
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

/// A set of inputs, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, PartialOrd, Ord)]
pub struct InputMask(u32);

impl InputMask {
    /// The empty set.
    pub const EMPTY: Self = Self(0);

    /// Bits of the set; bit k stands for `Input::ALL[k]`.
    #[must_use]
    pub fn bits(self) -> u32 {
        self.0
    }

    /// Returns the set with these bits, or `None` if a bit stands for no input.
    #[must_use]
    pub fn from_bits(bits: u32) -> Option<Self> {
        (bits >> Input::ALL.len() == 0).then_some(Self(bits))
    }

    /// Adds one input.
    pub fn insert(&mut self, input: Input) {
        self.0 |= 1 << input.index();
    }

    /// True if the input is in the set.
    #[must_use]
    pub fn contains(self, input: Input) -> bool {
        self.0 >> input.index() & 1 == 1
    }

    /// Returns the inputs of either set.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Iterates over the inputs in the order of their indices.
    pub fn iter(self) -> impl Iterator<Item = Input> {
        Input::ALL.into_iter().filter(move |input| self.contains(*input))
    }

    /// Number of inputs.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// True if the set has no inputs.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl FromIterator<Input> for InputMask {
    fn from_iter<I: IntoIterator<Item = Input>>(inputs: I) -> Self {
        let mut mask = Self::EMPTY;
        for input in inputs {
            mask.insert(input);
        }
        mask
    }
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
            for input in Input::ALL {
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
        assert_eq!(InputMask::from_bits(1 << Input::ALL.len()), None);
    }
}

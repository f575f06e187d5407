//! Prior over the parameters of models: a Gaussian over their coordinates, from fits of measured
//! materials.
//!
//! A picture shows few pairs of directions. Different parameters may match it equally and differ
//! under another light. The prior chooses the parameters that are most like those of known
//! materials. Its weight falls with the error of the fit. docs/maths/fit.md has the formulas.
//!
//! `prior.json` holds the parameters of fits of measured materials, made by the example `prior`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use brood_genome::Stream;

use super::coordinate::Coordinate;
use super::form::Form;
use crate::solve;

/// Parameter values of each material that a kind of model fits well.
type Fits = BTreeMap<String, BTreeMap<String, Vec<f64>>>;

static FITS: LazyLock<Fits> = LazyLock::new(|| {
    serde_json::from_str(include_str!("prior.json")).expect("the prior is a table of numbers")
});

/// Measured materials whose fits make the prior.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum PriorMaterials {
    /// All.
    #[default]
    All,
    /// All but the one of this name.
    Without(String),
    /// None: every coordinate is as unknown as in a uniform distribution.
    None,
}

impl PriorMaterials {
    fn has(&self, name: &str) -> bool {
        match self {
            Self::All => true,
            Self::Without(own) => own != name,
            Self::None => false,
        }
    }
}

/// Materials that were fitted.
const MATERIALS: usize = 118;
/// Standard deviation of an unknown coordinate, as a share of its range. A uniform distribution has
/// the same.
const WIDE: f64 = 0.29;
/// Standard deviation that is added to each coordinate, as a share of its range. Few materials were
/// fitted, and others are less alike.
const NARROW: f64 = 0.03;
/// Number of imaginary materials with the standard deviation `WIDE` and no correlation that are
/// added to the fitted ones.
const DOUBT: f64 = 1.0;

/// Gaussian over the coordinates of a form.
#[derive(Debug, Clone)]
pub(crate) struct Prior {
    mean: Vec<f64>,
    /// -2 ln of the share of materials that the models fit well.
    rarity: f64,
    /// U of the covariance U^T U ([`solve::factor`]).
    factor: Vec<f64>,
}

impl Prior {
    /// Prior of a form by these materials; coordinates of different models are independent.
    pub(super) fn of(form: &Form, coordinates: &[Coordinate], materials: &PriorMaterials) -> Self {
        let count = coordinates.len();
        let mut mean: Vec<f64> =
            coordinates.iter().map(|c| 0.5 * (c.bounds.0 + c.bounds.1)).collect();
        let mut covariance = vec![0.0; count * count];
        for (k, coordinate) in coordinates.iter().enumerate() {
            covariance[k * count + k] = (WIDE * range(coordinate)).powi(2);
        }
        let mut rarity = 0.0;
        for (index, lobe) in form.lobes().iter().enumerate() {
            let rows = lobe.kind().and_then(|kind| FITS.get(kind.name()));
            let known = || rows.into_iter().flatten().filter(|(name, _)| materials.has(name));
            let found = known().count();
            rarity -= 2.0 * libm::log((found + 1) as f64 / (MATERIALS + 1) as f64);
            if found == 0 {
                continue;
            }
            let own: Vec<usize> = (0..count).filter(|k| coordinates[*k].lobe == index).collect();
            let points: Vec<Vec<f64>> = known()
                .map(|(_, values)| {
                    own.iter().map(|k| coordinates[*k].of(values[coordinates[*k].at])).collect()
                })
                .collect();
            let weight = 1.0 / (points.len() as f64 + DOUBT);
            for (a, k) in own.iter().enumerate() {
                let sum: f64 = points.iter().map(|point| point[a]).sum();
                mean[*k] = weight * (sum + DOUBT * mean[*k]);
            }
            for (a, k) in own.iter().enumerate() {
                for (b, l) in own.iter().enumerate() {
                    let products = points.iter().map(|p| (p[a] - mean[*k]) * (p[b] - mean[*l]));
                    let wide = DOUBT * covariance[k * count + l];
                    let narrow = if k == l { NARROW * range(&coordinates[*k]) } else { 0.0 };
                    covariance[k * count + l] =
                        weight * (products.sum::<f64>() + wide) + narrow * narrow;
                }
            }
        }
        let factor = solve::factor(covariance, count).expect("a covariance is positive definite");
        Self { mean, rarity, factor }
    }

    /// Draws a point.
    pub(super) fn draw(&self, stream: &mut Stream) -> Vec<f64> {
        let count = self.mean.len();
        let mut x = self.mean.clone();
        for k in 0..count {
            let deviation = f64::from(stream.bell());
            let row = &self.factor[k * count..][k..count];
            for (x, factor) in x[k..].iter_mut().zip(row) {
                *x += factor * deviation;
            }
        }
        x
    }

    /// Deviations from the mean in standard deviations, uncorrelated: U^-T (x - mean).
    pub(crate) fn deviations(&self, x: &[f64]) -> Vec<f64> {
        let off = x.iter().zip(&self.mean).map(|(x, mean)| x - mean).collect();
        solve::forward(&self.factor, off)
    }

    /// Sum of squared deviations.
    pub(super) fn squares(&self, x: &[f64]) -> f64 {
        self.deviations(x).iter().map(|z| z * z).sum()
    }

    /// -2 ln of the probability density, up to a constant: the sum of squared deviations and
    /// -2 ln of the share of materials that the models fit well.
    pub(crate) fn distance(&self, x: &[f64]) -> f64 {
        self.squares(x) + self.rarity
    }

    /// ln det(1 + U H U^T), the term of Laplace's approximation that penalises each parameter that
    /// the samples determine.
    ///
    /// `hessian` is H, row by row: the second derivatives of -ln of the likelihood by the
    /// coordinates.
    pub(super) fn shrinkage(&self, hessian: &[f64]) -> f64 {
        let count = self.mean.len();
        let row = |a: usize| &self.factor[a * count..][a..count];
        let mut matrix = vec![0.0; count * count];
        for a in 0..count {
            let left: Vec<f64> = (0..count)
                .map(|l| (a..count).zip(row(a)).map(|(k, u)| u * hessian[k * count + l]).sum())
                .collect();
            for b in 0..count {
                let sum: f64 = left[b..].iter().zip(row(b)).map(|(left, u)| left * u).sum();
                matrix[a * count + b] = sum + if a == b { 1.0 } else { 0.0 };
            }
        }
        let Some(factor) = solve::factor(matrix, count) else { return f64::INFINITY };
        (0..count).map(|k| 2.0 * libm::log(factor[k * count + k])).sum()
    }
}

fn range(coordinate: &Coordinate) -> f64 {
    coordinate.bounds.1 - coordinate.bounds.0
}

#[cfg(test)]
mod tests {
    use brood_brdf::ModelKind;
    use brood_genome::{BirthKey, Operator};

    use super::super::schedule::default_kinds;
    use super::*;

    #[test]
    fn drawn_points_have_the_deviations_of_a_gaussian() {
        const COUNT: u32 = 400;
        for kind in default_kinds() {
            let form = Form::one(kind);
            let coordinates = form.coordinates();
            let prior = Prior::of(&form, &coordinates, &PriorMaterials::All);
            let sum: f64 = (0..COUNT)
                .map(|slot| {
                    let key = BirthKey { seed: 3, slot, attempt: 0 };
                    prior.squares(&prior.draw(&mut Stream::new(key, Operator::Analytic)))
                })
                .sum();
            let mean = sum / f64::from(COUNT) / coordinates.len() as f64;
            assert!((mean - 1.0).abs() < 0.15, "{kind}: {mean}");
        }
    }

    #[test]
    fn conductors_like_metals_are_more_probable_than_others() {
        let form = Form::one(ModelKind::Conductor);
        let coordinates = form.coordinates();
        let prior = Prior::of(&form, &coordinates, &PriorMaterials::All);
        let distance = |eta: f64, k: f64| {
            let model = brood_brdf::Model::new(ModelKind::Conductor);
            let model = model.with("eta", &[eta; 3]).unwrap().with("k", &[k; 3]).unwrap();
            prior.distance(&form.place(&[model]))
        };
        let (metal, other) = (distance(3.2, 3.3), distance(0.36, 0.06));
        assert!(metal + 20.0 < other, "{metal} {other}");
    }

    #[test]
    fn a_material_that_is_left_out_makes_no_difference_to_other_kinds() {
        let of = |kind, materials: &PriorMaterials| {
            let form = Form::one(kind);
            let coordinates = form.coordinates();
            Prior::of(&form, &coordinates, materials)
        };
        let without = PriorMaterials::Without("chrome".to_owned());
        for kind in default_kinds() {
            let has = FITS.get(kind.name()).is_some_and(|rows| rows.contains_key("chrome"));
            let (all, left) = (of(kind, &PriorMaterials::All), of(kind, &without));
            assert_eq!(all.mean != left.mean, has, "{kind}");
            let none = of(kind, &PriorMaterials::None);
            assert!(none.rarity >= left.rarity && left.rarity >= all.rarity, "{kind}");
        }
    }

    #[test]
    fn shrinkage_is_that_of_a_diagonal_matrix() {
        let form = Form::one(ModelKind::Lambert);
        let coordinates = form.coordinates();
        let prior = Prior::of(&form, &coordinates, &PriorMaterials::All);
        // No fit has this kind: coordinates are independent.
        let sigma = WIDE * range(&coordinates[0]);
        let mut hessian = vec![0.0; 9];
        hessian[0] = 8.0;
        let wanted = libm::log(1.0 + 8.0 * sigma * sigma);
        assert!((prior.shrinkage(&hessian) - wanted).abs() < 1e-12);
    }
}

//! Numbers for physical phenomena: Fresnel rise, energy over roughness, colour of the highlight,
//! range of exposures.

use brood_eval::{direction_at, direction_pair, express};
use brood_genome::{Genome, Model};
use serde::{Deserialize, Serialize};

use super::curve::albedo;
use super::{CurvePoint, LightOrbit, Specimen, luminance};

/// Angle of incidence whose mirror direction is compared with that of the normal, in degrees.
const GRAZING_DEG: f64 = 80.0;
/// Shares of a parameter's range at which the albedo is evaluated.
const ROUGHNESS_SHARES: [f64; 5] = [0.3, 0.45, 0.6, 0.75, 0.9];
/// Parameters that set the width of a highlight. All of a model change together.
const WIDTHS: [&str; 7] =
    ["roughness", "alpha_x", "alpha_y", "exponent", "exponent_u", "exponent_v", "b"];

/// Numbers for one material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Phenomena {
    /// Brightness of the mirror direction at 80 degrees relative to normal incidence; 1 if
    /// constant.
    pub fresnel_rise: f64,
    /// Largest directional albedo over channels and angles; above 1 the material creates energy.
    pub largest_albedo: f64,
    /// Smallest over largest albedo at 30 degrees as the highlight widens; 1 if energy is
    /// conserved. `None` without a model that has a width parameter.
    pub energy_kept: Option<f64>,
    /// Colour of the highlight at 45 degrees, largest channel 1; black without a highlight.
    pub highlight: [f64; 3],
    /// Colour of f at 45 degrees incidence away from the mirror direction, largest channel 1.
    pub body: [f64; 3],
    /// Smallest and largest automatic exposure over the light orbit, in EV.
    pub exposures_ev: [f64; 2],
}

impl Phenomena {
    /// Computes the numbers of a material from its curves and its exposures over the orbit.
    #[must_use]
    pub fn of(specimen: &Specimen<'_>, curves: &[CurvePoint], orbit: &LightOrbit) -> Self {
        Self::exposed(specimen, curves, orbit.extremes_ev(specimen))
    }

    /// Computes the numbers, given the smallest and largest exposure.
    fn exposed(specimen: &Specimen<'_>, curves: &[CurvePoint], exposures_ev: [f64; 2]) -> Self {
        let largest = |rgb: &[f64; 3]| rgb.iter().copied().fold(0.0, f64::max);
        let (sin, cos) = (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2);
        let light = direction_at(sin, cos, 0.0);
        let pairs = [
            direction_pair(light, direction_at(sin, cos, 0.5)),
            direction_pair(light, direction_at(sin, cos, 0.25)),
        ];
        // The first pair shows highlight and body; the second, a quarter turn apart, only the body.
        let f = specimen.f(&pairs);
        let added = [0, 1, 2].map(|channel| (f[0][channel] - f[1][channel]).max(0.0));
        let grazing = curves.iter().find(|point| point.theta_deg == GRAZING_DEG);
        Self {
            fresnel_rise: grazing.expect("curves have that angle").mirror,
            largest_albedo: curves.iter().map(|point| largest(&point.albedo)).fold(0.0, f64::max),
            energy_kept: match specimen {
                Specimen::Bred(genome, _) => energy_kept(genome),
                Specimen::Measured(_) => None,
            },
            highlight: chromaticity(added),
            body: chromaticity(f[1]),
            exposures_ev,
        }
    }
}

/// Scales the largest channel to 1.
fn chromaticity(rgb: [f64; 3]) -> [f64; 3] {
    let most = rgb.iter().copied().fold(0.0, f64::max);
    if most > 0.0 { rgb.map(|channel| channel / most) } else { [0.0; 3] }
}

/// Smallest over largest albedo of a genome of models alone as their highlights widen. `None` for
/// other genomes, and if no model has a width parameter.
fn energy_kept(genome: &Genome) -> Option<f64> {
    let has_width = |model: &Model| WIDTHS.iter().any(|name| model.get(name).is_some());
    if !genome.instructions().is_empty() || !genome.layers().iter().any(has_width) {
        return None;
    }
    let albedos: Vec<f64> = ROUGHNESS_SHARES
        .iter()
        .map(|share| {
            let layers = genome.layers().iter().map(|model| widened(model, *share)).collect();
            let wider = Genome::of_models(layers).expect("there are as many models as before");
            let wider = wider.with_output(*genome.output());
            luminance(albedo(&Specimen::Bred(&wider, &express(&wider)), 30.0))
        })
        .collect();
    let least = albedos.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = albedos.iter().copied().fold(0.0, f64::max);
    (largest > 0.0).then(|| least / largest)
}

/// Returns the model with its width parameters at a share of their ranges.
fn widened(model: &Model, share: f64) -> Model {
    model.kind().parameters().iter().fold(model.clone(), |model, parameter| {
        if !WIDTHS.contains(&parameter.name) {
            return model;
        }
        model.with(parameter.name, &[parameter.at_share(share)]).expect("it is within the range")
    })
}

#[cfg(test)]
mod tests {
    use super::super::curves;
    use super::*;

    fn of(text: &str) -> Phenomena {
        let genome: Genome = format!("brood 1\n{text}").parse().unwrap();
        let program = express(&genome);
        let specimen = Specimen::Bred(&genome, &program);
        Phenomena::exposed(&specimen, &curves(&specimen), [0.0; 2])
    }

    #[test]
    fn phenomena_are_absent_when_the_surface_is_diffuse() {
        let found = of(".model lambert\nalbedo 0.5 0.25 0.125\n");
        assert!((found.largest_albedo - 0.5).abs() < 2e-3, "{}", found.largest_albedo);
        assert_eq!(found.highlight, [0.0; 3]);
        assert_eq!(found.body, [1.0, 0.5, 0.25]);
        assert!(found.energy_kept.is_none());
        assert!(found.fresnel_rise < 0.1, "cos_i cos_o falls: {}", found.fresnel_rise);
    }

    #[test]
    fn energy_is_kept_by_a_metal_and_lost_by_phong() {
        let metal = of(".model conductor\nroughness 0.2\n");
        assert!(metal.largest_albedo <= 1.001);
        assert!(metal.highlight[0] > metal.highlight[2], "gold is yellow");
        let phong = of(".model phong\ndiffuse 0 0 0\n");
        let (kept, lost) = (metal.energy_kept.unwrap(), phong.energy_kept.unwrap());
        assert!(kept > 0.6 && lost < 0.2, "{kept} {lost}");
    }

    #[test]
    fn fresnel_rise_is_large_when_the_material_has_a_coat() {
        let coated = of(".model coated\nalbedo 0 0 0\nroughness 0.1\n");
        assert!(coated.fresnel_rise > 3.0, "{}", coated.fresnel_rise);
    }
}

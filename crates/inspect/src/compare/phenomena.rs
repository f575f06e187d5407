//! What physics makes of a reflection, in numbers: the Fresnel rise, energy over roughness, the colour of highlights, and how a
//! material takes another light.

use brood_eval::{around, express, pair};
use brood_genome::{Genome, Model};
use serde::{Deserialize, Serialize};

use super::curve::albedo;
use super::{CurvePoint, LightCircle, Specimen, luminance};

/// Degrees of incidence at which the mirror direction is held against the normal.
const GRAZING_DEG: f64 = 80.0;
/// Shares of a parameter's range at which energy is looked at.
const ROUGHNESS_SHARES: [f64; 5] = [0.3, 0.45, 0.6, 0.75, 0.9];
/// Parameters that make highlights wider or narrower, all of a model at once.
const WIDTHS: [&str; 7] =
    ["roughness", "alpha_x", "alpha_y", "exponent", "exponent_u", "exponent_v", "b"];

/// Numbers of one material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct Phenomena {
    /// The mirror direction at 80 degrees over that at the normal; 1 where nothing changes.
    pub fresnel_rise: f64,
    /// Largest directional albedo of any channel and angle: above 1 energy is made.
    pub largest_albedo: f64,
    /// The albedo at 30 degrees over the widths of the highlight, least over largest: 1 where energy is kept. None where the
    /// material has no model with such a parameter.
    pub energy_kept: Option<f64>,
    /// What the highlight adds at 45 degrees, largest channel 1; black where it adds nothing.
    pub highlight: [f64; 3],
    /// f at 45 degrees from the light and away from the mirror direction, largest channel 1.
    pub body: [f64; 3],
    /// Least and largest automatic exposure around the light circle.
    pub exposures_ev: [f64; 2],
}

impl Phenomena {
    /// Of a material with its curves, lit from all around.
    #[must_use]
    pub fn of(specimen: &Specimen<'_>, curves: &[CurvePoint], circle: &LightCircle) -> Self {
        Self::exposed(specimen, curves, circle.extremes_ev(specimen))
    }

    fn exposed(specimen: &Specimen<'_>, curves: &[CurvePoint], exposures_ev: [f64; 2]) -> Self {
        let largest = |rgb: &[f64; 3]| rgb.iter().copied().fold(0.0, f64::max);
        let (sin, cos) = (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2);
        let light = around(sin, cos, 0.0);
        let pairs = [pair(light, around(sin, cos, 0.5)), pair(light, around(sin, cos, 0.25))];
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

fn chromaticity(rgb: [f64; 3]) -> [f64; 3] {
    let most = rgb.iter().copied().fold(0.0, f64::max);
    if most > 0.0 { rgb.map(|channel| channel / most) } else { [0.0; 3] }
}

/// The albedo of the models as their highlights go from narrow to wide, least over largest.
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
    fn matt_surfaces_have_no_phenomena() {
        let found = of(".model lambert\nalbedo 0.5 0.25 0.125\n");
        assert!((found.largest_albedo - 0.5).abs() < 2e-3, "{}", found.largest_albedo);
        assert_eq!(found.highlight, [0.0; 3]);
        assert_eq!(found.body, [1.0, 0.5, 0.25]);
        assert!(found.energy_kept.is_none());
        assert!(found.fresnel_rise < 0.1, "cos_i cos_o falls: {}", found.fresnel_rise);
    }

    #[test]
    fn metals_keep_energy_and_phong_does_not() {
        let metal = of(".model conductor\nroughness 0.2\n");
        assert!(metal.largest_albedo <= 1.001);
        assert!(metal.highlight[0] > metal.highlight[2], "gold is yellow");
        let phong = of(".model phong\ndiffuse 0 0 0\n");
        let (kept, lost) = (metal.energy_kept.unwrap(), phong.energy_kept.unwrap());
        assert!(kept > 0.6 && lost < 0.2, "{kept} {lost}");
    }

    #[test]
    fn coats_brighten_at_grazing_angles() {
        let coated = of(".model coated\nalbedo 0 0 0\nroughness 0.1\n");
        assert!(coated.fresnel_rise > 3.0, "{}", coated.fresnel_rise);
    }
}

//! glTF's own material that is nearest to a BRDF, on a sphere, as a preview.
//!
//! Sources: Khronos, glTF 2.0 Specification, appendix B; the extensions KHR_materials_specular,
//! _sheen, _clearcoat and _anisotropy. Estevez and Kulla 2017, Production friendly microfacet
//! sheen BRDF, for sheen.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};
use std::sync::OnceLock;

use brood_brdf::{Brdf, Claims, DirectionPair};
use brood_mesh::{BuiltinMesh, Mesh};
use glam::DVec3;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::reflectance::{direction, even_pairs, spread};
use crate::table::{Source, Symmetry};

/// Pairs at which materials are compared while the best is searched.
const PAIRS: usize = 512;
/// First and last step of the search, as shares of a parameter's range.
const FIRST_STEP: f64 = 0.25;
const LAST_STEP: f64 = 0.004;
/// Numbers in files are multiples of 1 / this.
const ROUNDING: f64 = 1e4;
/// Reflectance of glTF's dielectrics and coats at normal incidence: index of refraction 1.5.
const DIELECTRIC: f64 = 0.04;
/// Least width of facets: narrower ones are mirrors for point lights.
const LEAST_ALPHA: f64 = 1e-3;
/// Roughnesses at which the albedo of sheen is tabulated, cosines, and samples of each.
const SHEEN_SIZE: [usize; 3] = [9, 17, 512];

/// Number of parameters.
const COUNT: usize = 16;
/// Largest values: the colour of the specular reflection may exceed 1.
const LARGEST: [f64; COUNT] = {
    let mut largest = [1.0; COUNT];
    largest[SPECULAR_COLOUR] = 10.0;
    largest[SPECULAR_COLOUR + 1] = 10.0;
    largest[SPECULAR_COLOUR + 2] = 10.0;
    largest
};
/// Places of the parameters; colours have three.
const BASE: usize = 0;
const METALLIC: usize = 3;
const ROUGHNESS: usize = 4;
const SPECULAR: usize = 5;
const SPECULAR_COLOUR: usize = 6;
const SHEEN_COLOUR: usize = 9;
const SHEEN_ROUGHNESS: usize = 12;
const COAT: usize = 13;
const COAT_ROUGHNESS: usize = 14;
const ANISOTROPY: usize = 15;
/// Roughnesses of which the search starts at the best.
const ROUGHNESSES: [f64; 4] = [0.15, 0.35, 0.6, 0.9];

/// A material of glTF.
#[derive(Debug, Clone)]
pub(super) struct Preview {
    parameters: [f64; COUNT],
    /// True if the highlight is stretched across the tangent.
    is_across: bool,
}

impl Preview {
    /// The nearest material, by a search along one parameter after the other.
    pub(super) fn of(source: &Source<'_>) -> Self {
        let pairs = even_pairs(PAIRS);
        let wanted = source.f(&pairs);
        let error = |preview: &Self| -> f64 {
            let values = pairs.iter().zip(&wanted);
            values.map(|(p, f)| (preview.f(p) - *f).abs().element_sum() * p.cos_i()).sum()
        };
        let is_isotropic = source.symmetry() == Symmetry::Isotropic;
        let mut starts = Vec::new();
        for metallic in [0.0, 1.0] {
            for is_across in [false, true] {
                let mut parameters = [0.5; COUNT];
                for (place, value) in [
                    (METALLIC, metallic),
                    (SPECULAR, 1.0),
                    (SHEEN_COLOUR, 0.0),
                    (SHEEN_COLOUR + 1, 0.0),
                    (SHEEN_COLOUR + 2, 0.0),
                    (COAT, 0.0),
                    (COAT_ROUGHNESS, 0.1),
                    (ANISOTROPY, 0.0),
                ] {
                    parameters[place] = value;
                }
                parameters[SPECULAR_COLOUR..SPECULAR_COLOUR + 3].fill(1.0);
                let start = ROUGHNESSES.map(|roughness| {
                    parameters[ROUGHNESS] = roughness;
                    Self { parameters, is_across }
                });
                let start = start.into_iter().min_by(|a, b| error(a).total_cmp(&error(b)));
                starts.push(start.expect("there are roughnesses"));
                if is_isotropic {
                    break;
                }
            }
        }
        let searched: Vec<(f64, Self)> = starts
            .into_par_iter()
            .map(|mut best| {
                let mut least = error(&best);
                let mut step = FIRST_STEP;
                while step > LAST_STEP {
                    let before = least;
                    for (place, largest) in LARGEST.into_iter().enumerate() {
                        if place == ANISOTROPY && is_isotropic {
                            continue;
                        }
                        for sign in [1.0, -1.0] {
                            let mut other = best.clone();
                            let value = best.parameters[place] + sign * step;
                            let value = value.clamp(0.0, largest);
                            other.parameters[place] = (value * ROUNDING).round() / ROUNDING;
                            let found = error(&other);
                            if found < least {
                                (best, least) = (other, found);
                                break;
                            }
                        }
                    }
                    if least > before * 0.998 {
                        step *= 0.5;
                    }
                }
                (least, best)
            })
            .collect();
        let best = searched.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.expect("there are starts").1
    }

    /// The file: a sphere with the material. `stem` names it, `words` describe it.
    pub(super) fn file(&self, stem: &str, words: &str) -> Vec<u8> {
        let p = &self.parameters;
        let colour = |place: usize| json!([p[place], p[place + 1], p[place + 2]]);
        let mut base = colour(BASE);
        base.as_array_mut().expect("a colour is an array").push(json!(1.0));
        let mut extensions = json!({ "KHR_materials_specular": {
            "specularFactor": p[SPECULAR], "specularColorFactor": colour(SPECULAR_COLOUR),
        } });
        if p[SHEEN_COLOUR..SHEEN_COLOUR + 3].iter().any(|value| *value > 0.0) {
            extensions["KHR_materials_sheen"] = json!({
                "sheenColorFactor": colour(SHEEN_COLOUR), "sheenRoughnessFactor": p[SHEEN_ROUGHNESS],
            });
        }
        if p[COAT] > 0.0 {
            extensions["KHR_materials_clearcoat"] = json!({
                "clearcoatFactor": p[COAT], "clearcoatRoughnessFactor": p[COAT_ROUGHNESS],
            });
        }
        if p[ANISOTROPY] > 0.0 {
            let rotation = if self.is_across { FRAC_PI_2 } else { 0.0 };
            extensions["KHR_materials_anisotropy"] = json!({
                "anisotropyStrength": p[ANISOTROPY], "anisotropyRotation": rotation,
            });
        }
        let material: Value = json!({
            "name": stem,
            "pbrMetallicRoughness": {
                "baseColorFactor": base,
                "metallicFactor": p[METALLIC],
                "roughnessFactor": p[ROUGHNESS],
            },
            "extensions": extensions,
            "extras": { "description": words },
        });
        Mesh::builtin(BuiltinMesh::Sphere).to_glb_with(&material)
    }

    fn colour(&self, place: usize) -> DVec3 {
        DVec3::from_slice(&self.parameters[place..place + 3])
    }
}

impl Brdf for Preview {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let (light, eye) = (pair.wi(), pair.wo());
        if light.z <= 0.0 || eye.z <= 0.0 {
            return DVec3::ZERO;
        }
        let p = &self.parameters;
        let half = (light + eye).normalize();
        let schlick = libm::pow(1.0 - half.dot(eye).abs().min(1.0), 5.0);
        let alpha = p[ROUGHNESS] * p[ROUGHNESS];
        let stretched = alpha + (1.0 - alpha) * p[ANISOTROPY] * p[ANISOTROPY];
        let widths = if self.is_across { [alpha, stretched] } else { [stretched, alpha] };
        let specular = facets(light, eye, half, widths);
        let base = self.colour(BASE);
        let metal = specular * (base + (DVec3::ONE - base) * schlick);
        let normal = (DIELECTRIC * self.colour(SPECULAR_COLOUR)).min(DVec3::ONE) * p[SPECULAR];
        let fresnel = normal + (DVec3::splat(p[SPECULAR]) - normal) * schlick;
        let diffuse = base * FRAC_1_PI;
        let dielectric = (1.0 - fresnel.max_element()) * diffuse + fresnel * specular;
        let mut f = dielectric.lerp(metal, p[METALLIC]);
        let sheen = self.colour(SHEEN_COLOUR);
        if sheen.max_element() > 0.0 {
            let roughness = p[SHEEN_ROUGHNESS];
            let kept = 1.0 - sheen.max_element() * sheen_albedo(eye.z, roughness);
            f = sheen * charlie(light, eye, half, roughness) + kept.max(0.0) * f;
        }
        if p[COAT] > 0.0 {
            let alpha = p[COAT_ROUGHNESS] * p[COAT_ROUGHNESS];
            let grazing = libm::pow(1.0 - eye.z.min(1.0), 5.0);
            let share = p[COAT] * (DIELECTRIC + (1.0 - DIELECTRIC) * grazing);
            f = f.lerp(DVec3::splat(facets(light, eye, half, [alpha; 2])), share);
        }
        f
    }

    fn claims(&self) -> Claims {
        Claims::default()
    }
}

/// GGX without Fresnel term.
fn facets(light: DVec3, eye: DVec3, half: DVec3, widths: [f64; 2]) -> f64 {
    let [along, across] = widths.map(|width| width.max(LEAST_ALPHA));
    let squared = DVec3::new(half.x / along, half.y / across, half.z).length_squared();
    let density = FRAC_1_PI / (along * across * squared * squared);
    let stretch = |w: DVec3| DVec3::new(along * w.x, across * w.y, w.z).length();
    density * 0.5 / (eye.z * stretch(light) + light.z * stretch(eye))
}

/// Sheen of weight 1.
fn charlie(light: DVec3, eye: DVec3, half: DVec3, roughness: f64) -> f64 {
    let alpha = (roughness * roughness).max(LEAST_ALPHA);
    let inverse = 1.0 / alpha;
    let sin2 = (1.0 - half.z * half.z).max(0.0);
    let density = (2.0 + inverse) * libm::pow(sin2, 0.5 * inverse) / TAU;
    let shadowing = 1.0 + sheen_lambda(light.z, alpha) + sheen_lambda(eye.z, alpha);
    density / (shadowing * 4.0 * light.z * eye.z)
}

/// Estevez and Kulla's fit, with the coefficients of glTF's extension.
fn sheen_lambda(cosine: f64, alpha: f64) -> f64 {
    const ROUGH: [f64; 5] = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054];
    const SMOOTH: [f64; 5] = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967];
    let share = (1.0 - alpha) * (1.0 - alpha);
    let [a, b, c, d, e]: [f64; 5] =
        std::array::from_fn(|k| ROUGH[k] + (SMOOTH[k] - ROUGH[k]) * share);
    let line = |x: f64| a / (1.0 + b * libm::pow(x, c)) + d * x + e;
    match cosine < 0.5 {
        true => libm::exp(line(cosine)),
        false => libm::exp(2.0 * line(0.5) - line(1.0 - cosine.min(1.0))),
    }
}

/// Albedo of sheen of weight 1, linear between tabulated cosines and roughnesses.
fn sheen_albedo(cosine: f64, roughness: f64) -> f64 {
    static TABLE: OnceLock<Vec<f64>> = OnceLock::new();
    let [rows, columns, samples] = SHEEN_SIZE;
    let table = TABLE.get_or_init(|| {
        let albedo = |place: usize| {
            let roughness = (place / columns) as f64 / (rows - 1) as f64;
            let cosine = ((place % columns) as f64 / (columns - 1) as f64).max(0.01);
            let eye = direction(libm::acos(cosine), 0.0);
            let light = |k: usize| {
                let place = spread(k);
                direction(libm::acos(1.0 - place.x), TAU * place.y)
            };
            let value =
                |light: DVec3| charlie(light, eye, (light + eye).normalize(), roughness) * light.z;
            (0..samples).map(light).filter(|w| w.z > 0.0).map(value).sum::<f64>() * TAU
                / samples as f64
        };
        (0..rows * columns).map(albedo).collect()
    });
    let split = |share: f64, count: usize| {
        let place = share.clamp(0.0, 1.0) * (count - 1) as f64;
        let first = (place as usize).min(count - 2);
        (first, place - first as f64)
    };
    let ((row, down), (column, right)) = (split(roughness, rows), split(cosine, columns));
    let at = |row: usize, column: usize| table[row * columns + column];
    let line = |row: usize| at(row, column) + (at(row, column + 1) - at(row, column)) * right;
    line(row) + (line(row + 1) - line(row)) * down
}

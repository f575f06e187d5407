//! Pictures that the peer rendered earlier, from the external data folder.
//!
//! Owns the list of these pictures and their scenes. The peer renders them again to measure their
//! noise and to check that its scene is the recorded one.

use std::path::Path;

use serde_json::{Value, json};

use super::case::{self, Case, Material};
use super::material::{self, Pair};

/// Samples per pixel of all recorded pictures. Their stratified sampler has a half to a fiftieth of
/// the noise of independent samples.
const RECORDED_SAMPLES: u32 = 64;
const RECORDED_SAMPLER: &str = "multijitter";
/// brood's samples per pixel; many, because the recorded pictures have so little noise.
const SAMPLES: u32 = 1024;
/// brood's samples per pixel in ambient light, each with the same number of light samples.
const AMBIENT_SAMPLES: u32 = 64;
/// Measured materials with recorded pictures.
const MEASURED: [&str; 4] = ["paper_white", "cg_sunflower", "colodur_napoli_4f", "cc_ibiza_sunset"];
/// Materials with a recorded picture of spot.
const ON_SPOT: [&str; 3] = ["ggx_gold_a0.2", "rgl_cg_sunflower", "rgl_colodur_napoli_4f"];

/// Scene of a group of recorded pictures.
struct View {
    object: &'static str,
    light: &'static str,
    /// Prefix of the file names.
    prefix: &'static str,
    mesh: &'static str,
    samples: u32,
    size_px: u32,
    scene: Value,
}

/// All recorded pictures, whether or not their files exist.
pub fn cases(data: &Path) -> Vec<Case> {
    let ambient = json!({"kind": "ambient", "radiance_w_m2_sr": 1.0, "samples": AMBIENT_SAMPLES});
    let sphere = |light, prefix, samples, light_json| View {
        object: "sphere",
        light,
        prefix,
        mesh: "sphere",
        samples,
        size_px: 128,
        scene: case::scene(case::sphere_camera(), light_json),
    };
    let views = [
        sphere(
            "directional",
            "sphere_l45",
            SAMPLES,
            case::distant([-1.0, -1.0, -std::f64::consts::SQRT_2]),
        ),
        sphere("ambient", "sphere_const", AMBIENT_SAMPLES, ambient),
        View {
            object: "spot",
            light: "point",
            prefix: "spot_point",
            // Rendered from the file without normals, which the peer computes with creases along
            // the texture's seams.
            mesh: "seams",
            samples: SAMPLES,
            size_px: 192,
            scene: case::scene(case::spot_camera(), case::spot_lamp()),
        },
    ];
    let mut cases = Vec::new();
    for view in views {
        for (file, name, material, bsdf) in materials(data) {
            if view.object == "spot" && !ON_SPOT.contains(&file.as_str()) {
                continue;
            }
            cases.push(Case {
                others: Vec::new(),
                object: view.object,
                light: view.light,
                material_name: name,
                material,
                bsdf,
                scene: view.scene.clone(),
                mesh: Some(view.mesh),
                size_px: view.size_px,
                samples: view.samples,
                peer_samples: RECORDED_SAMPLES,
                peer_sampler: RECORDED_SAMPLER,
                recorded: Some(data.join(format!("renders_mitsuba/{}_{file}.exr", view.prefix))),
            });
        }
    }
    cases
}

/// File name, table name, brood's material and the peer's material.
fn materials(data: &Path) -> Vec<(String, String, Material, Value)> {
    let named = |file: &str, pair: Pair| {
        (file.to_owned(), pair.name.to_owned(), Material::Model(pair.model), pair.bsdf)
    };
    let models = [
        named("lambert_0.5_0.3_0.2", material::lambert()),
        named("ggx_gold_a0.2", material::gold()),
        named("roughplastic_a0.1", material::rough_plastic()),
        named("principled_clearcoat", material::principled()),
    ];
    let measured = MEASURED.map(|name| {
        let file = data.join(format!("rgl/{name}_rgb.bsdf"));
        let bsdf = json!({"type": "measured", "filename": file});
        (format!("rgl_{name}"), format!("RGL {name}"), Material::Measured(file), bsdf)
    });
    models.into_iter().chain(measured).collect()
}

#[cfg(test)]
mod tests {
    use super::cases;
    use std::path::Path;

    #[test]
    fn every_recorded_picture_is_named() {
        let names: Vec<String> = cases(Path::new("data"))
            .into_iter()
            .filter_map(|case| Some(case.recorded?.file_name()?.to_string_lossy().into_owned()))
            .collect();
        assert_eq!(names.len(), 19);
        for name in ["sphere_l45_principled_clearcoat.exr", "spot_point_rgl_cg_sunflower.exr"] {
            assert!(names.iter().any(|known| known == name), "{names:?}");
        }
    }
}

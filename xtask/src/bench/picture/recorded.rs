//! Pictures that the peer made earlier, which lie in the data from outside.
//!
//! Owns which of them there are and what they show. The peer makes them anew to tell their noise, and that its scene is
//! the one that was recorded.

use std::path::Path;

use serde_json::{Value, json};

use super::case::{self, Case, Material};
use super::material::{self, Pair};

/// Samples a pixel of all recorded pictures, and how they were chosen: spread evenly, with a half to a fiftieth of the noise
/// of independent ones.
const RECORDED_SAMPLES: u32 = 64;
const RECORDED_SAMPLER: &str = "multijitter";
/// brood's samples a pixel: so many that pictures with so little noise can be met.
const SAMPLES: u32 = 1024;
/// The same in ambient light, of which each takes as many samples again.
const AMBIENT_SAMPLES: u32 = 64;
/// Measured materials of which there are pictures.
const MEASURED: [&str; 4] = ["paper_white", "cg_sunflower", "colodur_napoli_4f", "cc_ibiza_sunset"];
/// Materials of which there is one with spot.
const ON_SPOT: [&str; 3] = ["ggx_gold_a0.2", "rgl_cg_sunflower", "rgl_colodur_napoli_4f"];

/// How a recorded picture came about.
struct View {
    object: &'static str,
    light: &'static str,
    /// How names of its files begin.
    prefix: &'static str,
    mesh: &'static str,
    samples: u32,
    size_px: u32,
    scene: Value,
}

/// All of them, whether or not their files are there.
pub fn cases(data: &Path) -> Vec<Case> {
    let all_around =
        json!({"kind": "ambient", "radiance_w_m2_sr": 1.0, "samples": AMBIENT_SAMPLES});
    let sphere = |light, prefix, samples, lamp| View {
        object: "sphere",
        light,
        prefix,
        mesh: "sphere",
        samples,
        size_px: 128,
        scene: case::scene(case::sphere_camera(), lamp),
    };
    let views = [
        sphere(
            "directional",
            "sphere_l45",
            SAMPLES,
            case::distant([-1.0, -1.0, -std::f64::consts::SQRT_2]),
        ),
        sphere("ambient", "sphere_const", AMBIENT_SAMPLES, all_around),
        View {
            object: "spot",
            light: "point",
            prefix: "spot_point",
            // They were made from the file without normals, which the peer gives creases along the seams of the texture.
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

/// What files call it, what tables call it, and the material itself.
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

//! Tests of lights on meshes: shadows, skipped samples, and pictures with a closed form.

use std::f64::consts::PI;
use std::sync::Arc;

use brood_brdf::DirectionPair;
use brood_light::{EnvironmentMap, LightAssets};
use brood_mesh::{BuiltinMesh, Mesh, MeshParts, ObjLimits, fixed_tangent, parse_obj};
use glam::DVec2;

use super::{PixelArea, Raster, SampleSet, Sampling};
use crate::{Normals, Scene};

fn scene(json: &str) -> Scene {
    let scene: Scene = serde_json::from_str(json).unwrap();
    assert_eq!(scene.validate(), Ok(()), "{json}");
    scene
}

/// Returns red irradiance times cosine of each pixel.
fn received(set: &SampleSet) -> Vec<f64> {
    let layout = set.image().unwrap();
    let mut pixels = vec![0.0; layout.coverage.len()];
    for span in layout.spans() {
        let samples = span.radiance_start as usize..span.end as usize;
        let sum: f64 = set.irradiance()[0][samples].iter().map(|e| f64::from(*e)).sum();
        pixels[span.pixel as usize] = sum * f64::from(layout.scale);
    }
    pixels
}

#[test]
fn mean_of_lambert_sphere_in_directional_light_matches_closed_form() {
    // Lambert 1760: the mean over the disc, with a the angle between light and view.
    for angle in [0.0f64, 45.0, 90.0, 120.0] {
        let (sin, cos) = angle.to_radians().sin_cos();
        let scene = scene(&format!(
            r#"{{"camera": {{"orthographic": 1.05}}, "lights": [
                {{"kind": "directional", "direction": [{}, 0, {}], "irradiance_w_m2": 3}}]}}"#,
            -sin, -cos
        ));
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let set = SampleSet::render(&mesh, &scene, 200, Sampling::Adaptive);
        let covered: f64 = set.image().unwrap().coverage.iter().map(|c| f64::from(*c)).sum();
        let mean = received(&set).iter().sum::<f64>() / covered;
        let a = angle.to_radians();
        let expected = 3.0 * 2.0 / (3.0 * PI) * (sin + (PI - a) * cos);
        assert!((mean - expected).abs() < 1e-3, "{angle}: {mean} {expected}");
    }
}

#[test]
fn uniform_environment_and_ambient_light_have_irradiance_pi_everywhere() {
    let mut assets = LightAssets::default();
    let map = EnvironmentMap::new(16, 8, vec![[1.0; 3]; 128]).unwrap();
    assets.insert_environment("even", Arc::new(map));
    for (light, bound) in [
        (r#"{"kind": "ambient"}"#, 1e-5),
        (r#"{"kind": "environment", "image": "even", "samples": 1024}"#, 2e-2),
    ] {
        let scene = scene(&format!(r#"{{"lights": [{light}]}}"#));
        for sampling in [Sampling::Adaptive, Sampling::Fixed(2)] {
            let raster = Raster { size_px: 24.into(), sampling, area: PixelArea::whole(24) };
            let mesh = Mesh::builtin(BuiltinMesh::Knob);
            let set = SampleSet::render_with_assets(&mesh, &scene, &assets, raster);
            let coverage = &set.image().unwrap().coverage;
            for (pixel, received) in received(&set).into_iter().enumerate() {
                let expected = PI * f64::from(coverage[pixel]);
                assert!((received - expected).abs() <= bound * PI, "{light} {received} {expected}");
            }
        }
    }
}

/// Returns the numbers of lit and shadowed samples of a mesh in directional light.
fn lit_and_shadowed(mesh: &Mesh, towards: [f64; 3], normals: Normals) -> (u64, u64) {
    let [x, y, z] = towards.map(|v| -v);
    let mut scene = scene(&format!(
        r#"{{"shadows": true, "lights": [{{"kind": "directional", "direction": [{x}, {y}, {z}]}}]}}"#
    ));
    scene.normals = normals;
    let counts = SampleSet::render(mesh, &scene, 150, 1).counts();
    (counts.lit, counts.shadowed)
}

const TOWARDS: [[f64; 3]; 6] = [
    [1.0, 0.3, 0.2],
    [0.2, 1.0, 0.1],
    [-1.0, 0.1, 0.4],
    [0.3, 0.2, -1.0],
    [0.1, -1.0, 0.3],
    [1.0, 1.0, 1.0],
];

#[test]
fn convex_surface_never_shadows_itself() {
    // Coarse and fine, far from the origin, tiny and huge; triangles are flat, normals are curved.
    let mut meshes = vec![Mesh::builtin(BuiltinMesh::Sphere), Mesh::builtin(BuiltinMesh::Cube)];
    for (rows, size, offset) in [(5u32, 1.0, 0.0), (12, 1e-3, 5.0), (40, 1e4, -1e6)] {
        meshes.push(ball(rows, size, offset));
    }
    for (number, mesh) in meshes.iter().enumerate() {
        for towards in TOWARDS {
            let (lit, shadowed) = lit_and_shadowed(mesh, towards, Normals::Curved);
            assert!(lit > 0 && shadowed == 0, "{number} {towards:?}: {shadowed} of {lit}");
        }
    }
}

#[test]
fn plain_normals_allow_self_shadowing_and_triangles_facing_away() {
    let mesh = ball(5, 1.0, 0.0);
    let (mut hidden, mut averted) = (0, 0);
    for towards in TOWARDS {
        let (curved, _) = lit_and_shadowed(&mesh, towards, Normals::Curved);
        let (plain, shadowed) = lit_and_shadowed(&mesh, towards, Normals::Plain);
        assert!(plain + shadowed <= curved, "{towards:?}: {plain} + {shadowed} of {curved}");
        hidden += shadowed;
        // Samples that are now neither lit nor shadowed belong to points that face away from the
        // eye.
        averted += curved - plain - shadowed;
    }
    assert!(hidden > 100 && averted > 100, "{hidden} {averted}");
    // For small triangles the difference is below 1 %.
    let sphere = Mesh::builtin(BuiltinMesh::Sphere);
    let (curved, _) = lit_and_shadowed(&sphere, TOWARDS[0], Normals::Curved);
    let (plain, _) = lit_and_shadowed(&sphere, TOWARDS[0], Normals::Plain);
    assert!(curved - plain < curved / 100, "{plain} of {curved}");
}

/// Sphere with `rows` rows and twice as many columns.
fn ball(rows: u32, size: f64, offset: f64) -> Mesh {
    let columns = 2 * rows;
    let mut parts = MeshParts { has_uv: true, ..MeshParts::default() };
    for row in 0..=rows {
        let polar = PI * f64::from(row) / f64::from(rows);
        for column in 0..=columns {
            let turn = 2.0 * PI * f64::from(column) / f64::from(columns);
            let n =
                glam::DVec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin())
                    .normalize();
            parts.positions.push(n * size + offset);
            parts.normals.push(n);
            parts.tangents.push(fixed_tangent(n));
            parts.uvs.push(DVec2::ZERO);
        }
    }
    let at = |row: u32, column: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            parts.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    Mesh::from_parts(parts).unwrap()
}

#[test]
fn shadows_of_concave_surfaces_have_no_stray_pixels() {
    for name in [BuiltinMesh::Torus, BuiltinMesh::Knob] {
        let mesh = Mesh::builtin(name);
        let mut all = 0;
        for [x, y, z] in TOWARDS {
            let light = format!(
                r#""lights": [{{"kind": "directional", "direction": [{}, {}, {}]}}]}}"#,
                -x, -y, -z
            );
            let lit = |shadows: bool| {
                let scene = scene(&format!(r#"{{"shadows": {shadows}, {light}"#));
                let set = SampleSet::render(&mesh, &scene, 150, 1);
                received(&set).into_iter().map(|e| e > 0.0).collect::<Vec<_>>()
            };
            let (open, shaded) = (lit(false), lit(true));
            assert!(open.iter().zip(&shaded).all(|(open, shaded)| *open || !*shaded));
            let dark = |pixel: usize| open[pixel] && !shaded[pixel];
            let alone = |pixel: &usize| {
                let around = [pixel - 151, pixel - 150, pixel - 149, pixel - 1];
                let others = [pixel + 1, pixel + 149, pixel + 150, pixel + 151];
                let lit = |k: &usize| shaded[*k];
                dark(*pixel) && around.iter().chain(&others).all(lit)
            };
            let stray = (151..150 * 149 - 1).filter(alone).count();
            all += (0..open.len()).filter(|pixel| dark(*pixel)).count();
            // A shadow may be one pixel wide somewhere.
            assert!(stray <= 1, "{} {x} {y} {z}: {stray}", name.name());
        }
        assert!(all > 500, "{}: {all}", name.name());
    }
}

/// Large floor and a small square above its middle, both facing up.
fn table() -> Mesh {
    let floor = "v -4 0 -4\nv -4 0 4\nv 4 0 4\nv 4 0 -4\n";
    let top = "v -1 1 -1\nv -1 1 1\nv 1 1 1\nv 1 1 -1\n";
    let text = format!("{floor}{top}f 1 2 3 4\nf 5 6 7 8\n");
    parse_obj(text.as_bytes(), &ObjLimits::default()).unwrap().mesh
}

#[test]
fn table_casts_shadow_of_expected_size_with_antialiased_edge() {
    // Eye and light are straight above the table.
    let light = r#""lights": [{"position": [0, 3, 0]}], "shadows": true"#;
    let scene = scene(&format!(
        r#"{{"camera": {{"eye": [0, 40, 0], "up": [0, 0, -1], "fov_y_deg": 12}}, {light}}}"#
    ));
    let set = SampleSet::render(&table(), &scene, 201, Sampling::Adaptive);
    // The light is 3 above the floor and 2 above the table: the shadow's side is 3, of which the
    // table hides 2.
    let pixel = 80.0 * 6f64.to_radians().tan() / 201.0;
    let shade = received(&set);
    let row = &shade[100 * 201..101 * 201];
    let floor = &set.image().unwrap().coverage[100 * 201..101 * 201];
    let dark = row.iter().zip(floor).filter(|(e, seen)| **e == 0.0 && **seen == 1.0).count();
    let dark = dark as f64 * pixel;
    assert!((dark - 1.0).abs() < 0.2, "expected 1.0 of shadow beside the table, got {dark}");
    let layout = set.image().unwrap();
    let edges = layout.spans().filter(|span| span.radiance_start > span.start).count();
    assert!(edges > 200, "{edges}");
    assert!(set.counts().shadowed > 500, "{:?}", set.counts());
}

#[test]
fn area_light_casts_penumbra_with_half_lit_middle() {
    let shade = |light: &str| {
        let scene = scene(&format!(
            r#"{{"camera": {{"eye": [0, 40, 0], "up": [0, 0, -1], "fov_y_deg": 12}},
                "shadows": true, "lights": [{light}]}}"#
        ));
        let open = Scene { shadows: false, ..scene.clone() };
        let take = |scene: &Scene| received(&SampleSet::render(&table(), scene, 101, 1));
        let (shaded, open) = (take(&scene), take(&open));
        let row = 50 * 101..51 * 101;
        shaded[row.clone()].iter().zip(&open[row]).map(|(a, b)| a / b).collect::<Vec<f64>>()
    };
    let light = r#"{"kind": "rectangle", "position": [0, 3, 0], "axis": [0, -1, 0],
        "width": 1, "height": 1, "samples": 256}"#;
    let shares = shade(light);
    let half = shares.iter().filter(|share| (0.1..0.9).contains(*share)).count();
    assert!(half >= 8, "expected at least 8 pixels of penumbra, got {half}: {shares:?}");
    // For the light's centre, the shadow's edge is 1.5 from the middle of the floor.
    let pixel = 80.0 * 6f64.to_radians().tan() / 101.0;
    let at = shares[(50.0 + 1.5 / pixel).round() as usize];
    assert!((0.35..0.65).contains(&at), "{at}");
    let sharp = shade(r#"{"position": [0, 3, 0]}"#);
    assert!(sharp.iter().all(|share| share.is_nan() || *share == 0.0 || *share == 1.0));
}

#[test]
fn light_without_effect_is_counted_as_skipped() {
    let mesh = Mesh::builtin(BuiltinMesh::Sphere);
    let count = |light: &str| {
        let scene = scene(&format!(r#"{{"lights": [{light}]}}"#));
        SampleSet::render(&mesh, &scene, 40, 1).counts()
    };
    let default = count("{}");
    assert_eq!(default.lit + default.skipped, default.covered, "one sample per covered pixel");
    for light in [
        r#"{"intensity": 0}"#,
        r#"{"kind": "spot", "axis": [1, 1, 1]}"#,
        r#"{"kind": "ies", "profile": "missing"}"#,
        r#"{"kind": "directional", "direction": [2, 1, 2]}"#,
    ] {
        let counts = count(light);
        let none = (counts.lit, counts.skipped) == (0, counts.covered);
        assert!(none || light.contains("direction"), "{light}: {counts:?}");
        assert!(counts.skipped > counts.covered / 2, "{light}: {counts:?}");
    }
    let soft = count(r#"{"kind": "disk", "samples": 8}"#);
    assert_eq!(soft.lit + soft.skipped, 8 * soft.covered);
}

#[test]
fn extended_lights_are_bit_identical_for_areas_and_any_number_of_threads() {
    let scene = scene(
        r#"{"shadows": true, "lights": [{"kind": "sphere", "samples": 4}, {"kind": "ambient", "samples": 4}]}"#,
    );
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    let make = |threads: usize, area: PixelArea| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| SampleSet::render_area(&mesh, &scene, 40, Sampling::Adaptive, area))
    };
    let pairs = |set: &SampleSet| -> Vec<(DirectionPair, DVec2)> {
        (0..set.len()).map(|k| set.pair(k)).collect()
    };
    let (one, three) = (make(1, PixelArea::whole(40)), make(3, PixelArea::whole(40)));
    assert_eq!((pairs(&one), one.irradiance()), (pairs(&three), three.irradiance()));
    let area: PixelArea = "11,7,16,20".parse().unwrap();
    let part = make(2, area);
    let whole = one.image().unwrap();
    for span in part.image().unwrap().spans() {
        let (x, y) = (area.x + span.pixel % area.width, area.y + span.pixel / area.width);
        let own = whole.spans().find(|own| own.pixel == y * 40 + x).unwrap();
        for (here, there) in (span.start..span.end).zip(own.start..own.end) {
            assert_eq!(part.pair(here as usize), one.pair(there as usize));
        }
        assert_eq!(span.end - span.start, own.end - own.start);
    }
}

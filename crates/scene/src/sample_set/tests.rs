use brood_brdf::{DirectionPair, Input};
use brood_light::{Light, PointLight, Quantity, Strength};
use brood_mesh::angle::orbit_direction;
use brood_mesh::{BuiltinMesh, Mesh, MeshParts, ObjLimits, fixed_tangent, parse_obj};
use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::{SampleSet, Sampling};
use crate::{Camera, LookAtCamera, OrbitCamera, OrthographicCamera, Scene, Tangents};

fn sphere() -> Mesh {
    Mesh::builtin(BuiltinMesh::Sphere)
}

fn obj(text: &str) -> Mesh {
    parse_obj(text.as_bytes(), &ObjLimits::default()).unwrap().mesh
}

fn with_camera(camera: Camera) -> Scene {
    Scene { camera, ..Scene::default() }
}

fn point(position: Option<[f64; 3]>, intensity: Option<[f64; 3]>) -> Light {
    let strength = intensity.map(|channels| Strength::new(Quantity::Intensity, channels));
    Light::Point(PointLight { position, strength })
}

fn orbit(azimuth: f64, elevation: f64) -> Camera {
    Camera::Orbit(OrbitCamera { orbit_deg: [azimuth, elevation], distance: None, fov_y_deg: 30.0 })
}

/// Scene with its light at the eye, so that everything visible is lit.
fn headlight(azimuth: f64, elevation: f64) -> Scene {
    let eye = orbit_direction(azimuth, elevation) * 100.0;
    let light = Light::point_at(eye.to_array());
    Scene { lights: vec![light], ..with_camera(orbit(azimuth, elevation)) }
}

/// Asserts the invariants of the set of an image.
fn assert_invariants(samples: &SampleSet) {
    let image = samples.image().unwrap();
    let mut next = 0;
    let mut last_pixel = None;
    for span in image.spans() {
        assert_eq!(span.start, next, "spans must be contiguous");
        assert!(span.start <= span.centre_end && span.centre_end <= span.end, "{span:?}");
        assert!(
            span.radiance_start == span.start || span.radiance_start == span.centre_end,
            "{span:?}"
        );
        assert!(span.start < span.end, "{span:?}");
        assert!(last_pixel < Some(span.pixel), "pixels must be ascending");
        assert!(image.coverage[span.pixel as usize] > 0.0, "{span:?}");
        last_pixel = Some(span.pixel);
        next = span.end;
    }
    assert_eq!(next as usize, samples.len(), "spans must cover all samples");
    let counts = samples.counts();
    let pixels = u64::from(image.width) * u64::from(image.height);
    assert_eq!(image.coverage.len() as u64, pixels);
    assert!(image.coverage.iter().all(|share| (0.0..=1.0).contains(share)));
    if let Sampling::Fixed(samples) = image.sampling {
        // One more than an even number.
        let samples = samples | 1;
        assert_eq!(counts.rays, pixels * u64::from(samples));
        let covered: f64 = image.coverage.iter().map(|share| f64::from(*share)).sum();
        assert!((counts.covered as f64 - covered * f64::from(samples)).abs() <= 1e-3 * covered);
    } else {
        assert!(counts.rays >= pixels);
    }
    assert_eq!(counts.lit, samples.len() as u64);
    for index in 0..samples.len() {
        let (pair, uv) = samples.pair(index);
        assert!((pair.wi().length() - 1.0).abs() < 1e-12, "{pair:?}");
        assert!((pair.wo().length() - 1.0).abs() < 1e-12, "{pair:?}");
        assert!(pair.cos_i() > 0.0 && pair.cos_o() > 0.0, "{pair:?}");
        assert!(uv.is_finite());
    }
    for channel in samples.irradiance() {
        assert_eq!(channel.len(), samples.len());
        assert!(channel.iter().all(|e| e.is_finite() && *e >= 0.0));
    }
}

/// Returns the bounds of the covered pixels: left, right, top, bottom.
fn bounds(samples: &SampleSet) -> [u32; 4] {
    let image = samples.image().unwrap();
    let pixels = (0u32..).zip(image.coverage.iter()).filter(|(_, covered)| **covered > 0.0);
    pixels.fold([u32::MAX, 0, u32::MAX, 0], |[left, right, top, bottom], (pixel, _)| {
        let (x, y) = (pixel % image.width, pixel / image.width);
        [left.min(x), right.max(x), top.min(y), bottom.max(y)]
    })
}

#[test]
fn sphere_radius_in_pixels_matches_camera() {
    // Default distance: radius over half the picture is tan(asin(1/d)) / tan(fov/2) with
    // d = 1.04 / sin(fov/2).
    let framed = (15f64.to_radians().sin() / 1.04).asin().tan() / 15f64.to_radians().tan();
    let near = (1f64 / 3.0).asin().tan() / 20f64.to_radians().tan();
    let eye = [1.0, 2.0, 2.0];
    let cases = [
        (orbit(40.0, -70.0), framed),
        (
            Camera::Orbit(OrbitCamera {
                orbit_deg: [0.0, 0.0],
                distance: Some(3.0),
                fov_y_deg: 40.0,
            }),
            near,
        ),
        (
            Camera::LookAt(LookAtCamera {
                eye,
                target: [0.0; 3],
                up: [0.0, 1.0, 0.0],
                fov_y_deg: 40.0,
            }),
            near,
        ),
        (Camera::Orthographic(OrthographicCamera { orthographic: 1.25 }), 0.8),
    ];
    for (camera, fraction) in cases {
        let samples = SampleSet::render(&sphere(), &with_camera(camera.clone()), 300, 1);
        let radius = (samples.counts().covered as f64 / std::f64::consts::PI).sqrt();
        assert!((radius - 150.0 * fraction).abs() < 0.25, "{camera:?} {radius} {fraction}");
        let [left, right, top, bottom] = bounds(&samples);
        assert!(left.abs_diff(299 - right) <= 1 && top.abs_diff(299 - bottom) <= 1, "{camera:?}");
        assert_invariants(&samples);
    }
}

#[test]
fn camera_has_x_to_the_right_and_y_upwards() {
    // A right triangle: its right angle at the lower left, one corner at the right, one at the top.
    let flag = obj("v -1 -1 0\nv 1 -1 0\nv -1 1 0\nf 1 2 3\n");
    let up = [0.0, 1.0, 0.0];
    let look_at = Camera::LookAt(LookAtCamera {
        eye: [0.0, 0.0, 9.0],
        target: [0.0; 3],
        up,
        fov_y_deg: 30.0,
    });
    let cameras =
        [orbit(0.0, 0.0), look_at, Camera::Orthographic(OrthographicCamera { orthographic: 2.0 })];
    for camera in cameras {
        let samples = SampleSet::render(&flag, &with_camera(camera.clone()), 64, 1);
        let image = samples.image().unwrap();
        let covered = |x: u32, y: u32| image.coverage[(y * 64 + x) as usize] > 0.0;
        let [left, right, top, bottom] = bounds(&samples);
        assert!(covered(left, top + 1) && covered(right - 1, bottom), "{camera:?}");
        assert!(!covered(right, top), "{camera:?}");
    }
    // From the right side, +z is to the left. From above at azimuth 0, +z is down and +x to the
    // right.
    let marker = obj("v 0 0 0\nv 0 .4 3\nv 0 0 3\nv -3 0 0\nv -3 0 -.1\nf 1 2 3\nf 1 4 5\n");
    let seen = bounds(&SampleSet::render(&marker, &with_camera(orbit(90.0, 0.0)), 65, 1));
    assert!(seen[0] < 32 && seen[1] < 65 - seen[0], "{seen:?}");
    let above =
        bounds(&SampleSet::render(&flag_on_the_ground(), &with_camera(orbit(0.0, 90.0)), 65, 1));
    assert_eq!((above[0] < 22, above[3] > 42), (true, true), "{above:?}");
}

/// The triangle of the camera test laid on its back: y became -z.
fn flag_on_the_ground() -> Mesh {
    obj("v -1 0 1\nv 1 0 1\nv -1 0 -1\nf 1 2 3\n")
}

#[test]
fn local_directions_on_sphere_point_to_light_and_eye() {
    let scene = headlight(25.0, 10.0);
    let samples = SampleSet::render(&sphere(), &scene, 129, 1);
    assert_eq!(
        samples.counts().lit,
        samples.counts().covered,
        "a light at the eye must light every hit"
    );
    let image = samples.image().unwrap();
    let sample = |pixel: u32| {
        let span = image.spans().find(|span| span.pixel == pixel).unwrap();
        samples.pair(span.start as usize)
    };
    let (middle, uv) = sample(64 * 129 + 64);
    assert!(middle.wo().z > 0.999_999 && middle.wi().z > 0.999_9);
    assert!((uv - DVec2::new(0.5 + 25.0 / 360.0, 100.0 / 180.0)).length() < 1e-3, "{uv}");
    // Right of the middle, the eye is to the left: against u, which points to the right.
    let (right, right_uv) = sample(64 * 129 + 84);
    assert!(right.wo().x < -0.2 && right.wo().y.abs() < 0.1 && right_uv.x > uv.x, "{right:?}");
    let (upper, upper_uv) = sample(44 * 129 + 64);
    assert!(upper.wo().y < -0.2 && upper.wo().x.abs() < 0.1 && upper_uv.y > uv.y, "{upper:?}");
}

#[test]
fn default_irradiance_is_pi_at_centre_and_intensity_follows_inverse_square_law() {
    // A small square around the centre, facing the light.
    let square = obj("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    for (intensity, position, expected) in [
        (None, [0.0, 0.0, 5.0], std::f64::consts::PI),
        (Some([50.0, 0.0, 25.0]), [0.0, 0.0, 5.0], 2.0),
        (Some([50.0, 0.0, 25.0]), [3.0, 0.0, 4.0], 2.0 * 0.8),
    ] {
        let lights = vec![point(Some(position), intensity)];
        let scene = Scene { lights, ..with_camera(orbit(0.0, 0.0)) };
        let samples = SampleSet::render(&square, &scene, 65, 1);
        let image = samples.image().unwrap();
        let middle = image.spans().find(|span| span.pixel == 32 * 65 + 32).unwrap();
        let [r, g, b] = samples.irradiance().map(|e| f64::from(e[middle.start as usize]));
        assert!((r - expected).abs() < 1e-5, "{position:?} {r}");
        if intensity.is_some() {
            assert!(g == 0.0 && (b - 0.5 * r).abs() < 1e-6, "{g} {b}");
        }
    }
}

#[test]
fn picture_is_unchanged_when_object_camera_and_light_turn_together() {
    let mesh = Mesh::builtin(BuiltinMesh::Knob);
    let light = Light::point_at([3.0, 2.0, 4.0]);
    let base = Scene { lights: vec![light], ..with_camera(orbit(10.0, 20.0)) };
    let turned = Scene {
        rotation_deg: [0.0, 75.0, 0.0],
        camera: orbit(85.0, 20.0),
        ..base.with_light_deg(75.0)
    };
    let (a, b) = (SampleSet::render(&mesh, &base, 48, 1), SampleSet::render(&mesh, &turned, 48, 1));
    assert_eq!(a.image(), b.image());
    for index in 0..a.len() {
        let (here, there) = (a.pair(index).0, b.pair(index).0);
        assert!((here.wi() - there.wi()).length() < 1e-9, "{index} {here:?} {there:?}");
        assert!((here.wo() - there.wo()).length() < 1e-9, "{index} {here:?} {there:?}");
    }
    let other = SampleSet::render(&mesh, &base.with_light_deg(30.0), 48, 1);
    assert_ne!(a.counts().lit, other.counts().lit, "`light_deg` must move the light");
}

#[test]
fn object_rotates_and_scales_about_its_centre() {
    // Not at the world's origin. The default camera distance is for the mesh at scale 1.
    let cube = obj("v 7 7 7\nv 8 7 7\nv 8 9 7\nv 7 9 7\nf 1 2 3 4\n");
    let area = |scene: &Scene| SampleSet::render(&cube, scene, 400, 1).counts().covered as f64;
    let base = with_camera(orbit(0.0, 0.0));
    let half = area(&Scene { scale: 0.5, ..base.clone() });
    let ratio = area(&base) / half;
    assert!(
        (ratio - 4.0).abs() < 0.1,
        "half the scale must give a quarter of the area, ratio {ratio}"
    );
    let lying = bounds(&SampleSet::render(
        &cube,
        &Scene { rotation_deg: [0.0, 0.0, 90.0], ..base.clone() },
        100,
        1,
    ));
    assert!(lying[1] - lying[0] > 3 * (lying[3] - lying[2]) / 2, "{lying:?}");
    assert!(
        (lying[0] + lying[1]).abs_diff(99) <= 1,
        "the object must stay in the middle: {lying:?}"
    );
}

#[test]
fn open_surface_is_shaded_from_both_sides() {
    let square = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    for (face, azimuth) in [("f 1 2 3 4", 0.0), ("f 1 2 3 4", 180.0), ("f 4 3 2 1", 0.0)] {
        let samples =
            SampleSet::render(&obj(&format!("{square}{face}")), &headlight(azimuth, 0.0), 33, 1);
        assert!(samples.counts().covered > 200);
        assert_eq!(samples.counts().lit, samples.counts().covered, "{face} {azimuth}");
        assert!((0..samples.len()).all(|k| samples.pair(k).0.cos_o() > 0.9), "{face} {azimuth}");
    }
    // Normals against the winding: the visible side is still shaded.
    let against = format!("{square}vn 0 0 -1\nf 1//1 2//1 3//1 4//1");
    let samples = SampleSet::render(&obj(&against), &headlight(0.0, 0.0), 33, 1);
    assert!(samples.len() > 200 && (0..samples.len()).all(|k| samples.pair(k).0.cos_o() > 0.9));
}

#[test]
fn wo_is_clamped_above_horizon_when_interpolated_normal_faces_away() {
    // The triangle faces the eye, its normals lean beyond the horizon towards +x.
    let leaning = obj("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvn 1 0 .001\nf 1//1 2//1 3//1\n");
    let scene = Scene {
        lights: vec![Light::point_at([9.0, 0.0, 9.0])],
        camera: Camera::Orbit(OrbitCamera {
            orbit_deg: [-3.0, 0.0],
            distance: None,
            fov_y_deg: 1.0,
        }),
        ..Scene::default()
    };
    let samples = SampleSet::render(&leaning, &scene, 33, 1);
    assert!(samples.len() > 100);
    for index in 0..samples.len() {
        assert!((samples.pair(index).0.cos_o() - 1e-4).abs() < 1e-15);
    }
}

#[test]
fn tangent_is_that_of_the_triangle_or_interpolated() {
    // Both triangles face the eye; u grows along +x on one, along (2, 1) on the other.
    let square = obj("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt .5 2\n\
        f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    let from = DVec3::new(0.6, 0.0, 0.8);
    let light = format!(r#"{{"kind": "directional", "direction": {:?}}}"#, (-from).to_array());
    let scene = |tangents| Scene {
        camera: Camera::Orthographic(OrthographicCamera { orthographic: 1.2 }),
        lights: vec![serde_json::from_str(&light).unwrap()],
        tangents,
        ..Scene::default()
    };
    let set = SampleSet::render(&square, &scene(Tangents::Triangle), 33, 1);
    let mut seen = [0; 2];
    for index in 0..set.len() {
        let (pair, uv) = set.pair(index);
        let second = uv.y > uv.x + 1e-9;
        let u = if second { DVec2::new(2.0, 1.0).normalize() } else { DVec2::X };
        let expected = DVec3::new(0.6 * u.x, -0.6 * u.y, 0.8);
        assert!((pair.wi() - expected).length() < 1e-12, "{uv} {:?}", pair.wi());
        seen[usize::from(second)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
    // The vertices that both triangles share have tangents in between.
    let set = SampleSet::render(&square, &scene(Tangents::Vertex), 33, 1);
    let angles: Vec<f64> = (0..set.len()).map(|index| set.pair(index).0.wi().y).collect();
    let [low, high] = [f64::min, f64::max].map(|of| angles.iter().copied().reduce(of).unwrap());
    assert!(high - low > 0.05 && angles.iter().any(|y| (y - 0.5 * (low + high)).abs() < 0.01));
}

#[test]
fn tangent_depends_on_the_normal_alone_without_texture_coordinates() {
    for face in ["f 1 2 3", "f 1/1 2/1 3/1", "f 1/1 2/2 3/3"] {
        // Missing, equal and collinear texture coordinates.
        let text = format!("v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvt 2 2\n{face}\n");
        let [vertex, triangle] = [Tangents::Vertex, Tangents::Triangle].map(|tangents| {
            SampleSet::render(&obj(&text), &Scene { tangents, ..headlight(20.0, 10.0) }, 33, 1)
        });
        assert!(vertex.len() > 100);
        for index in 0..vertex.len() {
            let [a, b] = [&vertex, &triangle].map(|set| set.pair(index).0.wi());
            assert!((a - b).length() < 1e-12, "{face}: {a} {b}");
        }
    }
}

#[test]
fn fixed_set_is_bit_identical_for_any_number_of_threads() {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let scene = Scene { rotation_deg: [10.0, 20.0, 30.0], ..Scene::default() };
    let make = |threads: usize| {
        pool(threads).install(|| {
            let samples = SampleSet::render(&Mesh::builtin(BuiltinMesh::Knob), &scene, 64, 3);
            for input in Input::symmetric() {
                let _ = samples.input(input);
            }
            samples
        })
    };
    let (one, four) = (make(1), make(4));
    assert_eq!(one.image(), four.image());
    assert_eq!(one.pairs, four.pairs);
    assert_eq!(one.uvs, four.uvs);
    assert_eq!(one.irradiance(), four.irradiance());
    for input in Input::symmetric() {
        assert_eq!(one.input(input), four.input(input), "{}", input.name());
    }
    assert_eq!(one.input(Input::U)[7], one.pair(7).1.x as f32);
}

#[test]
fn first_ray_of_fixed_sampling_is_the_centre() {
    let mut scene = Scene::default();
    scene.lights.push(Light::point_at([-4.0, 0.0, 2.0]));
    let mesh = sphere();
    let (single, many) =
        (SampleSet::render(&mesh, &scene, 40, 1), SampleSet::render(&mesh, &scene, 40, 8));
    assert_invariants(&many);
    let image = many.image().unwrap();
    assert!(image.coverage.contains(&1.0));
    assert!(
        image.coverage.iter().any(|n| *n > 0.0 && *n < 1.0),
        "edge pixels must be partly covered"
    );
    assert!(
        image.spans().any(|span| span.centre_end - span.start == 2),
        "a centre lit by two lights must have two samples"
    );
    for span in single.image().unwrap().spans() {
        let fine = image.spans().find(|fine| fine.pixel == span.pixel).unwrap();
        assert_eq!(single.pair(span.start as usize), many.pair(fine.start as usize));
    }
}

#[test]
fn set_of_pairs_has_no_image_and_irradiance_one() {
    let pairs: Vec<DirectionPair> = [0.2, -0.5, 1.3f64]
        .iter()
        .map(|t| DirectionPair::new(DVec3::new(t.sin(), 0.0, t.cos()), DVec3::Z).unwrap())
        .collect();
    let samples = SampleSet::from_pairs(&pairs, &[]);
    assert_eq!((samples.len(), samples.is_empty(), samples.image()), (3, false, None));
    assert_eq!(samples.irradiance(), [&[1.0f32; 3][..]; 3]);
    assert_eq!(samples.input(Input::V), [0.0; 3]);
    assert_eq!(samples.input(Input::P1)[2], (1.3f64.cos() + 1.0) as f32);
    let with_uvs = SampleSet::from_pairs(&pairs, &[DVec2::ONE, DVec2::X, DVec2::Y]);
    assert_eq!(with_uvs.input(Input::V), [1.0, 0.0, 1.0]);
    assert!(SampleSet::from_pairs(&[], &[]).is_empty());
}

/// Triangles between random positions, with unrelated normals and tangents.
fn arbitrary_mesh() -> impl Strategy<Value = Mesh> {
    let unit = || {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0f64)
            .prop_map(|(x, y, z)| DVec3::new(x, y, z))
            .prop_filter("a direction", |w| w.length() > 0.1)
            .prop_map(DVec3::normalize)
    };
    let vertex = (unit(), unit(), prop::sample::select(vec![1e-6, 1.0, 1e6]));
    prop::collection::vec(vertex, 3..30).prop_map(|vertices| {
        let size = vertices[0].2;
        let count = vertices.len() as u32;
        let normals: Vec<DVec3> = vertices.iter().map(|vertex| vertex.1).collect();
        let tangents = normals.iter().map(|n| fixed_tangent(*n)).collect();
        let parts = MeshParts {
            positions: vertices.iter().map(|vertex| vertex.0 * size).collect(),
            uvs: vertices.iter().map(|vertex| vertex.0.truncate()).collect(),
            triangles: (0..count).map(|k| [k, (k + 1) % count, (k * 5 + 2) % count]).collect(),
            normals,
            tangents,
            has_uv: true,
        };
        Mesh::from_parts(parts).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn invariants_hold_for_any_mesh_and_scene(
        mesh in arbitrary_mesh(),
        rotation in prop::array::uniform3(-400.0..400.0f64),
        angles in (-180.0..180.0f64, -90.0..90.0f64),
        scale in prop::sample::select(vec![1e-3, 1.0, 30.0]),
        light in prop::option::of(prop::array::uniform3(-3.0..3.0f64)),
    ) {
        let intensity = light.map(|position| position.map(f64::abs));
        let scene = Scene {
            rotation_deg: rotation,
            scale,
            lights: vec![Light::default(), point(light, intensity)],
            ..with_camera(orbit(angles.0, angles.1))
        };
        prop_assert_eq!(scene.validate(), Ok(()));
        assert_invariants(&SampleSet::render(&mesh, &scene, 16, 2));
        assert_invariants(&SampleSet::render(&mesh, &scene, 16, Sampling::Adaptive));
    }
}

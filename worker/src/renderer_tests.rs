//! Tests of the renderer: pictures do not depend on batch, area, caches or backend.

use brood_eval::{Developed, encode_srgb};
use brood_genome::{BirthKey, Dialect, DialectConstraints, Genome, Variation};
use brood_mesh::BuiltinMesh;
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, PictureFormat};
use brood_scene::{Exposure, PictureSize, PixelArea, Sampling, Scene};

use crate::error::RenderError;
use crate::renderer::Renderer;
use crate::scene_view::LoadedMesh;

fn programs(count: u32) -> Vec<Program> {
    let random = Variation::random(Dialect::default());
    let birth = |slot| random.birth(BirthKey { seed: 3, slot, attempt: 0 });
    (0..count).map(|slot| Program::lower(&birth(slot))).collect()
}

fn frame(format: PictureFormat, backend: Backend) -> Frame {
    Frame::new(&Scene::default(), MeshSource::Builtin, 24, 2, (format, backend))
}

#[test]
fn picture_does_not_depend_on_rest_of_batch() {
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Knob);
    let frame = frame(PictureFormat::Png, Backend::Auto);
    let programs = programs(7);
    let all: Vec<&Program> = programs.iter().collect();
    let together = renderer.render(&frame, &mesh, &all).unwrap();
    for (picture, program) in together.iter().zip(&programs) {
        let alone = renderer.render(&frame, &mesh, &[program]).unwrap();
        assert_eq!(alone[0], *picture);
        assert_eq!(picture.key, frame.key(program));
        assert!(picture.samples > 0 && picture.operations >= picture.samples);
    }
}

#[test]
fn bumps_are_rendered_in_any_batch_and_area() {
    let constraints = DialectConstraints { bumps: Some(true), ..Default::default() };
    let random = Variation::random(Dialect::default()).with_constraints(constraints);
    let birth = |slot| random.birth(BirthKey { seed: 8, slot, attempt: 0 });
    let bumped: Vec<Program> = (0..4).map(|slot| Program::lower(&birth(slot))).collect();
    let flat: Vec<Program> = bumped.iter().map(|program| program.clone().without_bumps()).collect();
    let all: Vec<&Program> = bumped.iter().chain(&flat).collect();
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Knob);
    let lit = r#"{"lights": [{}, {"kind": "environment", "image": "studio"}]}"#;
    for scene in [Scene::default(), serde_json::from_str(lit).unwrap()] {
        let how = (PictureFormat::Png, Backend::Cpu);
        let frame = Frame::new(&scene, MeshSource::Builtin, 32, Sampling::Adaptive, how);
        let together = renderer.develop(&frame, &mesh, &all).unwrap();
        let area: PixelArea = "5,9,20,3".parse().unwrap();
        for (at, program) in all.iter().enumerate() {
            let fresh = Renderer::new(Backend::Cpu);
            let alone = fresh.develop(&frame, &mesh, &[program]).unwrap();
            assert_eq!(alone[0], together[at]);
            let part = fresh.develop(&frame.clone().with_area(Some(area)), &mesh, &[program]);
            let first = 4 * (9 * 32 + 5);
            assert_eq!(part.unwrap()[0].rgba[..80], together[at].rgba[first..first + 80]);
        }
        assert!((0..4).any(|at| together[at] != together[at + 4]), "bumps are visible");
    }
}

#[test]
fn bumps_turn_the_normal_of_a_lambertian() {
    // A height that grows along u: on the sphere's equator the normal turns by 45 degrees about
    // the pole, so that the picture under a far lamp is that of a lamp which has turned.
    let text = "brood 1\n.model lambert\nalbedo 1 1 1\n.bump MOV R0, R0.x\n";
    let program = Program::lower(&text.parse::<Genome>().unwrap());
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Sphere);
    let json = r#"{"mesh": "sphere", "camera": {"orthographic": 1.05},
        "lights": [{"kind": "directional", "direction": [0, 0, -1]}], "film": {"exposure": 0}}"#;
    let scene: Scene = serde_json::from_str(json).unwrap();
    let how = (PictureFormat::Png, Backend::Cpu);
    let side = 201;
    let frame = Frame::new(&scene, MeshSource::Builtin, side, Sampling::Fixed(1), how);
    let picture = renderer.develop(&frame, &mesh, &[&program]).unwrap().remove(0);
    let row = side / 2;
    let codes = (0..side).map(|x| picture.rgba[4 * (row * side + x) as usize..][..4].to_vec());
    let codes: Vec<Vec<u8>> = codes.collect();
    let covered: Vec<usize> = (0..codes.len()).filter(|x| codes[*x][3] == 255).collect();
    let (first, last) = (covered[0] as f64 - 0.5, covered[covered.len() - 1] as f64 + 0.5);
    let expected = |x: usize, turn: f64| {
        let across = (2.0 * (x as f64 - first) / (last - first) - 1.0).clamp(-1.0, 1.0);
        let angle = across.asin() + turn;
        let is_above = across.asin().cos() > 0.0;
        let cosine = if is_above { angle.cos().max(0.0) } else { 0.0 };
        // A directional light's irradiance is pi, so the radiance is the cosine.
        f64::from(encode_srgb(cosine as f32))
    };
    let off = |turn: f64| {
        let inner =
            covered.iter().filter(|x| (10..covered.len() - 10).contains(&(**x - covered[0])));
        inner.map(|x| (f64::from(codes[*x][0]) - expected(*x, turn)).abs()).fold(0.0, f64::max)
    };
    let quarter = std::f64::consts::FRAC_PI_4;
    let best = off(quarter).min(off(-quarter));
    assert!(best < 4.0 && off(0.0) > 40.0, "{best} {}", off(0.0));
}

#[test]
fn area_equals_crop_of_whole_picture() {
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Knob);
    let programs = programs(3);
    let programs: Vec<&Program> = programs.iter().collect();
    for exposure in [Exposure::Auto, Exposure::Ev(0.5)] {
        for sampling in [Sampling::Adaptive, Sampling::Fixed(1), Sampling::Fixed(5)] {
            let mut scene = Scene::default();
            scene.film.exposure = exposure;
            let how = (PictureFormat::Png, Backend::Cpu);
            let frame = Frame::new(&scene, MeshSource::Builtin, 40, sampling, how);
            let whole = renderer.develop(&frame, &mesh, &programs).unwrap();
            for area in ["0,0,40,40", "11,6,17,21", "0,19,40,1", "39,39,1,1", "20,0,1,40"] {
                let area: PixelArea = area.parse().unwrap();
                let frame = frame.clone().with_area(Some(area));
                let parts = renderer.develop(&frame, &mesh, &programs).unwrap();
                for (part, whole) in parts.iter().zip(&whole) {
                    assert_eq!((part.width, part.height), (area.width, area.height));
                    assert_eq!(part.exposure_ev, whole.exposure_ev, "{area} {sampling}");
                    let row = 4 * area.width as usize;
                    for (y, own) in part.rgba.chunks(row).enumerate() {
                        let start = 4 * ((area.y as usize + y) * 40 + area.x as usize);
                        assert_eq!(own, &whole.rgba[start..start + row], "{area} {sampling}");
                    }
                }
            }
        }
    }
    let beyond = "30,0,11,1".parse().ok();
    let frame = frame(PictureFormat::Png, Backend::Cpu).with_area(beyond);
    let refused = renderer.render(&frame, &mesh, &programs);
    assert!(matches!(refused, Err(RenderError::Area { .. })), "{refused:?}");
}

#[test]
fn pictures_under_an_environment_do_not_depend_on_batch_area_or_caches() {
    // With and without the inputs u and v: by tables and direct in one batch.
    let mixed = programs(4);
    let even = Dialect { isotropic: true, homogeneous: true, ..Dialect::default() };
    let random = Variation::random(even);
    let birth = |slot| random.birth(BirthKey { seed: 5, slot, attempt: 0 });
    let even: Vec<Program> = (0..3).map(|slot| Program::lower(&birth(slot))).collect();
    let all: Vec<&Program> = mixed.iter().chain(&even).collect();
    let lights = r#"{"mesh": "knob", "lights": [{"kind": "environment", "image": "studio", "samples": 4}, {}]}"#;
    let mut scene: Scene = serde_json::from_str(lights).unwrap();
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Knob);
    let area: PixelArea = "11,6,17,21".parse().unwrap();
    for exposure in [Exposure::Auto, Exposure::Ev(0.5)] {
        scene.film.exposure = exposure;
        let frame = |format: PictureFormat| {
            let how = (format, Backend::Cpu);
            Frame::new(&scene, MeshSource::Builtin, 40, Sampling::Adaptive, how)
        };
        let (linear_frame, frame) = (frame(PictureFormat::Exr), frame(PictureFormat::Png));
        let together = renderer.develop(&frame, &mesh, &all).unwrap();
        let part = frame.clone().with_area(Some(area));
        for (program, whole) in all.iter().zip(&together) {
            let fresh = Renderer::new(Backend::Cpu);
            assert_eq!(fresh.develop(&frame, &mesh, &[program]).unwrap()[0], *whole);
            assert_eq!(fresh.develop(&part, &mesh, &[program]).unwrap()[0], whole.crop(area));
            let linear = |frame: &Frame| {
                let image = fresh.images(frame, &mesh, &[program], |_, image| image.radiance());
                image.unwrap().remove(0)
            };
            let cut = linear(&linear_frame).crop(area);
            let part = linear(&linear_frame.clone().with_area(Some(area)));
            assert!(part.premultiplied() == cut.premultiplied(), "linear parts differ");
        }
    }
}

#[test]
fn area_of_a_wide_or_tall_picture_equals_its_crop() {
    // Stripes, so that pixels in all tiles are rough.
    let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 200 1 1 1\nMUL R0, R5.w, C0.x\nSIN R0, R0.x\n";
    let genome: Genome = text.parse().unwrap();
    let program = Program::lower(&genome);
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Sphere);
    let camera = serde_json::from_str(r#"{"camera": {"distance": 2.5}}"#);
    for scene in [Scene::default(), camera.unwrap()] {
        for (size, area) in [("75x40", "20,5,40,30"), ("40x75", "5,20,30,40")] {
            let size: PictureSize = size.parse().unwrap();
            let area: PixelArea = area.parse().unwrap();
            let how = (PictureFormat::Png, Backend::Cpu);
            let frame = Frame::new(&scene, MeshSource::Builtin, size, Sampling::Adaptive, how);
            let develop = |renderer: &Renderer, frame: &Frame| {
                renderer.develop(frame, &mesh, &[&program]).unwrap().remove(0)
            };
            let radiance = |renderer: &Renderer, frame: &Frame| {
                let linear =
                    renderer.images(frame, &mesh, &[&program], |_, image| image.radiance());
                linear.unwrap().remove(0)
            };
            let (whole, linear) = (develop(&renderer, &frame), radiance(&renderer, &frame));
            assert_eq!((whole.width, whole.height), (size.width, size.height));
            let part = frame.with_area(Some(area));
            let fresh = Renderer::new(Backend::Cpu);
            assert_eq!(develop(&fresh, &part), whole.crop(area), "{size}");
            let found = radiance(&Renderer::new(Backend::Cpu), &part);
            let expected = linear.crop(area);
            assert_eq!(found.premultiplied(), expected.premultiplied(), "{size}");
        }
    }
}

#[test]
fn adaptive_sampling_reduces_error_and_does_not_depend_on_caches() {
    // Stripes about two pixels wide in the middle of the sphere, finer towards its edges.
    let text = "brood 1\n.dialect paper smooth registers 7\n.const C0 200 1 1 1\nMUL R0, R5.w, C0.x\nSIN R0, R0.x\n";
    let genome: Genome = text.parse().unwrap();
    let program = Program::lower(&genome);
    let mut scene = Scene::default();
    scene.film.exposure = Exposure::Ev(-1.0);
    let develop = |renderer: &Renderer, sampling: Sampling, area: Option<PixelArea>| {
        let how = (PictureFormat::Png, Backend::Cpu);
        let frame = Frame::new(&scene, MeshSource::Builtin, 72, sampling, how).with_area(area);
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        renderer.develop(&frame, &mesh, &[&program]).unwrap().remove(0)
    };
    let renderer = Renderer::new(Backend::Cpu);
    let many = develop(&renderer, Sampling::Fixed(256), None);
    let error = |picture: &Developed| -> f64 {
        let pairs = picture.rgba.iter().zip(&many.rgba);
        pairs.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum()
    };
    let one = develop(&renderer, Sampling::Fixed(1), None);
    let adaptive = develop(&renderer, Sampling::Adaptive, None);
    assert!(error(&adaptive) < 0.6 * error(&one), "{} {}", error(&adaptive), error(&one));
    let fresh = Renderer::new(Backend::Cpu);
    let area: PixelArea = "30,30,20,9".parse().unwrap();
    assert_eq!(develop(&fresh, Sampling::Adaptive, Some(area)), adaptive.crop(area));
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = pool.install(|| develop(&fresh, Sampling::Adaptive, None));
        assert_eq!(again, adaptive, "{threads}");
    }
}

#[test]
fn pictures_of_gpu_and_cpu_are_byte_identical() {
    let gpu = Renderer::new(Backend::Gpu);
    let required = std::env::var("BROOD_REQUIRE_GPU").is_ok_and(|value| value == "1");
    assert!(gpu.worker_report().gpu || !required, "{:?}", gpu.report());
    let frame = frame(PictureFormat::Png, Backend::Auto);
    let programs = programs(5);
    let programs: Vec<&Program> = programs.iter().collect();
    let render = |renderer: &Renderer| {
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        renderer.render(&frame, &mesh, &programs).unwrap()
    };
    assert_eq!(render(&gpu), render(&Renderer::new(Backend::Cpu)));
}

#[test]
fn pictures_decode_to_requested_size() {
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Torus);
    let programs = programs(1);
    for backend in [Backend::Cpu, Backend::Reference] {
        let png = frame(PictureFormat::Png, backend);
        let picture = renderer.render(&png, &mesh, &[&programs[0]]).unwrap().remove(0);
        let (width, height, rgba) = brood_eval::decode_png(&picture.bytes).unwrap();
        assert_eq!((width, height), (24, 24));
        assert!(rgba.chunks(4).any(|pixel| pixel[3] > 0 && pixel[0] > 0));
        let exr = frame(PictureFormat::Exr, backend);
        let picture = renderer.render(&exr, &mesh, &[&programs[0]]).unwrap().remove(0);
        assert!(picture.bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]));
    }
}

#[test]
fn uploaded_mesh_is_rejected_when_content_hash_differs() {
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = LoadedMesh::new(brood_mesh::Mesh::builtin(BuiltinMesh::Cube));
    let hash = *mesh.hash();
    assert!(matches!(renderer.cache_uploaded(&[0; 32], mesh), Err(RenderError::MeshContent)));
    let mesh = LoadedMesh::new(brood_mesh::Mesh::builtin(BuiltinMesh::Cube));
    assert!(renderer.uploaded(&hash).is_none());
    renderer.cache_uploaded(&hash, mesh).unwrap();
    assert!(renderer.uploaded(&hash).is_some());
}

#[test]
fn direct_pictures_in_an_environment_are_close_to_many_samples() {
    // A texture of stripes, some of them finer than a pixel, and a streak along the tangents.
    let stripes = "brood 1\n.dialect paper smooth registers 7\n.const C0 24 0.3 1 1\nMUL R0, R5.w, C0.x\nSIN R0, R0.x\nMUL R0, R0, C0.y\n";
    let streak = "brood 1\n.model ward\nspecular 0.4 0.3 0.2\nalpha_x 0.1\nalpha_y 0.4\n";
    for (text, bound) in [(stripes, 2.5), (streak, 3.0)] {
        let program = Program::lower(&text.parse().unwrap());
        let lights = r#"{"film": {"exposure": 0},
            "lights": [{"kind": "environment", "image": "studio", "samples": 256}]}"#;
        let scene: Scene = serde_json::from_str(lights).unwrap();
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Sphere);
        let how = (PictureFormat::Png, Backend::Cpu);
        let frame = |sampling| Frame::new(&scene, MeshSource::Builtin, 48, sampling, how);
        let develop = |sampling| {
            renderer.develop(&frame(sampling), &mesh, &[&program]).unwrap().remove(0).rgba
        };
        let (found, expected) = (develop(Sampling::Adaptive), develop(Sampling::Fixed(16)));
        let (mut squares, mut count) = (0.0, 0.0);
        for (found, expected) in found.chunks(4).zip(expected.chunks(4)) {
            if found[3] == 255 && expected[3] == 255 {
                for (a, b) in found.iter().zip(expected) {
                    squares += f64::from(a.abs_diff(*b)).powi(2);
                    count += 1.0;
                }
            }
        }
        let error = f64::sqrt(squares / count);
        assert!(error < bound, "{error} codes:\n{text}");
        let light: f64 = expected.iter().map(|code| f64::from(*code)).sum();
        assert!(light / expected.len() as f64 > 40.0, "the picture is dark");
    }
}

#[test]
fn backdrop_fills_png_pictures_and_their_parts_and_changes_nothing_else() {
    let plain = r#"{"mesh": "knob", "film": {"exposure": 0},
        "lights": [{"kind": "environment", "image": "low-sun"}]}"#;
    let scene: Scene = serde_json::from_str(plain).unwrap();
    let kind = r#"{"backdrop": {"kind": "environment", "blur_deg": 8}, "#;
    let shown: Scene = serde_json::from_str(&plain.replacen('{', kind, 1)).unwrap();
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Knob);
    let programs = programs(1);
    let frame = |scene: &Scene, format| {
        Frame::new(scene, MeshSource::Builtin, 40, Sampling::Adaptive, (format, Backend::Cpu))
    };
    let develop =
        |frame: &Frame| renderer.develop(frame, &mesh, &[&programs[0]]).unwrap().remove(0);
    let clear = develop(&frame(&scene, PictureFormat::Png));
    let filled = develop(&frame(&shown, PictureFormat::Png));
    assert_eq!(filled.exposure_ev, clear.exposure_ev);
    for (clear, filled) in clear.rgba.chunks(4).zip(filled.rgba.chunks(4)) {
        assert_eq!(filled[3], 255);
        assert!(clear[3] < 255 || clear == filled, "the object is unchanged");
    }
    assert!(filled.rgba[..3].iter().any(|code| *code > 0), "the corner shows the sky");
    let area: PixelArea = "3,5,20,11".parse().unwrap();
    let part = frame(&shown, PictureFormat::Png).with_area(Some(area));
    assert_eq!(develop(&part), filled.crop(area));
    let linear = |scene: &Scene| {
        renderer.render(&frame(scene, PictureFormat::Exr), &mesh, &[&programs[0]]).unwrap()[0]
            .bytes
            .clone()
    };
    assert!(linear(&scene) == linear(&shown), "linear pictures stay transparent");
}

#[test]
fn refined_pixels_have_the_environment_once() {
    // A narrow highlight of the point light under an even sky: its pixels are refined.
    let text = "brood 1\n.model conductor\nroughness 0.03\n";
    let genome: Genome = text.parse().unwrap();
    let program = Program::lower(&genome);
    let lights = r#"{"film": {"exposure": -1},
        "lights": [{"kind": "environment", "image": "overcast", "samples": 64}, {}]}"#;
    let scene: Scene = serde_json::from_str(lights).unwrap();
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Sphere);
    let how = (PictureFormat::Png, Backend::Cpu);
    let frame = |sampling| Frame::new(&scene, MeshSource::Builtin, 64, sampling, how);
    let pictures = |frame: &Frame| {
        let developed = renderer.develop(frame, &mesh, &[&program]).unwrap().remove(0);
        let linear = renderer.images(frame, &mesh, &[&program], |_, image| image.radiance());
        (developed, linear.unwrap().remove(0))
    };
    let (developed, linear) = pictures(&frame(Sampling::Adaptive));
    let refined = renderer.take_stats().rough_pixels;
    assert!(refined > 20, "{refined} pixels show nothing");
    let (expected, expected_linear) = pictures(&frame(Sampling::Fixed(64)));
    let codes = developed.rgba.iter().zip(&expected.rgba);
    let sum: f64 = codes.map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    let mean = sum / developed.rgba.len() as f64;
    assert!(mean < 0.8, "{mean} codes");
    let all = |pixels: &[[f32; 3]]| -> f64 {
        pixels.as_flattened().iter().map(|channel| f64::from(*channel)).sum()
    };
    let ratio = all(linear.premultiplied()) / all(expected_linear.premultiplied());
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
}

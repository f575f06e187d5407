//! Tests of clear materials in pictures.

use brood_eval::decode_png;
use brood_genome::Genome;
use brood_genome::preset::Preset;
use brood_mesh::BuiltinMesh;
use brood_protocol::{Backend, Frame, MeshSource, ObjectSource, PictureFormat};
use brood_scene::{PixelArea, Sampling, Scene};

use super::*;

const SIDE: u32 = 48;

fn preset(name: &str) -> Program {
    Program::lower(Preset::find(name).expect("the preset exists").genome())
}

fn glass(parameters: &str) -> Program {
    let text = format!("brood 1\n.effect light\n.effect glass\n{parameters}\n");
    Program::lower(&text.parse::<Genome>().unwrap())
}

fn scene(json: &str) -> Scene {
    let scene: Scene = serde_json::from_str(json).unwrap();
    scene.validate().unwrap();
    scene
}

fn frame(scene: &Scene, materials: &[&Program], backend: Backend) -> Frame {
    let options = (PictureFormat::Png, backend);
    let object =
        |program: &&Program| ObjectSource { mesh: MeshSource::Builtin, words: program.to_words() };
    Frame::new(scene, MeshSource::Builtin, SIDE, Sampling::Adaptive, options)
        .with_objects(materials.iter().map(object).collect())
}

fn pixels(renderer: &Renderer, frame: &Frame, mesh: BuiltinMesh, of: &Program) -> Vec<[u8; 4]> {
    let mesh = renderer.builtin(mesh);
    let picture = renderer.render(frame, &mesh, &[of]).unwrap().remove(0);
    decode_png(&picture.bytes).unwrap().2.as_chunks().0.to_vec()
}

/// Number of pixels in which a channel differs by more than some codes.
fn different(one: &[[u8; 4]], other: &[[u8; 4]], codes: u8) -> usize {
    let differ =
        |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > codes);
    one.iter().zip(other).filter(differ).count()
}

const LAMP: &str = r#""lights": [{}], "backdrop": {"kind": "color", "color": [0.2, 0.6, 0.4]}"#;

#[test]
fn body_without_mirror_and_refraction_is_not_seen() {
    let renderer = Renderer::new(Backend::Cpu);
    let scene = scene(&format!("{{{LAMP}}}"));
    let frame = frame(&scene, &[], Backend::Cpu);
    let air = glass("from 0\nto 0\nindex 1\ndepth 64\ncolor #339966");
    for mesh in [BuiltinMesh::Sphere, BuiltinMesh::Cube, BuiltinMesh::Torus, BuiltinMesh::Knob] {
        let pixels = pixels(&renderer, &frame, mesh, &air);
        let seen = pixels
            .iter()
            .filter(|pixel| pixel.iter().zip([51, 153, 102, 255]).any(|(a, b)| a.abs_diff(b) > 1));
        assert_eq!(seen.count(), 0, "{mesh:?}");
    }
}

#[test]
fn depth_takes_half_of_the_light_per_length() {
    let renderer = Renderer::new(Backend::Cpu);
    let scene = scene(
        r#"{"lights": [{}], "backdrop": {"kind": "color", "color": [1, 1, 1]},
            "camera": {"orthographic": 1.2}}"#,
    );
    let frame = frame(&scene, &[], Backend::Cpu);
    let deep = glass("from 0\nto 0\nindex 1\ndepth 2\ncolor #000000");
    let pixels = pixels(&renderer, &frame, BuiltinMesh::Sphere, &deep);
    // Through the middle, 2 radii: half is left.
    let middle = pixels[(SIDE * SIDE / 2 + SIDE / 2) as usize];
    assert!(middle[..3].iter().all(|code| code.abs_diff(128) <= 1), "{middle:?}");
}

/// Rays that show nothing are not traced.
#[test]
fn rays_are_traced_for_glass_that_shows_something() {
    let scene = scene(&format!("{{{LAMP}}}"));
    let frame = frame(&scene, &[], Backend::Cpu);
    let rays = |parameters: &str| {
        let renderer = Renderer::new(Backend::Cpu);
        let _ = pixels(&renderer, &frame, BuiltinMesh::Sphere, &glass(parameters));
        renderer.take_stats().rays
    };
    let none = rays("strength 0");
    assert_eq!(rays("see 0\nmirror 0"), none);
    let (mirror, ways, both) = (rays("see 0") - none, rays("mirror 0") - none, rays("") - none);
    assert!(mirror > 500 && ways > mirror && both == mirror + ways, "{mirror} {ways} {both}");
}

const BESIDE: &str = r#"{"mesh": "sphere", "shadows": true, "ground": {},
    "objects": [{"mesh": "cube", "position": [0, 0, -2.2], "scale": 0.9, "stands": true}],
    "lights": [{"kind": "environment", "image": "studio", "shadows": false}, {}],
    "backdrop": {"kind": "environment"}, "camera": {"orbit_deg": [0, 10]}}"#;

#[test]
fn objects_and_ground_are_seen_through_the_body() {
    let scene = scene(BESIDE);
    let clear = glass("from 0\nto 0\nindex 1\ndepth 64");
    let ground = preset("matt-clay");
    let seen = |object: &str| {
        let renderer = Renderer::new(Backend::Cpu);
        let frame = frame(&scene, &[&preset(object), &ground], Backend::Cpu);
        pixels(&renderer, &frame, BuiltinMesh::Sphere, &clear)
    };
    let (toon, gold) = (seen("paint-toon"), seen("gold"));
    let middle = (SIDE * SIDE / 2 + SIDE / 2) as usize;
    assert!(different(&toon[middle..=middle], &gold[middle..=middle], 8) == 1);
    assert!(toon.iter().all(|pixel| pixel[3] == 255));

    let renderer = Renderer::new(Backend::Cpu);
    let whole = frame(&scene, &[&preset("gold"), &ground], Backend::Cpu);
    let area = PixelArea { x: 9, y: 13, width: 31, height: 17 };
    let part = pixels(&renderer, &whole.clone().with_area(Some(area)), BuiltinMesh::Sphere, &clear);
    let rows = (area.y..area.y + area.height).flat_map(|y| {
        let start = (y * SIDE + area.x) as usize;
        gold[start..start + area.width as usize].to_vec()
    });
    assert!(rows.eq(part), "a part is cut from the whole");
    let exact = frame(&scene, &[&preset("gold"), &ground], Backend::Reference);
    let exact = pixels(&renderer, &exact, BuiltinMesh::Sphere, &clear);
    let off = different(&exact, &gold, 1);
    assert!(off < 12, "{off} of {} pixels differ from the reference", gold.len());
}

#[test]
fn clear_objects_show_the_subject_and_shade_less() {
    let renderer = Renderer::new(Backend::Cpu);
    let scene = scene(
        r#"{"mesh": "sphere", "shadows": true, "ground": {},
            "objects": [{"mesh": "sphere", "position": [0, 0, 2.4], "scale": 0.7, "stands": true}],
            "lights": [{"position": [2, 6, 1]}], "camera": {"orbit_deg": [0, 14]}}"#,
    );
    let ground = preset("matt-clay");
    let with = |object: &Program, subject: &str| {
        let frame = frame(&scene, &[object, &ground], Backend::Cpu);
        pixels(&renderer, &frame, BuiltinMesh::Sphere, &preset(subject))
    };
    let (clear, opaque) = (preset("paint-glass"), preset("paint-toon"));
    let front = |pixels: &[[u8; 4]]| {
        // Pixels of the object in front.
        let rows = 7 * SIDE / 12..3 * SIDE / 4;
        let row = |y: u32| (SIDE / 2 - 4..SIDE / 2 + 4).map(move |x| (y * SIDE + x) as usize);
        rows.flat_map(row).map(|at| pixels[at]).collect::<Vec<_>>()
    };
    let through = ["gold", "paint-mist"].map(|subject| front(&with(&clear, subject)));
    assert!(different(&through[0], &through[1], 8) > 12);
    let through = ["gold", "paint-mist"].map(|subject| front(&with(&opaque, subject)));
    assert_eq!(different(&through[0], &through[1], 1), 0);

    let light = |pixels: &[[u8; 4]]| {
        pixels.iter().map(|pixel| u64::from(pixel[1])).sum::<u64>() as f64 / pixels.len() as f64
    };
    let alone = |subject: &str| {
        let mut scene = scene.clone();
        scene.objects.clear();
        let frame = frame(&scene, &[&ground], Backend::Cpu);
        pixels(&renderer, &frame, BuiltinMesh::Sphere, &preset(subject))
    };
    let (faded, dark) = (alone("paint-glass"), alone("paint-toon"));
    // The lower edge of the picture is ground, partly in the shadow of the subject.
    let lower = (SIDE * (SIDE - 12)) as usize..;
    assert!(light(&faded[lower.clone()]) > light(&dark[lower]) + 2.0);
}

#[test]
fn clear_programs_share_a_batch_with_others() {
    let renderer = Renderer::new(Backend::Cpu);
    let mesh = renderer.builtin(BuiltinMesh::Knob);
    let ground = preset("paint-gouache");
    let scene = scene(r#"{"mesh": "knob", "ground": {}, "lights": [{}]}"#);
    let frame = frame(&scene, &[&ground], Backend::Cpu);
    let programs = ["paint-glass", "gold", "paint-cartoon", "paint-jelly"].map(preset);
    let batch: Vec<&Program> = programs.iter().collect();
    let together = renderer.render(&frame, &mesh, &batch).unwrap();
    for (picture, program) in together.iter().zip(&programs) {
        let alone = Renderer::new(Backend::Cpu).render(&frame, &mesh, &[program]).unwrap();
        assert_eq!(alone[0].bytes, picture.bytes);
    }
}

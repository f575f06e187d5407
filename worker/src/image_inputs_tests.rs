//! Tests of control images in pictures.

use std::sync::Arc;

use brood_eval::{decode_image, decode_png, encode_png};
use brood_genome::Genome;
use brood_light::LightAssets;
use brood_mesh::BuiltinMesh;
use brood_protocol::{Backend, Frame, MeshSource, ObjectSource, PictureFormat};
use brood_scene::{Sampling, Scene};

use super::*;

const SIDE: u32 = 48;

/// Image with the hash of its file.
#[derive(Clone)]
struct Loaded(ImageHash, Arc<ImagePyramid>);

impl Loaded {
    fn hash(&self) -> ImageHash {
        self.0
    }
}

/// One colour, or two halves side by side.
fn image(left: [u8; 4], right: [u8; 4]) -> Loaded {
    let pixel = |at: u32| if at % 16 < 8 { left } else { right };
    let rgba: Vec<u8> = (0..16 * 16).flat_map(pixel).collect();
    let file = encode_png(16, 16, &rgba);
    Loaded(ImageHash::of(&file), Arc::new(decode_image(&file).unwrap()))
}

fn set_images<const COUNT: usize>(renderer: &Renderer, images: [&Loaded; COUNT]) {
    let mut assets = LightAssets::default();
    for Loaded(hash, image) in images {
        assets.insert_image(hash.to_string(), image.clone());
    }
    renderer.set_light_assets(assets);
}

fn style(lines: &str) -> Program {
    let text = format!("brood 1\n.effect light\npalette #000000 #ffffff\nbasis step\n{lines}");
    Program::lower(&text.parse::<Genome>().unwrap())
}

fn frame(json: &str, objects: &[&Program], backend: Backend) -> Frame {
    let scene: Scene = serde_json::from_str(json).unwrap();
    let options = (PictureFormat::Png, backend);
    let object =
        |program: &&Program| ObjectSource { mesh: MeshSource::Builtin, words: program.to_words() };
    Frame::new(&scene, MeshSource::Builtin, SIDE, Sampling::Adaptive, options)
        .with_objects(objects.iter().map(object).collect())
}

fn pixels(renderer: &Renderer, frame: &Frame, of: &Program) -> Vec<[u8; 4]> {
    let mesh = renderer.builtin(BuiltinMesh::Sphere);
    let picture = renderer.render(frame, &mesh, &[of]).unwrap().remove(0);
    decode_png(&picture.bytes).unwrap().2.as_chunks().0.to_vec()
}

fn count(pixels: &[[u8; 4]], color: [u8; 3]) -> usize {
    pixels.iter().filter(|pixel| pixel[..3] == color && pixel[3] == 255).count()
}

const RED: [u8; 4] = [200, 30, 40, 255];
const GREEN: [u8; 4] = [20, 160, 70, 255];
const LAMP: &str = r#"{"mesh": "sphere", "lights": [{}]}"#;

#[test]
fn images_take_the_places_of_colours() {
    let renderer = Renderer::new(Backend::Cpu);
    let plain = pixels(&renderer, &frame(LAMP, &[], Backend::Cpu), &style(""));
    let (dark, bright) = (count(&plain, [0; 3]), count(&plain, [255; 3]));
    assert!(dark > 100 && bright > 100, "{dark} {bright}");
    let (red, halves) = (image(RED, RED), image(GREEN, RED));
    set_images(&renderer, [&red, &halves]);
    for backend in [Backend::Cpu, Backend::Reference] {
        let frame = frame(LAMP, &[], backend);
        let with = |lines: &str| pixels(&renderer, &frame, &style(lines));
        let shaded = with(&format!("dark {}\n", red.hash()));
        // Pixels of the edge may have the colour of a side or not.
        assert!(count(&shaded, [200, 30, 40]).abs_diff(dark) < 4);
        assert!(count(&shaded, [255; 3]).abs_diff(bright) < 4);
        let lit = with(&format!("bright {}\n", red.hash()));
        assert!(count(&lit, [200, 30, 40]).abs_diff(bright) < 4);
        let half = with(&format!("bright {} 0.5\n", red.hash()));
        let near =
            |pixel: &&[u8; 4]| pixel.iter().zip([228, 143, 148]).all(|(a, b)| a.abs_diff(b) < 2);
        let near = half.iter().filter(near).count();
        assert!(near.abs_diff(bright) < 30, "{near} {bright}");
        let both = with(&format!("bright {}\ndark {}\n", red.hash(), halves.hash()));
        let (red_count, green) = (count(&both, [200, 30, 40]), count(&both, [20, 160, 70]));
        assert!(
            green > 100 && red_count + 4 > bright && red_count + green > (dark + bright) * 4 / 5
        );
        let rim = format!(".effect silhouette\nfrom 0\nto 0\nimage {}\n", red.hash());
        assert!(count(&with(&rim), [200, 30, 40]) > (dark + bright) * 9 / 10);
    }
}

#[test]
fn maps_scale_effects_and_shift_the_light() {
    let renderer = Renderer::new(Backend::Cpu);
    let grey =
        |code: u8, opacity: u8| image([code, code, code, opacity], [code, code, code, opacity]);
    let (black, white, clear) = (grey(0, 255), grey(255, 255), grey(0, 0));
    set_images(&renderer, [&black, &white, &clear]);
    let frame = frame(LAMP, &[], Backend::Cpu);
    let with = |lines: &str| pixels(&renderer, &frame, &style(lines));
    let rim = |map: Option<&Loaded>| {
        let map = map.map_or(String::new(), |map| format!("map {}\n", map.hash()));
        with(&format!(".effect silhouette\ncolor #0000ff\n{map}"))
    };
    let plain = rim(None);
    assert_eq!(rim(Some(&white)), plain);
    assert_eq!(rim(Some(&clear)), plain, "where it is transparent, a map changes nothing");
    assert_eq!(rim(Some(&black)), with(""));
    let brush = |map: &Loaded| count(&with(&format!("brush 1\nmap {}\n", map.hash())), [255; 3]);
    let bright = count(&with(""), [255; 3]);
    assert!(brush(&black) + 50 < bright && bright + 50 < brush(&white));
    assert_eq!(brush(&clear), bright);
}

#[test]
fn styles_of_other_images_share_a_batch_and_objects_have_images() {
    let renderer = Renderer::new(Backend::Cpu);
    let (red, green) = (image(RED, RED), image(GREEN, GREEN));
    set_images(&renderer, [&red, &green]);
    let of = |image: &Loaded| style(&format!("bright {}\n", image.hash()));
    let (first, second, plain) = (of(&red), of(&green), style(""));
    let batch = [&first, &plain, &second, &first];
    let mesh = renderer.builtin(BuiltinMesh::Sphere);
    let lamp = frame(LAMP, &[], Backend::Cpu);
    let together = renderer.render(&lamp, &mesh, &batch).unwrap();
    for (picture, program) in together.iter().zip(batch) {
        let alone = renderer.render(&lamp, &mesh, &[program]).unwrap();
        assert_eq!(alone[0].bytes, picture.bytes);
    }
    let scene = r#"{"mesh": "sphere", "lights": [{}], "ground": {}}"#;
    let ground = frame(scene, &[&second], Backend::Cpu);
    let picture = pixels(&renderer, &ground, &first);
    assert!(count(&picture, [200, 30, 40]) > 100 && count(&picture, [20, 160, 70]) > 100);

    // Through a clear body, and by brdf.
    let backdrop = r#"{"mesh": "sphere", "lights": [{}], "ground": {},
        "backdrop": {"kind": "color", "color": [1, 1, 1]}}"#;
    let glass = style(&format!(
        "dark {}\n.effect glass\nfrom 0\nto 0\nindex 1\nstrength 0.5\n",
        red.hash()
    ));
    let seen = pixels(&renderer, &frame(backdrop, &[&second], Backend::Cpu), &glass);
    assert!(seen.iter().any(|[r, g, _, _]| *r > 100 && *g < *r));
    let text = format!(
        "brood 1\n.model lambert\n.effect light\npalette #000000 #ffffff\nby brdf\nto 0.4\nbright {}\n",
        red.hash()
    );
    let toon = Program::lower(&text.parse::<Genome>().unwrap());
    assert!(pixels(&renderer, &lamp, &toon).iter().any(|[r, g, _, _]| *r > 120 && *g < *r / 2));
}

#[test]
fn missing_images_and_unread_ones() {
    let renderer = Renderer::new(Backend::Cpu);
    let (mesh, frame) = (renderer.builtin(BuiltinMesh::Sphere), frame(LAMP, &[], Backend::Cpu));
    let hash = image(RED, RED).hash();
    let error = renderer.render(&frame, &mesh, &[&style(&format!("dark {hash}\n"))]).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!("there is no control image {hash}; offline, give its file with --image")
    );
    // An effect without strength reads nothing.
    let idle = style(&format!(".effect silhouette\nstrength 0\nimage {hash}\n"));
    assert!(renderer.render(&frame, &mesh, &[&idle]).is_ok());
}

#[test]
fn images_cover_the_picture_behind_the_object() {
    let renderer = Renderer::new(Backend::Cpu);
    let halves = image(RED, GREEN);
    set_images(&renderer, [&halves]);
    let backdrop = format!(r#""backdrop": {{"kind": "image", "image": "{}"}}"#, halves.hash());
    let lamp = |more: &str| format!(r#"{{"mesh": "sphere", "lights": [{{}}], {backdrop}{more}}}"#);
    let plain = frame(&lamp(""), &[], Backend::Cpu);
    let side = SIDE as usize;
    for picture in [
        pixels(&renderer, &plain, &style("")),
        pixels(&renderer, &plain, &Program::lower(brood_genome::preset::neutral())),
    ] {
        assert!(picture[0] == RED && picture[side - 1] == GREEN, "{:?}", picture[0]);
        assert!(picture[side * side / 2] == RED && picture.iter().all(|pixel| pixel[3] == 255));
    }
    // A wide picture shows the middle of the image.
    let mut wide = plain.clone();
    wide.size_px = brood_scene::PictureSize { width: 2 * SIDE, height: SIDE };
    let picture = pixels(&renderer, &wide, &style(""));
    assert!(picture[side - 6] == RED && picture[side + 6] == GREEN);

    // Clear glass of index 1 shows the image as if it were not there, from every camera.
    let clear = style(".effect glass\nfrom 0\nto 0\nindex 1\ndepth 64\nstrength 1\n");
    for camera in
        ["", r#", "camera": {"orthographic": 1.2}"#, r#", "camera": {"orbit_deg": [40, 30]}"#]
    {
        let through = pixels(&renderer, &frame(&lamp(camera), &[], Backend::Cpu), &clear);
        let is_near = |pixel: &[u8; 4], color: [u8; 4]| {
            pixel.iter().zip(color).all(|(a, b)| a.abs_diff(b) <= 6)
        };
        let row = &through[side * side / 2..side * (side / 2 + 1)];
        let red = row.iter().filter(|pixel| is_near(pixel, RED)).count();
        let green = row.iter().filter(|pixel| is_near(pixel, GREEN)).count();
        assert!(red.abs_diff(side / 2) <= 2 && green.abs_diff(side / 2) <= 2, "{camera}: {row:?}");
    }
}

#[test]
fn pictures_without_their_backdrop_are_transparent() {
    let renderer = Renderer::new(Backend::Cpu);
    let scene =
        r#"{"mesh": "sphere", "lights": [{}], "backdrop": {"kind": "image", "image": "a"}}"#;
    let picture = pixels(&renderer, &frame(scene, &[], Backend::Cpu), &style(""));
    assert_eq!(picture[0][3], 0);
    let clear = image(RED, [0; 4]);
    set_images(&renderer, [&clear]);
    let scene = scene.replace("\"a\"", &format!("\"{}\"", clear.hash()));
    let picture = pixels(&renderer, &frame(&scene, &[], Backend::Cpu), &style(""));
    assert!(picture[0] == RED && picture[SIDE as usize - 1][3] == 0);
}

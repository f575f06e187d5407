//! Tests that clipped pixels are found after noise and compression, and that others are not.

use std::io::Cursor;

use brood_brdf::{Model, ModelKind};
use brood_eval::{decode_linear, encode_srgb, shade_brdf};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_scene::{PixelArea, Raster, SampleSet, Sampling, Scene};

use super::super::{ImageView, PixelStatus, View};
use super::*;

const SIDE_PX: u32 = 64;

/// Change of codes after clipping.
#[derive(Debug, Clone, Copy)]
enum Damage {
    None,
    /// Normal noise of this deviation in codes.
    Noise(f64),
    Jpeg(u8),
    /// Clipped pixels get a random code of 250 to 254.
    Below,
}

struct Case {
    mesh: Mesh,
    scene: Scene,
    /// Linear radiance, brightest 1 at exposure 0.
    radiance: Vec<[f64; 3]>,
}

impl Case {
    fn new(mesh: BuiltinMesh, scene: &str, model: &Model) -> Self {
        let mesh = Mesh::builtin(mesh);
        let scene: Scene = serde_json::from_str(scene).unwrap();
        let raster = Raster {
            size_px: SIDE_PX.into(),
            sampling: Sampling::Fixed(1),
            area: PixelArea::whole(SIDE_PX),
        };
        let set = SampleSet::render_with_assets(&mesh, &scene, &LightAssets::default(), raster);
        let image = shade_brdf(&set, &*model.brdf());
        let radiance: Vec<[f64; 3]> =
            image.premultiplied().iter().map(|rgb| rgb.map(f64::from)).collect();
        let most = radiance.iter().flatten().copied().fold(0.0, f64::max);
        let radiance = radiance.into_iter().map(|rgb| rgb.map(|value| value / most)).collect();
        Self { mesh, scene, radiance }
    }

    /// The picture with its brightest channel at `brightest`; clipped at 1.
    fn picture(&self, brightest: f64, damage: Damage) -> LinearPicture {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let mut code = |value: f64| {
            let clipped = (value * brightest).min(1.0);
            let code = f64::from(encode_srgb(clipped as f32));
            let code = match damage {
                Damage::Noise(deviation) => (code + deviation * random.normal()).round(),
                Damage::Below if code >= 255.0 => 250.0 + (5.0 * random.unit()).floor(),
                _ => code,
            };
            code.clamp(0.0, 255.0) as u8
        };
        let pixels: Vec<u8> = self.radiance.iter().flatten().map(|value| code(*value)).collect();
        let image = image::RgbImage::from_raw(SIDE_PX, SIDE_PX, pixels).unwrap();
        let mut bytes = Cursor::new(Vec::new());
        match damage {
            Damage::Jpeg(quality) => {
                let encoder =
                    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, quality);
                image.write_with_encoder(encoder).unwrap();
            }
            _ => image.write_to(&mut bytes, image::ImageFormat::Png).unwrap(),
        }
        decode_linear(bytes.get_ref(), SIDE_PX).unwrap()
    }

    /// Reads a picture of the case.
    fn view(
        &self,
        picture: &LinearPicture,
        clip_from: ClipFrom,
    ) -> Result<ImageView, ImageTargetError> {
        let view = View {
            mesh: &self.mesh,
            scene: &self.scene,
            assets: &LightAssets::default(),
            sampling: Sampling::Fixed(1),
            picture,
            mask: None,
            is_gain_unknown: false,
            refine: brood_scene::Refine::default(),
            clip_from,
        };
        ImageView::new(&view).map(|(view, _)| view)
    }

    /// Makes a picture and reads it; returns the view, the number of used pixels whose radiance is
    /// at least 5 % above the largest that can be shown, and of clipped pixels whose radiance is
    /// below it.
    fn read(&self, brightest: f64, damage: Damage, clip_from: ClipFrom) -> (ImageView, [usize; 2]) {
        let picture = self.picture(brightest, damage);
        let view = self.view(&picture, clip_from).unwrap();
        let above = |rgb: &[f64; 3], least: f64| rgb.iter().any(|value| value * brightest >= least);
        let both = || self.radiance.iter().zip(view.statuses());
        let missed =
            both().filter(|(rgb, status)| above(rgb, 1.05) && **status == PixelStatus::Used);
        let wrong =
            both().filter(|(rgb, status)| !above(rgb, 1.0) && **status == PixelStatus::Clipped);
        let counts = [missed.count(), wrong.count()];
        (view, counts)
    }
}

/// Xorshift generator of the noise.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.unit())
    }
}

fn conductor() -> Model {
    let model = Model::new(ModelKind::Conductor).with("eta", &[0.143, 0.375, 1.442]).unwrap();
    let model = model.with("k", &[3.983, 2.386, 1.603]).unwrap();
    model.with("roughness", &[0.3]).unwrap()
}

fn white() -> Model {
    Model::new(ModelKind::Lambert).with("albedo", &[0.9, 0.85, 0.8]).unwrap()
}

const SPHERE: &str =
    r#"{"film": {"exposure": 0}, "lights": [{"kind": "point", "position": [3, 3, 3]}]}"#;
/// A face of a cube, seen and lit from the front.
const FACE: &str = r#"{"film": {"exposure": 0}, "mesh": "cube", "camera": {"eye": [0, 0, 4], "target": [0, 0, 0]},
    "lights": [{"kind": "point", "position": [0.5, 0.5, 4]}]}"#;

#[test]
fn clipped_pixels_are_found_after_noise_and_compression() {
    let case = Case::new(BuiltinMesh::Sphere, SPHERE, &conductor());
    for brightest in [1.5, 4.0, 12.0] {
        for damage in [
            Damage::None,
            Damage::Noise(1.0),
            Damage::Noise(2.0),
            Damage::Jpeg(95),
            Damage::Jpeg(80),
            Damage::Below,
        ] {
            let (view, [missed, wrong]) = case.read(brightest, damage, ClipFrom::Auto);
            let (_, [before, _]) = case.read(brightest, damage, ClipFrom::LARGEST);
            let counts = view.counts();
            println!(
                "{brightest} {damage:?}: {:?}, {} clipped, {missed} missed, by code 255 alone {before}; {wrong} are wrong",
                view.clipped_from(),
                counts.clipped
            );
            assert!(missed as f64 <= 0.02 * counts.clipped as f64, "{brightest} {damage:?}");
            assert!(wrong as f64 <= 0.1 * counts.used as f64, "{brightest} {damage:?}");
        }
    }
}

#[test]
fn pictures_that_are_not_clipped_keep_their_pixels() {
    let cases = [
        Case::new(BuiltinMesh::Sphere, SPHERE, &conductor()),
        Case::new(BuiltinMesh::Sphere, SPHERE, &white()),
        Case::new(BuiltinMesh::Cube, FACE, &white()),
    ];
    for (index, case) in cases.iter().enumerate() {
        // Brightest codes 239, 244 and 250.
        for brightest in [0.863, 0.905, 0.956] {
            for damage in [Damage::None, Damage::Noise(1.0), Damage::Noise(2.0), Damage::Jpeg(90)] {
                let (view, [_, wrong]) = case.read(brightest, damage, ClipFrom::Auto);
                let used = view.counts().used;
                println!("{index} {brightest} {damage:?}: {wrong} of {used}");
                assert!(
                    wrong as f64 <= 0.02 * used as f64,
                    "{index} {brightest} {damage:?}: {wrong} of {used}"
                );
            }
        }
    }
}

#[test]
fn clip_from_sets_the_code_or_turns_clipping_off() {
    let case = Case::new(BuiltinMesh::Sphere, SPHERE, &conductor());
    let clipped = |setting| case.read(4.0, Damage::Noise(2.0), setting).0.counts().clipped;
    assert_eq!(clipped(ClipFrom::Off), 0);
    let [largest, lower] = [ClipFrom::LARGEST, ClipFrom::Code(245)].map(clipped);
    assert!(largest > 0 && lower > largest + 10, "{largest} {lower}");
    let (view, _) = case.read(4.0, Damage::Noise(2.0), ClipFrom::Code(245));
    assert_eq!(view.clipped_from()[0], Some(245));
}

#[test]
fn picture_of_linear_light_is_clipped_by_a_plateau_at_one() {
    let case = Case::new(BuiltinMesh::Sphere, SPHERE, &conductor());
    let read = |limit: f64, clip_from| {
        let pixel = |rgb: &[f64; 3]| rgb.map(|value| (4.0 * value).min(limit) as f32);
        let pixels: Vec<[f32; 3]> = case.radiance.iter().map(pixel).collect();
        let clipped = vec![false; pixels.len()];
        let (width, height, is_linear) = (SIDE_PX, SIDE_PX, true);
        let picture = LinearPicture { width, height, pixels, clipped, is_linear };
        case.view(&picture, clip_from).map(|view| view.counts().clipped)
    };
    assert!(read(1.0, ClipFrom::Auto).unwrap() > 20);
    assert_eq!(read(1e9, ClipFrom::Auto), Ok(0));
    assert_eq!(read(1.0, ClipFrom::Off), Ok(0));
    assert_eq!(read(1.0, ClipFrom::LARGEST), Ok(0));
    assert_eq!(read(1.0, ClipFrom::Code(250)), Err(ImageTargetError::ClipFrom(250)));
}

//! Tests that bundles round-trip, are deterministic, and are rejected when damaged.

use std::io::Cursor;

use brood_brdf::{Model, ModelKind};
use brood_eval::{Developed, decode_linear, encode_exr, encode_png, shade_brdf};
use brood_scene::{Exposure, PictureSize, PixelArea, Raster, Refine, SampleSet};

use super::*;
use crate::{ImageTargetError, TargetFile, TargetFileError, TargetKind};

const SIDE_PX: u32 = 40;
const UPLOADED: &str = "01890000-0000-7000-8000-000000000000";

/// A picture of a diffuse material, as EXR.
fn picture(scene: &Scene, mesh: &Mesh) -> Vec<u8> {
    let area = PixelArea::whole(SIDE_PX);
    let raster = Raster { size_px: SIDE_PX.into(), sampling: Sampling::Fixed(1), area };
    let set = SampleSet::render_with_assets(mesh, scene, &LightAssets::default(), raster);
    encode_exr(&shade_brdf(&set, &*Model::new(ModelKind::Lambert).brdf())).unwrap()
}

fn white(side: u32) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let white = image::GrayImage::from_pixel(side, side, image::Luma([255]));
    white.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// A view of an uploaded mesh.
fn view(light_deg: f64) -> BundledView {
    let json = format!(r#"{{"mesh": "{UPLOADED}", "light_deg": {light_deg}}}"#);
    let scene: Scene = serde_json::from_str(&json).unwrap();
    let mesh = Arc::new(Mesh::builtin(BuiltinMesh::Torus));
    let picture = picture(&scene, &mesh);
    BundledView {
        scene,
        mesh: Some(mesh),
        sampling: Sampling::Fixed(1),
        is_gain_unknown: false,
        clip_from: ClipFrom::Auto,
        crop: None,
        is_held_out: false,
        refine: Refine::default(),
        picture,
        mask: None,
    }
}

fn bundle() -> PictureBundle {
    let masked = BundledView { mask: Some(white(SIDE_PX)), is_held_out: true, ..view(30.0) };
    PictureBundle { views: vec![view(0.0), masked], ..PictureBundle::default() }
}

#[test]
fn bundle_round_trips_and_is_a_complete_target() {
    let bytes = bundle().encode().unwrap();
    assert_eq!(
        bytes,
        bundle().encode().unwrap(),
        "equal meshes at different addresses give the same bytes"
    );
    let again = PictureBundle::decode(&bytes).unwrap();
    assert_eq!(again.encode().unwrap(), bytes);
    let TargetFile { target, pictures, .. } = TargetFile::read(TargetKind::Image, &bytes).unwrap();
    let pictures = pictures.unwrap();
    let [first, second] = pictures.views.as_slice() else { panic!("two views") };
    assert!(second.is_masked && second.setting.is_held_out && !first.is_masked);
    assert!(Arc::ptr_eq(&first.setting.mesh, &second.setting.mesh), "both views share one mesh");
    assert_eq!(pictures.counts, first.view.counts(), "held-out views are not counted");
    let used = usize::try_from(pictures.counts.used).unwrap();
    assert_eq!(target.fitted.len() + target.held.len(), used);
    let f = target.fitted.values()[0];
    assert!(f.iter().all(|f| (f - target.fitted.largest()).abs() < 1e-3), "{f:?}");
    assert_eq!((first.size_px(), first.shown().rgba.len()), (SIDE_PX.into(), 4 * 40 * 40));
}

#[test]
fn shown_picture_has_the_exposure_of_its_film() {
    let assets = LightAssets::default();
    let shown = |view: &BundledView| view.read(&assets).unwrap().0.shown();
    let codes = |shown: &Developed| shown.rgba.chunks(4).map(|rgba| rgba[0]).collect::<Vec<_>>();
    // Automatic exposure of a radiance picture: almost white at its brightest.
    let automatic = shown(&view(0.0));
    let brightest = codes(&automatic).into_iter().max().unwrap();
    assert!((240..=255).contains(&brightest) && automatic.exposure_ev != 0.0, "{brightest}");
    // Fixed exposure.
    let mut darker = view(0.0);
    darker.scene.film.exposure = Exposure::Ev(automatic.exposure_ev - 1.0);
    assert!(codes(&shown(&darker)).into_iter().max().unwrap() < 200);
    // Display codes are returned unchanged, with known or unknown exposure.
    let png = encode_png(SIDE_PX, SIDE_PX, &automatic.rgba);
    for exposure in [Exposure::Auto, Exposure::Ev(1.5)] {
        let mut coded = BundledView { picture: png.clone(), ..view(0.0) };
        coded.scene.film.exposure = exposure;
        assert_eq!(shown(&coded).rgba, automatic.rgba);
    }
}

#[test]
fn clip_from_is_part_of_the_bundle_and_older_bundles_clip_at_255() {
    let with = |settings: [ClipFrom; 2]| {
        let mut bundle = bundle();
        for (view, clip_from) in bundle.views.iter_mut().zip(settings) {
            view.clip_from = clip_from;
        }
        let bytes = bundle.encode().unwrap();
        let again = PictureBundle::decode(&bytes).unwrap();
        let found: Vec<ClipFrom> = again.views.iter().map(|view| view.clip_from).collect();
        assert_eq!((found.as_slice(), again.encode().unwrap()), (&settings[..], bytes.clone()));
        bytes
    };
    let new = with([ClipFrom::Code(250), ClipFrom::Off]);
    assert!(new.starts_with(b"brood pictures/2\n") && new != with([ClipFrom::Auto; 2]));
    // Version 1 has no setting.
    let old = with([ClipFrom::LARGEST; 2]);
    assert!(old.starts_with(b"brood pictures/1\n"));
    assert!(old.len() < new.len());
}

#[test]
fn uncertainties_are_part_of_the_bundle_and_exact_bundles_stay_as_they_were() {
    let refine = Refine { light_deg: 2.0, fov: 0.01, ..Refine::default() };
    let mut rough = bundle();
    rough.views[1].refine = refine;
    let bytes = rough.encode().unwrap();
    assert!(bytes.starts_with(b"brood pictures/4\n"));
    let again = PictureBundle::decode(&bytes).unwrap();
    assert_eq!([0, 1].map(|k| again.views[k].refine), [Refine::default(), refine]);
    assert_eq!(again.encode().unwrap(), bytes);
    let (pictures, _) = again.target().unwrap();
    assert_eq!(pictures.views[1].setting.refine, refine);
    assert!(bundle().encode().unwrap().starts_with(b"brood pictures/2\n"));
    // Out of range.
    rough.views[1].refine.light_deg = 90.0;
    let refused = PictureBundle::decode(&rough.encode().unwrap()).unwrap_err().to_string();
    assert!(refused.contains("/light_deg"), "{refused}");
}

#[test]
fn crops_are_part_of_the_bundle_and_cut_picture_and_mask() {
    let area = PixelArea { x: 5, y: 3, width: 30, height: 34 };
    let scene: Scene = serde_json::from_str(r#"{"camera": {"distance": 3.9}}"#).unwrap();
    let picture = picture(&scene, &Mesh::builtin(BuiltinMesh::Sphere));
    let whole = decode_linear(&picture, SIDE_PX).unwrap();
    let cropped = |crop| BundledView {
        scene: scene.clone(),
        mesh: None,
        crop,
        mask: Some(white(SIDE_PX)),
        picture: picture.clone(),
        ..view(0.0)
    };
    let bundle = PictureBundle { views: vec![cropped(Some(area)), cropped(None)], ..bundle() };
    let bytes = bundle.encode().unwrap();
    assert!(bytes.starts_with(b"brood pictures/3\n"));
    let again = PictureBundle::decode(&bytes).unwrap();
    assert_eq!(again.encode().unwrap(), bytes);
    let crops: Vec<_> = again.views.iter().map(|view| view.crop).collect();
    assert_eq!(crops, [Some(area), None]);
    let (known, _) = again.views[0].read(&LightAssets::default()).unwrap();
    assert_eq!(known.size_px(), PictureSize { width: 30, height: 34 });
    let target = known.view.target();
    for (x, y) in [(0, 0), (29, 33), (11, 20)] {
        let expected = whole.pixels[(3 + y) * 40 + 5 + x].map(f64::from);
        assert_eq!(target[y * 30 + x], expected, "{x} {y}");
    }
    let outside = PixelArea { x: 11, ..area };
    let refused = |view: &BundledView| {
        view.read(&LightAssets::default()).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert!(refused(&cropped(Some(outside))).contains("the crop 11,3,30,34 must lie within"));
    let small = BundledView { mask: Some(white(30)), ..cropped(Some(area)) };
    assert!(refused(&small).contains("the mask has 30 x 30 pixels and the picture 40 x 40"));
}

#[test]
fn decode_rejects_damaged_bytes() {
    let bytes = bundle().encode().unwrap();
    let mut old = bytes.clone();
    old[15] = b'0';
    assert!(matches!(PictureBundle::decode(&old), Err(BundleError::Version)));
    let step = (bytes.len() / 50).max(1);
    for end in (MAGIC.len()..bytes.len()).step_by(step) {
        let cut = PictureBundle::decode(&bytes[..end]);
        assert!(matches!(cut, Err(BundleError::Malformed(_))), "{end}");
    }
    let longer = [bytes.as_slice(), b"x"].concat();
    assert!(matches!(PictureBundle::decode(&longer), Err(BundleError::Malformed(_))));
    let large = vec![0; BYTES_MOST + 1];
    assert!(matches!(PictureBundle::decode(&large), Err(BundleError::TooLarge(_))));
}

#[test]
fn encode_rejects_bundles_without_views_or_meshes() {
    let none = PictureBundle::default().encode();
    assert!(matches!(none, Err(BundleError::Views(0))));
    let many = PictureBundle { views: vec![view(0.0); 17], ..PictureBundle::default() };
    assert!(matches!(many.encode(), Err(BundleError::Views(17))));
    let mut bundle = bundle();
    bundle.views[1].mesh = None;
    assert!(matches!(bundle.encode(), Err(BundleError::Mesh(1))));
    let mut poled = PictureBundle { views: vec![view(0.0)], ..PictureBundle::default() };
    poled.views[0].scene = serde_json::from_str(r#"{"sphere_pole": "z"}"#).unwrap();
    assert!(matches!(poled.encode(), Err(BundleError::NotSphere(0))));
}

#[test]
fn error_names_the_unusable_picture() {
    let read = |bundle: &PictureBundle| {
        TargetFile::read(TargetKind::Image, &bundle.encode().unwrap()).err().unwrap()
    };
    let mut masked = bundle();
    masked.views[1].mask = Some(white(8));
    let TargetFileError::Bundle(BundleError::Pictures(PicturesError::View { index, error })) =
        read(&masked)
    else {
        panic!("a view is refused")
    };
    let is_size = matches!(error, ViewError::Target(ImageTargetError::MaskSize { .. }));
    assert!(index == 1 && is_size, "{error}");
    let mut held = bundle();
    held.views[0].is_held_out = true;
    assert!(read(&held).to_string().contains("nothing is left to fit"));
    let mut broken = bundle();
    broken.views[0].picture = b"no picture".to_vec();
    assert!(read(&broken).to_string().contains("the picture must be an EXR"));
}

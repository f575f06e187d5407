//! Pictures of the spread of a search: the darkest and the brightest of the matching materials, and
//! the map over theta_h and theta_d.

use brood_eval::{
    CanonicalEvaluator, Developed, EvalError, Evaluator, Gain, RadianceImage, develop_exposed,
    shade,
};
use brood_scene::{LobeShape, PictureSize, PixelArea, Raster, SampleSet, Sampling, Scene};
use brood_search::{NextPicture, Spread, SpreadMap};
use brood_target::KnownView;
use rayon::prelude::*;

/// Largest side of a picture under one light: under lamps without size, and under other lights,
/// which have many samples per pixel.
const SIDE_PX: u32 = 160;
const SOFT_SIDE_PX: u32 = 96;
/// Pixels of a cell of the map.
const CELL_PX: usize = 8;
/// Deviation of ln f that is shown as white: a factor of e.
const WHITE: f64 = 1.0;
/// Share of the samples that is shown as the brightest, times the number of cells.
const MANY: f64 = 8.0;

/// Renders the darkest and the brightest that a material could be under up to three lights, side by
/// side. The lights are those of `next`, sorted as by [`Spread::next_pictures`]. If `next` is
/// empty, the lights of the view are used.
///
/// # Errors
/// Returns [`EvalError`] if a program cannot be evaluated.
pub fn darkest_and_brightest(
    spread: &Spread,
    view: &KnownView,
    next: &[NextPicture],
) -> Result<[Developed; 2], EvalError> {
    let mut scenes = NextPicture::other_lights(next);
    if scenes.is_empty() {
        scenes.push(&view.setting.scene);
    }
    let each = scenes.iter().map(|scene| under_one_light(spread, view, scene));
    let each: Vec<[Developed; 2]> = each.collect::<Result<_, _>>()?;
    let (darkest, brightest): (Vec<Developed>, Vec<Developed>) =
        each.into_iter().map(|[darkest, brightest]| (darkest, brightest)).unzip();
    Ok([beside(&darkest), beside(&brightest)])
}

/// Pictures of one size, from left to right.
fn beside(pictures: &[Developed]) -> Developed {
    let row_bytes = 4 * pictures[0].width as usize;
    let rows = 0..pictures[0].height as usize;
    let row = |y: usize| {
        pictures.iter().flat_map(move |one| &one.rgba[y * row_bytes..(y + 1) * row_bytes])
    };
    let count = u32::try_from(pictures.len()).expect("there are few pictures");
    Developed {
        width: count * pictures[0].width,
        rgba: rows.flat_map(row).copied().collect(),
        ..pictures[0]
    }
}

/// The darkest and the brightest in a scene of the object of a view. Both have the automatic
/// exposure of the brightest. The exposure of the scene may be too dark for another light.
fn under_one_light(
    spread: &Spread,
    view: &KnownView,
    scene: &Scene,
) -> Result<[Developed; 2], EvalError> {
    let set = samples(view, scene);
    let draw = |program| -> Result<RadianceImage, EvalError> {
        let mut f = Vec::new();
        CanonicalEvaluator::default().eval(&[program], &set, &mut f)?;
        Ok(shade(&set, &f))
    };
    let drawn: Vec<RadianceImage> =
        spread.programs().par_iter().map(draw).collect::<Result<_, _>>()?;
    let rows: Vec<Vec<f32>> =
        drawn.iter().map(|image| image.premultiplied().as_flattened().to_vec()).collect();
    let [darkest, brightest] = Spread::range(&rows).map(|values| {
        let mut image = drawn[0].clone();
        for (pixel, rgb) in values.as_chunks::<3>().0.iter().enumerate() {
            image.put(pixel, *rgb);
        }
        image
    });
    let lit = brightest.premultiplied().iter().filter(|rgb| rgb[1] > 0.0);
    let brightness = |rgb: &[f32; 3]| rgb.iter().copied().fold(0.0, f32::max);
    let gain = Gain::automatic(lit.map(brightness).collect()).with_tone(scene.film.tone);
    Ok([darkest, brightest].map(|image| develop_exposed(&image, gain)))
}

fn samples(view: &KnownView, scene: &Scene) -> SampleSet {
    let whole = view.size_px();
    let most = if view.view.is_soft() { SOFT_SIDE_PX } else { SIDE_PX };
    let by = (f64::from(most) / f64::from(whole.longer())).min(1.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small side")]
    let side = |px: u32| ((f64::from(px) * by).round() as u32).max(1);
    let size_px = PictureSize { width: side(whole.width), height: side(whole.height) };
    let raster = Raster { size_px, sampling: Sampling::Adaptive, area: PixelArea::whole(size_px) };
    let (mesh, assets) = (&*view.setting.mesh, &view.setting.assets);
    match scene.is_prefilterable() {
        true => SampleSet::render_direct(mesh, scene, assets, raster, LobeShape::Round),
        false => SampleSet::render_with_assets(mesh, scene, assets, raster),
    }
}

/// Draws the map: theta_h to the right and theta_d downwards, 0 to 90 degrees. Green is where the
/// samples are, red how much ln f varies over the materials that match them.
#[must_use]
pub fn map_picture(map: &SpreadMap) -> Developed {
    let side = SpreadMap::CELLS * CELL_PX;
    let cells = (SpreadMap::CELLS * SpreadMap::CELLS) as f64;
    let mut rgba = Vec::with_capacity(4 * side * side);
    for y in 0..side {
        for x in 0..side {
            let cell = y / CELL_PX * SpreadMap::CELLS + x / CELL_PX;
            let seen = (map.seen[cell] * cells / MANY).min(1.0).sqrt();
            let open = (map.deviation[cell] / WHITE).min(1.0);
            let code = |share: f64| {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share of 255"
                )]
                let code = (share * 255.0).round() as u8;
                code
            };
            rgba.extend([code(open), code(seen), 32, u8::MAX]);
        }
    }
    let side = u32::try_from(side).expect("the map is small");
    Developed { width: side, height: side, rgba, exposure_ev: 0.0 }
}

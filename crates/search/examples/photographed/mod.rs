//! Pictures of materials on a ball under one lamp, searches for the material, and their error over
//! all directions; shared by examples.

use std::error::Error;
use std::sync::Arc;

use brood_brdf::{Brdf, Neural};
use brood_eval::{encode_exr, shade_brdf};
use brood_light::LightAssets;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_program::Program;
use brood_scene::{ClipFrom, PictureSize, PixelArea, Raster, Refine, SampleSet, Sampling, Scene};
use brood_search::Options;
use brood_search::Search;
use brood_search::analytic::PriorMaterials;
use brood_target::{
    KnownView, MeasuredTarget, Pictures, Samples, Strategy, ViewSetup, draw_pairs, metric,
};

const SIZE_PX: PictureSize = PictureSize { width: 64, height: 64 };
const LAMPS: [[f64; 3]; 3] = [[-2.0, 3.0, 4.0], [3.5, 1.0, 2.5], [0.3, 0.6, 5.0]];
const GENERATIONS: usize = 3;

pub type Failure = Box<dyn Error + Send + Sync>;

/// Calls `of` with the name of every STEP-th neural material and one of three scenes. The command
/// line gives STEP, then the files of weights.
pub fn each(
    mut of: impl FnMut(&str, &Neural, &Scene) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let step: usize = arguments.next().ok_or("STEP is missing")?.parse()?;
    for file in arguments {
        let bytes = std::fs::read(&file)?;
        let all: serde_json::Value = serde_json::from_slice(&bytes)?;
        let all = all["materials"].as_object().ok_or("the file has no materials")?;
        for (index, name) in all.keys().enumerate().step_by(step) {
            of(name, &Neural::read(&bytes, name)?, &scene(index / step)?)?;
        }
    }
    Ok(())
}

fn scene(number: usize) -> Result<Scene, Failure> {
    let lamp = LAMPS[number % LAMPS.len()];
    Ok(serde_json::from_str(&format!(
        r#"{{"camera": {{"eye": [0, 0.6, 5], "fov_y_deg": 26}}, "lights": [{{"kind": "point", "position": {lamp:?}}}]}}"#
    ))?)
}

/// Searches for the material of pictures in these scenes, with a prior by these materials.
pub fn searched(
    material: &dyn Brdf,
    scenes: &[&Scene],
    prior: PriorMaterials,
) -> Result<(Pictures, MeasuredTarget, Search), Failure> {
    let views = scenes.iter().map(|scene| photographed(material, scene));
    let (pictures, target) =
        Pictures::gather(views.collect::<Result<Vec<_>, _>>()?.into_iter().map(Ok))?;
    let options =
        Options { strategy: Strategy::Analytic, seed: 1, is_mirrored: true, ..Options::default() };
    let mut search = Search::with_prior(&target.fitted, &options, prior);
    for _ in 0..GENERATIONS {
        search.step();
    }
    Ok((pictures, target, search))
}

/// E_log of the best over all directions.
pub fn error(material: &dyn Brdf, search: &Search) -> f64 {
    let pairs = draw_pairs(2000, 9);
    let best = search.best().expect("the search has run");
    let found = Samples::of_program(&Program::lower(&best.genome), pairs.clone());
    let found = found.expect("the CPU runs every program");
    metric::e_log(&Samples::of(material, pairs).weighted(), &found.weighted())
}

/// A picture of the material, read.
fn photographed(material: &dyn Brdf, scene: &Scene) -> Result<(KnownView, Samples), Failure> {
    let mesh = Arc::new(Mesh::builtin(BuiltinMesh::Sphere));
    let sampling = Sampling::Adaptive;
    let raster = Raster { size_px: SIZE_PX, sampling, area: PixelArea::whole(SIZE_PX) };
    let set = SampleSet::render_with_assets(&*mesh, scene, &LightAssets::default(), raster);
    let picture = encode_exr(&shade_brdf(&set, material))?;
    let setting = ViewSetup {
        scene: scene.clone(),
        mesh,
        assets: LightAssets::default(),
        sampling,
        is_gain_unknown: false,
        clip_from: ClipFrom::Off,
        crop: None,
        is_held_out: false,
        refine: Refine::default(),
    };
    Ok(KnownView::read(setting, &picture, None)?)
}

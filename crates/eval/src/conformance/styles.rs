//! Styles of the suite: painted materials with random parameters, in one to eight lights.

use brood_brdf::{LightInput, Lighting, Parameter, ParameterValues};
use brood_genome::{
    BirthKey, Effect, EffectImage, EffectKind, Genome, IMAGES_MAX, ImageHash, Input, Operator,
    Palette, ParameterKind, RANGE, Stream, Variation,
};
use brood_program::Program;
use brood_scene::SampleSet;

use super::bits::first_difference;
use super::cases::hard_samples;
use crate::evaluator::Evaluator;

/// Lights of the sets of the suite.
const LIGHTINGS: [Lighting; 4] = [
    Lighting { lights: 0, has_shadows: false },
    Lighting { lights: 1, has_shadows: false },
    Lighting { lights: 2, has_shadows: true },
    Lighting { lights: 8, has_shadows: true },
];

/// Returns a painted genome with random effects and palette; half of them have a program, and those
/// that paint a BRDF always. A quarter of the numbers are at the ends of their ranges.
#[must_use]
pub fn wild_style(seed: u64) -> Genome {
    let key = BirthKey { seed, slot: 0, attempt: 0 };
    let mut stream = Stream::new(key, Operator::RandomLayers);
    let stream = &mut stream;
    let count = 2 + stream.below(7) as usize;
    let mut color = || [0; 3].map(|_: u8| u8::try_from(stream.below(256)).expect("below 256"));
    let colors = (0..count).map(|_| color()).collect();
    let mut edges: Vec<f64> = (1..count).map(|_| share(stream)).collect();
    edges.sort_by(f64::total_cmp);
    let palette = Palette::new(Some(colors), Some(edges)).expect("the edges ascend");
    let mut effects = vec![effect(EffectKind::Light, Some(palette), stream)];
    for kind in &EffectKind::ALL[1..] {
        if stream.below(2) == 0 {
            let place = 1 + stream.below(effects.len() as u32) as usize;
            effects.insert(place, effect(*kind, None, stream));
        }
    }
    if seed.is_multiple_of(3) {
        add_images(&mut effects, key);
    }
    if stream.below(2) == 0 && !effects[0].is_by_brdf() {
        return Genome::of_effects(effects).expect("the first effect is light");
    }
    let program = Variation::random(brood_genome::Dialect::default()).birth(key);
    let (dialect, constants) = (*program.dialect(), Box::new(*program.constants()));
    Genome::painted(dialect, program.instructions().to_vec(), constants, effects)
        .expect("the first effect is light")
}

/// Puts up to four images into random places, drawn apart from the rest of a style.
fn add_images(effects: &mut [Effect], key: BirthKey) {
    let mut stream = Stream::new(BirthKey { attempt: 1, ..key }, Operator::RandomLayers);
    for effect in effects {
        let mut images = Vec::new();
        for place in effect.kind().image_places() {
            let image = ImageHash::of(&[stream.below(IMAGES_MAX as u32) as u8]);
            let share = share(&mut stream);
            if stream.below(2) == 0 {
                images.push(EffectImage { place: place.name, image, share });
            }
        }
        let made = effect.clone().with_images(images);
        *effect = made.expect("the places are those of the effect");
    }
}

/// Returns an effect with random values.
fn effect(kind: EffectKind, palette: Option<Palette>, stream: &mut Stream) -> Effect {
    let mut values = ParameterValues::new(kind.name(), kind.parameters());
    for parameter in kind.parameters() {
        let drawn: Vec<f64> = (0..parameter.count()).map(|_| value(parameter, stream)).collect();
        values.set(parameter.name, &drawn).expect("values are drawn from the range");
    }
    let end = |name| values.get(name).map_or(0.0, |values| values[0]);
    let (from, to) = (end("from"), end("to"));
    values.set("from", &[from.min(to)]).expect("the ends are within one range");
    values.set("to", &[from.max(to)]).expect("the ends are within one range");
    Effect::new(kind, values, palette).expect("the ends ascend")
}

fn value(parameter: &Parameter, stream: &mut Stream) -> f64 {
    match parameter.kind {
        ParameterKind::Choice { words } => {
            f64::from(stream.below(u32::try_from(words.len()).expect("there are few words")))
        }
        _ => parameter.at_share(share(stream)),
    }
}

fn share(stream: &mut Stream) -> f64 {
    match stream.below(8) {
        0 => 0.0,
        1 => 1.0,
        _ => f64::from(stream.unit()),
    }
}

/// Largest length of a way in a clear body that sees something, in radii of the body.
const WAY_MAX: f32 = 8.0;

/// Returns points in lights of random directions, colours and visibilities: a quarter of the values
/// at the ends of their ranges, half of the gradients 0. Levels of lights are their largest
/// channels.
#[must_use]
pub fn lit_points(seed: u64, size: usize, lighting: Lighting) -> SampleSet {
    let key = BirthKey { seed, slot: size as u32, attempt: 0 };
    let mut stream = Stream::new(key, Operator::RandomConstants);
    let mut column = |input: Input, low: f32| {
        let mut value = || match stream.below(8) {
            0 => low,
            1 => 1.0,
            2 => 0.0,
            _ => low + (1.0 - low) * stream.unit(),
        };
        (input, (0..size).map(|_| value()).collect())
    };
    let mut columns: Vec<(Input, Vec<f32>)> = vec![
        column(Input::NormalDotEye, 0.0),
        column(Input::Depth, -1.0),
        column(Input::NormalDotEyeStep, 0.0),
        column(Input::DepthStep, 0.0),
        column(Input::ReflectedStep, 0.0),
    ];
    columns.extend(Input::REFLECTED.map(|input| column(input, 0.0)));
    columns.extend(Input::of_glass().map(|input| column(input, 0.0)));
    let lengths = [Input::MirroredLength, Input::Way0Length, Input::Way1Length];
    for (_, values) in columns.iter_mut().filter(|(input, _)| lengths.contains(input)) {
        values.iter_mut().for_each(|v| *v = if *v < 1.0 { WAY_MAX * *v } else { RANGE });
    }
    for light in 0..lighting.lights {
        let mut of_light = |quantity, low| column(Input::of_light(light, quantity), low);
        columns.extend([LightInput::Cos, LightInput::Mirror].map(|cosine| of_light(cosine, -1.0)));
        let steps = [LightInput::Visibility, LightInput::CosStep, LightInput::MirrorStep];
        columns.extend(steps.map(|quantity| of_light(quantity, 0.0)));
        let channels = [LightInput::Red, LightInput::Green, LightInput::Blue];
        let channels = channels.map(|channel| of_light(channel, 0.0));
        let largest = |k: usize| channels.iter().fold(0.0, |most: f32, (_, v)| most.max(v[k]));
        let level = Input::of_light(light, LightInput::Level);
        columns.push((level, (0..size).map(largest).collect()));
        columns.extend(channels);
    }
    for image in Input::IMAGES {
        // Colours of an image are times its opacity.
        let [mut red, mut green, mut blue, opacity] = image.map(|input| column(input, 0.0));
        for (_, color) in [&mut red, &mut green, &mut blue] {
            color.iter_mut().zip(&opacity.1).for_each(|(value, opacity)| *value *= opacity);
        }
        columns.extend([red, green, blue, opacity]);
    }
    hard_samples(seed, size).with_lights(lighting, columns)
}

/// Returns one style for each colour of a genome's palette: the light effect alone, with this
/// colour white and all others black. The result of a style is the weight of its colour.
///
/// # Panics
/// If the genome is not painted.
#[must_use]
pub fn weight_probes(genome: &Genome) -> Vec<Program> {
    let light = &genome.effects()[0];
    let palette = light.palette().expect("the first effect is light");
    let count = palette.colors().len();
    let probe = |white: usize| {
        let colors = (0..count).map(|at| [if at == white { 255 } else { 0 }; 3]).collect();
        let palette = Palette::new(Some(colors), Some(palette.edges().to_vec()))
            .expect("the edges are those of a palette");
        let light = Effect::new(light.kind(), light.values().clone(), Some(palette))
            .expect("the values are those of an effect");
        let constants = Box::new(*genome.constants());
        let instructions = genome.instructions().to_vec();
        let probe = Genome::painted(*genome.dialect(), instructions, constants, vec![light]);
        Program::lower(&probe.expect("the first effect is light"))
    };
    (0..count).map(probe).collect()
}

/// Returns the least and the largest value of each channel of a painted genome's colours.
#[must_use]
pub fn color_bounds(genome: &Genome) -> [(f32, f32); 3] {
    let mut all: Vec<[f64; 3]> = Vec::new();
    for effect in genome.effects() {
        if effect.kind() == EffectKind::Glass {
            // Rays see any colour, and black is added where they are dimmed.
            all.extend([[0.0; 3], [1.0; 3]]);
        }
        if !effect.images().is_empty() {
            // Images have any colour.
            all.extend([[0.0; 3], [1.0; 3]]);
        }
        match effect.palette() {
            Some(palette) => all.extend(
                palette.colors().iter().map(|color| color.map(|code| f64::from(code) / 255.0)),
            ),
            None => all.push(effect.color("color")),
        }
    }
    [0, 1, 2].map(|channel| {
        let values = all.iter().map(|color| color[channel] as f32);
        let low = values.clone().fold(f32::INFINITY, f32::min);
        (low, values.fold(0.0, f32::max))
    })
}

/// Checks colours: within [0, 1]; of an exact evaluator, also every bit.
pub(super) fn check(evaluator: &dyn Evaluator) {
    let styles: Vec<Program> = (0..40).map(|seed| Program::lower(&wild_style(seed))).collect();
    let batch: Vec<&Program> = styles.iter().collect();
    for lighting in LIGHTINGS {
        let set = lit_points(7, 300, lighting);
        let mut out = Vec::new();
        evaluator.eval(&batch, &set, &mut out).expect("the batch is evaluated");
        for (seed, (style, colors)) in styles.iter().zip(out.chunks(3 * set.len())).enumerate() {
            assert!(colors.iter().all(|color| (0.0..=1.0).contains(color)), "style {seed}");
            let program = style.painted(lighting);
            if !evaluator.is_exact() {
                continue;
            }
            if let Some((sample, got, expected)) = first_difference(&program, &set, colors) {
                let name = evaluator.name();
                panic!("{name}: style {seed}, sample {sample}: {got:?}, expected {expected:?}");
            }
        }
    }
}

#[cfg(test)]
#[path = "styles_tests.rs"]
mod tests;

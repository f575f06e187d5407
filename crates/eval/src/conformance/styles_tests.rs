//! Properties of painted materials: weights, box and hull, the terminator, the error of f32.

use super::*;
use crate::{CanonicalEvaluator, ReferenceEvaluator};

/// Largest sum of the errors of the weights of a palette: a few roundings of f32.
const WEIGHT_ERROR: f32 = 2.4e-7;

fn colors(programs: &[Program], set: &SampleSet) -> Vec<Vec<f32>> {
    let batch: Vec<&Program> = programs.iter().collect();
    let mut out = Vec::new();
    CanonicalEvaluator::default().eval(&batch, set, &mut out).unwrap();
    out.chunks(3 * set.len()).map(<[f32]>::to_vec).collect()
}

#[test]
fn weights_of_a_palette_sum_to_one() {
    for seed in 0..200 {
        let genome = wild_style(seed);
        let lighting = LIGHTINGS[seed as usize % LIGHTINGS.len()];
        let set = lit_points(seed, 64, lighting);
        let probes = weight_probes(&genome);
        let weights = colors(&probes, &set);
        for at in 0..3 * set.len() {
            let of_value = weights.iter().map(|weights| weights[at]);
            assert!(
                of_value.clone().all(|weight| weight >= 0.0),
                "seed {seed} value {at}\n{genome}"
            );
            let sum: f32 = of_value.sum();
            assert!((sum - 1.0).abs() <= WEIGHT_ERROR, "seed {seed} value {at}: {sum}\n{genome}");
        }
    }
}

#[test]
fn colours_stay_in_the_box_of_the_control_colours() {
    for seed in 0..200 {
        let genome = wild_style(seed);
        let set = lit_points(seed, 64, LIGHTINGS[seed as usize % LIGHTINGS.len()]);
        let colors = colors(&[Program::lower(&genome)], &set).remove(0);
        for (channel, (low, high)) in color_bounds(&genome).into_iter().enumerate() {
            for color in &colors[channel * set.len()..(channel + 1) * set.len()] {
                let slack = 4e-7;
                assert!((low - slack..=high + slack).contains(color), "seed {seed}\n{genome}");
            }
        }
    }
}

/// Grey weights: colours on the line between two colours stay on it.
#[test]
fn colours_stay_in_the_hull_of_the_palette_unless_lights_tint_them() {
    let text = |property: &str| {
        let text = format!(
            "brood 1\n.effect light\npalette #104080 #f08020\nbasis cubic\nfeather 0.4\n\
             property {property}\n"
        );
        Program::lower(&text.parse::<Genome>().unwrap())
    };
    let set = lit_points(3, 200, Lighting { lights: 3, has_shadows: true });
    let distances = [text("hull"), text("box")].map(|program| {
        let colors = colors(&[program], &set).remove(0);
        let (dark, bright) = ([16.0, 64.0, 128.0], [240.0, 128.0, 32.0]);
        let share = |sample: usize, channel: usize| {
            let (low, high): (f32, f32) = (dark[channel] / 255.0, bright[channel] / 255.0);
            (colors[channel * set.len() + sample] - low) / (high - low)
        };
        (0..set.len()).map(|sample| (share(sample, 0) - share(sample, 2)).abs()).fold(0.0, f32::max)
    });
    assert!(distances[0] < 1e-5 && distances[1] > 0.2, "{distances:?}");
}

/// Colours near the terminator, whatever the visibility just beyond it.
#[test]
fn shadows_end_at_the_terminator_without_a_jump() {
    let text = "brood 1\n.effect light\npalette #000000 #ffffff\nbasis linear\nfeather 1\n\
                from -0.5\nto 0.5\n";
    let program = Program::lower(&text.parse::<Genome>().unwrap());
    let cosines: Vec<f32> = (-64..=64).map(|step| step as f32 / 1024.0).collect();
    let lighting = Lighting { lights: 1, has_shadows: true };
    for visibility in [0.0, 0.3, 1.0] {
        let count = cosines.len();
        let columns = [
            (Input::Light0Cos, cosines.clone()),
            (Input::Light0Visibility, vec![visibility; count]),
            (Input::Light0Level, vec![1.0; count]),
            (Input::Light0CosStep, vec![0.0; count]),
        ];
        let set = hard_samples(1, count).with_lights(lighting, columns);
        let found = colors(std::slice::from_ref(&program), &set).remove(0);
        let jumps = found[..count].windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let largest = jumps.fold(0.0, f32::max);
        assert!(largest < 1.5 / 1024.0, "visibility {visibility}: {largest}");
    }
}

/// f32 against f64: no amplification beyond the steepest ramp.
#[test]
fn colours_are_near_the_reference() {
    let mut worst: f32 = 0.0;
    for seed in 0..100 {
        let genome = wild_style(seed);
        if genome.instructions().is_empty() {
            let set = lit_points(seed, 64, LIGHTINGS[seed as usize % LIGHTINGS.len()]);
            let program = Program::lower(&genome);
            let canonical = colors(std::slice::from_ref(&program), &set).remove(0);
            let mut reference = Vec::new();
            ReferenceEvaluator.eval(&[&program], &set, &mut reference).unwrap();
            let apart = canonical.iter().zip(&reference).map(|(a, b)| (a - b).abs());
            worst = worst.max(apart.fold(0.0, f32::max));
        }
    }
    // Ramps are at least 1/1024 wide: 2^-24 times 1024, through three ramps.
    assert!(worst < 4e-4, "{worst}");
    println!("largest difference {worst:e}");
}

#[test]
fn styles_are_refused_on_samples_of_light() {
    let mesh = brood_mesh::Mesh::builtin(brood_mesh::BuiltinMesh::Sphere);
    let set = SampleSet::render(&mesh, &brood_scene::Scene::default(), 8, 1);
    let style = Program::lower(&wild_style(1));
    let error = CanonicalEvaluator::default().eval(&[&style], &set, &mut Vec::new()).unwrap_err();
    assert!(error.to_string().contains("samples of points"), "{error}");
}

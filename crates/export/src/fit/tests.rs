//! Fits against the materials that they are made of.

use brood_brdf::DirectionPair;
use brood_eval::{express, limited};
use brood_genome::Genome;
use brood_genome::preset::Preset;
use glam::DVec3;

use super::sum::inclination_of;
use super::*;
use crate::reflectance::{direction, spread};

fn expressed(text: &str) -> Program {
    let genome: Genome = format!("brood 1\n{text}").parse().unwrap();
    limited(express(&genome))
}

fn preset(name: &str) -> Program {
    limited(express(Preset::find(name).unwrap().genome()))
}

#[test]
fn fits_are_as_near_as_recorded_and_state_their_error() {
    for (program, bound) in [
        (expressed(".model lambert\n"), 1e-3),
        (preset("model-chrome"), 0.012),
        (preset("model-gold"), 0.02),
        (preset("gold"), 0.1),
        (preset("red-plastic"), 0.18),
        (preset("velvet"), 0.12),
    ] {
        let fit = fitted(&program, Format::Blender).unwrap();
        let deviation = Deviation::of(&*fit, &Source::of_program(&program));
        assert!(deviation.mean < bound, "{deviation} of {}", program.hash());
        let exported = of_program(&program, Format::Blender).unwrap();
        let note = exported.note.clone().unwrap();
        assert!(note.ends_with(&deviation.to_string()), "{note}");
        assert!(exported.into_text().contains(&format!("DESCRIPTION = \"{note}\"")));
        let shader = of_program(&program, Format::BlenderOsl).unwrap().into_text();
        assert!(shader.contains(&format!("{:.3} %", 100.0 * deviation.mean)), "{shader}");
    }
}

#[test]
fn fits_reflect_as_much_light_as_the_material() {
    const COUNT: usize = 20_000;
    for name in ["gold", "red-plastic", "velvet", "satin"] {
        let program = preset(name);
        let source = Source::of_program(&program);
        let fit = fitted(&program, Format::Blender).unwrap();
        // Two stops and a place between stops.
        for place in [5.0, 9.5, 12.0] {
            let inclination = inclination_of(place);
            let pairs: Vec<DirectionPair> = (0..COUNT)
                .map(|k| {
                    let place = spread(k);
                    let light = direction(
                        libm::acos((1.0 - place.x).sqrt()),
                        std::f64::consts::TAU * place.y,
                    );
                    let turn = std::f64::consts::TAU * (0.618_034 * k as f64).fract();
                    DirectionPair::new(light, direction(inclination, turn)).unwrap()
                })
                .collect();
            let wanted: DVec3 = source.f(&pairs).into_iter().sum();
            let found: DVec3 = pairs.iter().map(|pair| fit.f(pair)).sum();
            let ratio = found / wanted;
            assert!((ratio - 1.0).abs().max_element() < 0.05, "{name} at {place}: {ratio}");
        }
    }
}

#[test]
fn previews_hold_the_material_and_its_error() {
    for (program, bound) in [
        (expressed(".model lambert\n"), 0.01),
        (preset("model-chrome"), 0.06),
        (preset("model-gold"), 0.12),
    ] {
        let fit = fitted(&program, Format::Gltf).unwrap();
        let deviation = Deviation::of(&*fit, &Source::of_program(&program));
        assert!(deviation.mean < bound, "{deviation} of {}", program.hash());
        let exported = of_program(&program, Format::Gltf).unwrap();
        let text = String::from_utf8_lossy(&exported.bytes);
        assert!(text.starts_with("glTF") && text.contains("KHR_materials_specular"));
        assert!(text.contains(&deviation.to_string()) && exported.note.is_some());
    }
}

#[test]
fn fits_refuse_bumps() {
    let program = expressed(".model lambert\n.bump strength 0.5\n.bump MOV R0, R0\n");
    assert_eq!(fitted(&program, Format::Blender).err(), Some(PrintError::Bumps(Format::Blender)));
}

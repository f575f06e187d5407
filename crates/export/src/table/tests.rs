//! Tables against the BRDFs that they are made of, by brood's own readers.

use brood_brdf::{Brdf, Claims, DirectionPair, Input, Merl, Rgl, Swapped};
use brood_eval::{express, is_anisotropic, limited};
use brood_genome::preset::Preset;
use brood_genome::{BirthKey, Dialect, Genome, Variation};
use glam::DVec3;

use super::*;
use crate::reflectance::even_pairs;

fn expressed(text: &str) -> Program {
    let genome: Genome = format!("brood 1\n{text}").parse().unwrap();
    limited(express(&genome))
}

fn preset(name: &str) -> Program {
    limited(express(Preset::find(name).unwrap().genome()))
}

/// A random program that is isotropic and reads no texture, so that its table is made fast.
fn random() -> Program {
    let random = Variation::random(Dialect::default());
    let programs = (0..200)
        .map(|slot| limited(Program::lower(&random.birth(BirthKey { seed: 3, slot, attempt: 0 }))));
    let is_plain = |program: &Program| {
        let inputs = program.inputs();
        let is_textured = inputs.contains(Input::U) || inputs.contains(Input::V);
        !is_anisotropic(program) && !is_textured && inputs.len() > 1
    };
    programs.into_iter().find(is_plain).unwrap()
}

fn bytes(program: &Program, format: Format) -> Vec<u8> {
    of_program(program, format).unwrap().bytes
}

/// Mean |df cos_i| / mean f cos_i.
fn error(table: &dyn Brdf, source: &Source<'_>) -> f64 {
    Deviation::of(table, source).mean
}

#[test]
fn rgl_tables_read_back_as_the_material() {
    for (program, bound) in [
        (preset("gold"), 4e-3),
        (preset("red-plastic"), 4e-3),
        (expressed(".model cook-torrance\n"), 2e-2),
        (expressed(".model lambert\n"), 4e-3),
        // Random programs may have details that no table shows; the error says so.
        (random(), 1.0),
    ] {
        let exported = of_program(&program, Format::RglBsdf).unwrap();
        let read = Rgl::read(&exported.bytes).unwrap();
        let error = error(&Swapped(&read), &Source::of_program(&program));
        assert!(error < bound, "{error} {:?} {}", exported.note, program.hash());
        let stated = format!("error {:.3} %", 100.0 * error);
        assert!(exported.note.unwrap().contains(&stated), "{stated}");
    }
}

#[test]
fn anisotropic_rgl_tables_have_half_a_turn_of_azimuths() {
    let brushed = expressed(".model ward\nalpha_x 0.6\nalpha_y 0.7\n");
    let bytes = bytes(&brushed, Format::RglBsdf);
    let read = Rgl::read(&bytes).unwrap();
    let error = error(&Swapped(&read), &Source::of_program(&brushed));
    assert!(error < 3e-2, "{error}");
    // Colours and densities of sampling: four numbers at each place of the coarse or fine table.
    let is_of = |places: usize| (0..100_000).contains(&(bytes.len() - 16 * places));
    let [coarse, fine] = [17 * 16, 33 * 24].map(|views| views * 64 * 64);
    assert!(if bytes.len() < 16 * fine { is_of(coarse) } else { is_of(fine) });
}

#[test]
fn light_and_eye_of_rgl_tables_are_those_of_mitsuba() {
    let phong = expressed(".model phong\n");
    let read = Rgl::read(&bytes(&phong, Format::RglBsdf)).unwrap();
    let source = Source::of_program(&phong);
    assert!(!source.is_reciprocal());
    let (as_mitsuba, other) = (error(&Swapped(&read), &source), error(&read, &source));
    assert!(as_mitsuba < 1e-2 && other > 3.0 * as_mitsuba, "{as_mitsuba} {other}");
}

#[test]
fn merl_tables_have_the_size_of_the_format_and_are_exact_for_diffuse_materials() {
    let lambert = expressed(".model lambert\n");
    let exported = of_program(&lambert, Format::Merl).unwrap();
    assert_eq!(exported.bytes.len(), 34_992_012);
    assert_eq!(exported.bytes[..12], [90_i32, 90, 180].map(i32::to_le_bytes).concat());
    let read = Merl::read(&exported.bytes).unwrap();
    let source = Source::of_program(&lambert);
    assert!(error(&read, &source) < 1e-6);
    // A quarter of the bins has a direction below the surface.
    let numbers = exported.bytes[12..].as_chunks::<8>().0;
    let below = numbers.iter().filter(|bytes| f64::from_le_bytes(**bytes) < 0.0).count();
    let share = below as f64 / numbers.len() as f64;
    assert!((0.2..0.3).contains(&share), "{share}");
}

#[test]
fn merl_tables_read_back_as_the_material() {
    for (program, bound) in [(preset("gold"), 3e-2), (preset("red-plastic"), 3e-2)] {
        let exported = of_program(&program, Format::Merl).unwrap();
        let read = Merl::read(&exported.bytes).unwrap();
        let error = error(&read, &Source::of_program(&program));
        assert!(error < bound, "{error} {:?}", exported.note);
    }
}

/// f that depends on the azimuths, to an extent.
struct Turning(f64);

impl Brdf for Turning {
    fn f(&self, pair: &DirectionPair) -> DVec3 {
        let h = (pair.wi() + pair.wo()).normalize();
        let is_above = pair.cos_i() > 0.0 && pair.cos_o() > 0.0;
        if is_above { DVec3::splat(1.0 + self.0 * h.x + h.y * h.y) } else { DVec3::ZERO }
    }

    fn claims(&self) -> Claims {
        Claims { reciprocal: true, conserving: false }
    }
}

#[test]
fn symmetry_of_measured_materials_is_that_of_their_values() {
    let (half, none) = (Turning(0.0), Turning(0.5));
    assert_eq!(Source::of_measured(&half).symmetry(), Symmetry::Half);
    assert_eq!(Source::of_measured(&none).symmetry(), Symmetry::None);
    let exported = of_measured(&none, Format::RglBsdf).unwrap();
    let read = Rgl::read(&exported.bytes).unwrap();
    let error = error(&Swapped(&read), &Source::of_measured(&none));
    assert!(error < 1e-2, "{error}");
    let refused = of_measured(&half, Format::Merl).unwrap_err();
    assert!(refused.to_string().contains("isotropic"), "{refused}");
    let lambert = brood_brdf::Model::new(brood_brdf::ModelKind::Lambert).brdf();
    assert_eq!(Source::of_measured(&*lambert).symmetry(), Symmetry::Isotropic);
}

#[test]
fn formats_of_code_and_bumps_are_refused_with_the_reason() {
    let refused = of_measured(&Turning(0.0), Format::Wgsl).unwrap_err().to_string();
    let known = "wgsl is a format of genomes; a measured material is exported as rgl-bsdf, merl, \
                 samples-csv";
    assert_eq!(refused, known);
    let bumped = expressed(".model lambert\n.bump strength 0.5\n.bump MOV R0, R0\n");
    let refused = check(&bumped, Format::RglBsdf).unwrap_err().to_string();
    assert!(refused.starts_with("rgl-bsdf has no bumps"), "{refused}");
}

#[test]
fn samples_are_read_as_a_target() {
    let gold = preset("gold");
    let text = of_program(&gold, Format::SamplesCsv).unwrap().into_text();
    let samples = brood_brdf::MeasuredSamples::from_csv(text.as_bytes()).unwrap();
    assert_eq!((samples.rows().len(), samples.skipped()), (8192, 0));
    let wanted = Source::of_program(&gold).f(&even_pairs(8192));
    let off = samples.rows().iter().zip(wanted).map(|((_, f), wanted)| (*f - wanted).length());
    assert!(off.fold(0.0, f64::max) < 1e-12);
}

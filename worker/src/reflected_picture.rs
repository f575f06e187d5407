//! Pictures of painted materials that paint what a BRDF reflects. The BRDF is rendered first; its
//! whole picture gives the points their levels, so each material has points of its own.

use brood_eval::{Gain, ReflectedLevels};
use brood_program::Program;
use brood_protocol::PictureFormat;
use brood_scene::PixelArea;

use crate::error::RenderError;
use crate::evaluated_picture::EvaluatedPicture;
use crate::renderer::Renderer;
use crate::shot::{BATCH_FLOATS, Shot};

/// Number of f32 values that a pixel of [`ReflectedLevels`] takes.
const FLOATS_PER_PIXEL: usize = 5;

impl Renderer {
    /// Renders the BRDFs of styles, then evaluates each style on the points of the requested part
    /// of the picture. `finish` receives them as lowered for the lights of the scene.
    pub(crate) fn reflected_images<T: Send>(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
        finish: impl Fn(&Program, &dyn EvaluatedPicture) -> Result<T, RenderError> + Sync,
    ) -> Result<Vec<T>, RenderError> {
        let pixels = usize::try_from(shot.frame.size_px.pixels()).expect("a picture fits memory");
        let together = (BATCH_FLOATS / (FLOATS_PER_PIXEL * pixels)).max(1);
        let mut done = Vec::with_capacity(programs.len());
        for programs in programs.chunks(together) {
            let reflected = self.reflected(shot, programs)?;
            for (program, (reflected, gain)) in programs.iter().zip(reflected) {
                self.caches.check()?;
                let points = self.points_for(shot, program)?;
                let set = (&reflected.on(&points), gain.ev);
                done.extend(self.images_on(set, shot.frame.backend, &[program], &finish)?);
            }
        }
        Ok(done)
    }

    /// Renders the whole pictures of the BRDFs of styles, each at its own exposure: a ground below
    /// does not change which colours its subject has.
    fn reflected(
        &self,
        shot: &Shot<'_>,
        programs: &[&Program],
    ) -> Result<Vec<(ReflectedLevels, Gain)>, RenderError> {
        let brdf = |program: &&Program| program.brdf().expect("the styles paint a BRDF");
        let brdfs: Vec<Program> = programs.iter().map(brdf).collect();
        let brdfs: Vec<&Program> = brdfs.iter().collect();
        let mut frame = shot.frame.clone().with_area(None);
        frame.format = PictureFormat::Exr;
        let (view, area) = (shot.view.clone(), PixelArea::whole(frame.size_px));
        let film = view.scene().film;
        let whole = Shot { view, frame: &frame, film, area, subject: shot.subject };
        self.shaded(&whole, &brdfs, |_: &Program, picture| {
            let gain = picture.gain();
            Ok((ReflectedLevels::new(&picture.radiance()?, gain), gain))
        })
    }
}

#[cfg(test)]
mod tests {
    use brood_eval::{decode_linear, decode_png, encode_srgb};
    use brood_genome::Genome;
    use brood_genome::preset::{Preset, neutral};
    use brood_mesh::BuiltinMesh;
    use brood_protocol::{Backend, Frame, MeshSource, ObjectSource};
    use brood_scene::{Exposure, Sampling, Scene};

    use super::*;

    const SIDE: u32 = 40;
    const TWO: &str = "palette #000000 #ffffff\nbasis linear\nfeather 1\n";

    /// Program of a preset under a light effect with these lines.
    fn toon(preset: &str, lines: &str) -> Program {
        let text = format!("brood 1\n.model lambert\n.effect light\nby brdf\n{lines}");
        let effects = text.parse::<Genome>().unwrap().effects().to_vec();
        let brdf = Preset::find(preset).expect("the preset exists").genome().clone();
        Program::lower(&brdf.with_effects(effects).unwrap())
    }

    fn scene(json: &str) -> Scene {
        serde_json::from_str(json).unwrap()
    }

    fn frame(scene: &Scene, format: PictureFormat, backend: Backend) -> Frame {
        Frame::new(scene, MeshSource::Builtin, SIDE, Sampling::Adaptive, (format, backend))
    }

    /// Lights, shadows and environments of every method: sampled, tables, direct means.
    const SCENES: [&str; 3] = [
        r#"{"mesh": "knob", "lights": [{}, {"kind": "directional", "direction": [1, 0, 0.2],
            "irradiance_w_m2": [3, 1, 0.5]}], "shadows": true}"#,
        r#"{"mesh": "knob", "lights": [{"kind": "environment", "image": "studio"}, {}]}"#,
        r#"{"mesh": "knob", "lights": [{}], "film": {"exposure": 1.5, "tone": "filmic"}}"#,
    ];

    #[test]
    fn colours_are_those_computed_from_the_linear_picture_of_the_brdf() {
        for (json, backend) in SCENES
            .into_iter()
            .flat_map(|json| [Backend::Cpu, Backend::Reference].map(|b| (json, b)))
        {
            let renderer = Renderer::new(backend);
            let mesh = renderer.builtin(BuiltinMesh::Knob);
            let scene = scene(json);
            for (preset, is_box) in [("gold", false), ("car-paint", true), ("model-plastic", true)]
            {
                let property = if is_box { "box" } else { "hull" };
                // One ramp as wide as the range: the grey of a pixel is its amount.
                let style = toon(preset, &format!("{TWO}property {property}\n"));
                let brdf = style.brdf().unwrap();
                let png = frame(&scene, PictureFormat::Png, backend);
                let exr = frame(&scene, PictureFormat::Exr, backend);
                let painted = renderer.render(&png, &mesh, &[&style]).unwrap().remove(0);
                let developed = renderer.render(&png, &mesh, &[&brdf]).unwrap().remove(0);
                assert_eq!(painted.exposure_ev.to_bits(), developed.exposure_ev.to_bits());
                let linear = renderer.render(&exr, &mesh, &[&brdf]).unwrap().remove(0);
                let linear = decode_linear(&linear.bytes, SIDE).unwrap();
                let factor = developed.exposure_ev.exp2();
                let (_, _, rgba) = decode_png(&painted.bytes).unwrap();
                let (_, _, film) = decode_png(&developed.bytes).unwrap();
                let (mut compared, mut bright) = (0, 0);
                for (pixel, code) in rgba.as_chunks::<4>().0.iter().enumerate() {
                    if code[3] < 255 || film[4 * pixel + 3] < 255 {
                        continue;
                    }
                    let exposed = linear.pixels[pixel].map(|channel| f64::from(channel) * factor);
                    let [red, green, blue] = exposed;
                    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
                    let own = if is_box { exposed } else { [luminance; 3] };
                    for (code, l) in code.iter().zip(own) {
                        let expected = 255.0 * l / (1.0 + l);
                        let apart = (f64::from(*code) - expected).abs();
                        assert!(apart < 1.0, "{json} {preset} {pixel}: {code} {expected}");
                        bright += u32::from(expected > 64.0);
                    }
                    compared += 1;
                }
                assert!(compared > 500 && bright > 100, "{json} {preset} {compared} {bright}");
            }
        }
    }

    #[test]
    fn batches_and_parts_have_the_bits_of_pictures_alone() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let three = "palette #101020 #c08040 #fff0d0\nbasis step\nfrom 0.1\nto 0.8\n";
        let mut programs = ["gold", "marble", "model-velvet", "checkered-ceramic"]
            .map(|preset| toon(preset, three))
            .to_vec();
        for other in ["paint-cartoon", "gold"] {
            programs.push(Program::lower(Preset::find(other).unwrap().genome()));
        }
        let batch: Vec<&Program> = programs.iter().collect();
        for json in SCENES {
            let scene = scene(json);
            let frame = frame(&scene, PictureFormat::Png, Backend::Cpu);
            let together = renderer.render(&frame, &mesh, &batch).unwrap();
            let area = PixelArea { x: 7, y: 11, width: 19, height: 14 };
            let part = frame.clone().with_area(Some(area));
            let parts = renderer.render(&part, &mesh, &batch).unwrap();
            for ((whole, part), program) in together.iter().zip(&parts).zip(&programs) {
                let alone = renderer.render(&frame, &mesh, &[program]).unwrap().remove(0);
                assert_eq!(alone, *whole);
                let (whole, part) =
                    (decode_png(&whole.bytes).unwrap().2, decode_png(&part.bytes).unwrap().2);
                let rows = (area.y..area.y + area.height).flat_map(|y| {
                    let start = 4 * (y * SIDE + area.x) as usize;
                    whole[start..start + 4 * area.width as usize].to_vec()
                });
                assert!(part == rows.collect::<Vec<u8>>(), "{json}");
            }
        }
    }

    #[test]
    fn fixed_exposure_acts_and_automatic_exposure_takes_the_light_of_the_scene() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let style = toon("gold", TWO);
        let codes = |irradiance: f64, exposure: Exposure| {
            let light = format!(r#"{{"kind": "directional", "irradiance_w_m2": {irradiance}}}"#);
            let mut scene = scene(&format!(r#"{{"mesh": "knob", "lights": [{light}]}}"#));
            scene.film.exposure = exposure;
            let frame = frame(&scene, PictureFormat::Png, Backend::Cpu);
            let picture = renderer.render(&frame, &mesh, &[&style]).unwrap().remove(0);
            decode_png(&picture.bytes).unwrap().2
        };
        let plain = codes(1.0, Exposure::Auto);
        let twice = codes(2.0, Exposure::Auto);
        let apart = plain.iter().zip(&twice).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(apart <= Some(1), "{apart:?}");
        let mean = |codes: &[u8]| codes.iter().map(|code| u32::from(*code)).sum::<u32>();
        let levels = [-2.0, 0.0, 2.0].map(|ev| mean(&codes(1.0, Exposure::Ev(ev))));
        assert!(levels[0] < levels[1] && levels[1] < levels[2], "{levels:?}");
    }

    #[test]
    fn colours_are_the_same_above_a_ground() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        // Far darker than the ground at its exposure.
        let style = toon("velvet", TWO);
        let [alone, above] = ["", r#""ground": {}, "#].map(|ground| {
            let scene = scene(&format!(r#"{{"mesh": "knob", {ground}"lights": [{{}}]}}"#));
            let mut frame = frame(&scene, PictureFormat::Png, Backend::Cpu);
            if scene.ground.is_some() {
                let words = Program::lower(neutral()).to_words();
                frame = frame.with_objects(vec![ObjectSource { mesh: MeshSource::Builtin, words }]);
            }
            let picture = renderer.render(&frame, &mesh, &[&style]).unwrap().remove(0);
            decode_png(&picture.bytes).unwrap().2
        });
        let pixels = alone.as_chunks::<4>().0.iter().zip(above.as_chunks::<4>().0);
        let opaque: Vec<_> = pixels.filter(|(alone, _)| alone[3] == 255).collect();
        let brightest = opaque.iter().map(|(alone, _)| alone[0]).max();
        assert!(opaque.len() > 400 && brightest > Some(50), "{} {brightest:?}", opaque.len());
        let apart = opaque.iter().filter(|(alone, above)| alone != above).count();
        assert_eq!(apart, 0, "of {}", opaque.len());
    }

    #[test]
    fn linear_picture_is_the_light_of_the_display() {
        let renderer = Renderer::new(Backend::Cpu);
        let mesh = renderer.builtin(BuiltinMesh::Knob);
        let style = toon("gold", "palette #2b1e46 #f2a65a\nbasis step\n");
        let [png, exr] = [PictureFormat::Png, PictureFormat::Exr].map(|format| {
            let frame = frame(&scene(SCENES[0]), format, Backend::Cpu);
            renderer.render(&frame, &mesh, &[&style]).unwrap().remove(0).bytes
        });
        let (_, _, codes) = decode_png(&png).unwrap();
        let linear = decode_linear(&exr, SIDE).unwrap();
        for (code, own) in codes.as_chunks::<4>().0.iter().zip(&linear.pixels) {
            for c in (0..3).filter(|_| code[3] == 255) {
                assert!(code[c].abs_diff(encode_srgb(own[c])) <= 1, "{code:?} {own:?}");
            }
        }
    }
}

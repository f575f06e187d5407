//! Parameters of VRM's toon material (`VRMC_materials_mtoon` 1.0), as a glTF material.
//!
//! MToon has two colours, a linear ramp over n . l between them, and a rim. It mixes the colours in
//! linear light. A light effect of two colours is written as the ramp, a silhouette brighter than
//! both as a rim of about its width and colour. Other styles are refused.

use brood_genome::{Basis, Effect, EffectKind};
use brood_program::{Operand, Program};

use crate::error::PrintError;

/// Display values of a colour.
type Color = [f64; 3];

/// Ramp of MToon: its colours, and the cosines where it begins and ends.
struct Ramp {
    shade: Color,
    lit: Color,
    begin: f64,
    end: f64,
}

/// Returns the glTF material of a style.
///
/// # Errors
/// Returns [`PrintError::Mtoon`] if MToon lacks something that the style has.
pub(crate) fn material(style: &Program, effects: &[Effect]) -> Result<String, PrintError> {
    let mut seen = effects.iter().filter(|effect| effect.scalar("strength") > 0.0);
    if let Some(reason) = seen.find_map(|effect| match effect.kind() {
        EffectKind::Light | EffectKind::Silhouette => None,
        EffectKind::Highlight => Some("no highlight"),
        EffectKind::Distance => Some("no colours by distance"),
        EffectKind::Glass => Some("no clear bodies"),
    }) {
        return Err(PrintError::Mtoon(reason));
    }
    let light = effects.iter().find(|effect| effect.kind() == EffectKind::Light);
    let light = light.expect("the first effect is light");
    let has_program = !matches!(style.results()[0], Operand::Constant(_));
    let ramp = ramp(light, has_program).map_err(PrintError::Mtoon)?;
    let silhouette = effects
        .iter()
        .find(|effect| effect.kind() == EffectKind::Silhouette && effect.scalar("strength") > 0.0);
    let rim = silhouette.map_or(Ok(String::new()), |effect| rim(effect, &ramp))?;
    let hash = style.hash().to_string();
    let shift = 0.0 - 0.5 * (ramp.begin + ramp.end);
    Ok(format!(
        "{{\n  \"name\": \"brood-{}\",\n  \"pbrMetallicRoughness\": {{\n    \
         \"baseColorFactor\": [{}, 1],\n    \"metallicFactor\": 0,\n    \"roughnessFactor\": 1\n  }},\n  \
         \"extensions\": {{\n    \"VRMC_materials_mtoon\": {{\n      \"specVersion\": \"1.0\",\n      \
         \"shadeColorFactor\": [{}],\n      \"shadingShiftFactor\": {},\n      \
         \"shadingToonyFactor\": {},\n{rim}      \"giEqualizationFactor\": 0\n    }}\n  }}\n}}\n",
        &hash[..8],
        numbers(ramp.lit.map(linear)),
        numbers(ramp.shade.map(linear)),
        number(shift),
        number(1.0 - 0.5 * (ramp.end - ramp.begin)),
    ))
}

/// Ramp of a light effect. The ramp of the palette lies within that of the amount; what of it is
/// out of reach moves into the colours.
fn ramp(light: &Effect, has_program: bool) -> Result<Ramp, &'static str> {
    if light.word("by") != "light" {
        return Err("no colours by the direction to the eye");
    }
    if has_program && light.scalar("brush") > 0.0 {
        return Err("no brush");
    }
    let palette = light.palette().expect("a light effect has a palette");
    let [dark, bright] = palette.colors() else { return Err("two colours") };
    let feather = light.scalar("feather");
    let basis = Basis::from_name(light.word("basis")).expect("words are those of the basis");
    let (edge, width) = match basis {
        Basis::Bezier => (0.5, 1.0),
        Basis::Step => (palette.edges()[0], 0.0),
        Basis::Linear => (palette.edges()[0], feather),
        Basis::Quadratic | Basis::Cubic if feather > 0.0 => return Err("linear ramps only"),
        Basis::Quadratic | Basis::Cubic => (palette.edges()[0], 0.0),
    };
    let (from, to) = (light.scalar("from"), light.scalar("to"));
    let most = light.scalar("strength");
    let share = |amount: f64| {
        if width > 0.0 {
            ((amount - edge) / width + 0.5).clamp(0.0, 1.0)
        } else {
            f64::from(u8::from(amount >= edge))
        }
    };
    let color = |share: f64| {
        [0, 1, 2].map(|channel| {
            let (dark, bright) = (f64::from(dark[channel]), f64::from(bright[channel]));
            (dark + share * (bright - dark)) / 255.0
        })
    };
    // A cosine is the amount's place on its way to `strength`.
    let place = |amount: f64| if most > 0.0 { (amount / most).clamp(0.0, 1.0) } else { 0.0 };
    let cosine = |amount: f64| from + place(amount) * (to - from);
    Ok(Ramp {
        shade: color(share(0.0)),
        lit: color(share(most)),
        begin: cosine(edge - 0.5 * width),
        end: cosine(edge + 0.5 * width),
    })
}

/// Lines of a rim like a silhouette: (1 - n . e)^power is 1/2 where the silhouette is.
fn rim(silhouette: &Effect, ramp: &Ramp) -> Result<String, PrintError> {
    let color = silhouette.color("color");
    let strength = silhouette.scalar("strength");
    let added = [0, 1, 2].map(|channel| {
        let over = linear(color[channel]);
        let (shade, lit) = (linear(ramp.shade[channel]), linear(ramp.lit[channel]));
        let is_brighter = over >= shade.max(lit);
        is_brighter.then_some(strength * (over - 0.5 * (shade + lit)))
    });
    let [Some(red), Some(green), Some(blue)] = added else {
        let reason = "no silhouette that is darker than the palette: its rim adds light";
        return Err(PrintError::Mtoon(reason));
    };
    let middle = 0.5 * (silhouette.scalar("from") + silhouette.scalar("to"));
    let power = libm::log(0.5) / libm::log(middle.clamp(0.01, 0.99));
    Ok(format!(
        "      \"parametricRimColorFactor\": [{}],\n      \"parametricRimFresnelPowerFactor\": {},\n      \
         \"parametricRimLiftFactor\": 0,\n      \"rimLightingMixFactor\": 0,\n",
        numbers([red, green, blue]),
        number(power),
    ))
}

/// Linear light of a display value, by the sRGB curve.
fn linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { libm::pow((code + 0.055) / 1.055, 2.4) }
}

fn numbers(values: Color) -> String {
    values.map(number).join(", ")
}

/// JSON number of six digits.
fn number(value: f64) -> String {
    let rounded = (value * 1e6).round() / 1e6;
    // Adding 0 turns -0 into 0.
    format!("{}", rounded + 0.0)
}

#[cfg(test)]
mod tests {
    use brood_brdf::{Input, Lighting};
    use brood_genome::Genome;
    use brood_program::execute;

    use crate::{Exported, Format, Within, export_material};

    use super::*;

    fn exported(text: &str) -> Result<String, String> {
        let genome = format!("brood 1\n{text}").parse::<Genome>().unwrap();
        let style = Program::lower(&genome);
        let exported = export_material(&style, Format::Mtoon, Within::default());
        exported.map(Exported::into_text).map_err(|error| error.to_string())
    }

    /// Value of a number in a material.
    fn value(material: &str, name: &str) -> f64 {
        let (_, rest) = material.split_once(&format!("\"{name}\": ")).unwrap();
        rest.split([',', '\n']).next().unwrap().parse().unwrap()
    }

    /// Colour of MToon by the cosine, in display values.
    fn mtoon(ramp: &Ramp, cosine: f64) -> Color {
        let (shift, toony) = (-0.5 * (ramp.begin + ramp.end), 1.0 - 0.5 * (ramp.end - ramp.begin));
        let (low, high) = (toony - 1.0, 1.0 - toony);
        let share = ((cosine + shift - low) / (high - low).max(1e-9)).clamp(0.0, 1.0);
        [0, 1, 2].map(|k| ramp.shade[k] + share * (ramp.lit[k] - ramp.shade[k]))
    }

    #[test]
    fn ramps_are_those_of_the_style() {
        let styles = [
            "basis linear\nfeather 0.2\nedges 0.5\nfrom -0.4\nto 0.9\n",
            // The ramp begins below the amount 0 and ends above `strength`.
            "basis linear\nfeather 0.9\nedges 0.3\nfrom -1\nto 0.4\nstrength 0.6\n",
            "basis bezier\n",
            "basis step\nedges 0.25\nfrom 0\nto 0.8\n",
            "basis cubic\nfeather 0\nedges 0.7\n",
        ];
        for text in styles {
            let genome = format!("brood 1\n.effect light\n{text}").parse::<Genome>().unwrap();
            let style = Program::lower(&genome);
            let found = ramp(&genome.effects()[0], false).unwrap();
            let program = style.painted(Lighting { lights: 1, has_shadows: false });
            for step in -50..=50 {
                let cosine = f64::from(step) / 50.0 + 0.003;
                let inputs = |input: Input| match input {
                    Input::Light0Cos => cosine,
                    Input::Light0Level => 1.0,
                    _ => 0.0,
                };
                let wanted: Color = execute(&program, inputs, |constant| constant.reference);
                let apart =
                    mtoon(&found, cosine).into_iter().zip(wanted).map(|(a, b)| (a - b).abs());
                let apart = apart.fold(0.0, f64::max);
                assert!(apart < 0.005, "{text} at {cosine}: {apart}");
            }
        }
    }

    #[test]
    fn parameters_are_those_of_the_design() {
        let material = exported(".effect light\nbasis bezier\nfrom -0.2\nto 0.6\n").unwrap();
        assert_eq!(value(&material, "shadingToonyFactor"), 0.6);
        assert_eq!(value(&material, "shadingShiftFactor"), -0.2);
        assert!(!material.contains("Rim"), "{material}");
        let text =
            ".effect light\nbasis step\n.effect silhouette\ncolor #ffffff\nfrom 0.6\nto 0.8\n";
        let material = exported(text).unwrap();
        let power = value(&material, "parametricRimFresnelPowerFactor");
        assert!((0.7f64.powf(power) - 0.5).abs() < 1e-5, "{material}");
    }

    #[test]
    fn other_styles_are_refused_with_the_reason() {
        let refused = [
            (".effect light\nbasis cubic\n", "linear ramps only"),
            (".effect light\nbasis step\npalette #000000 #808080 #ffffff\n", "two colours"),
            (".effect light\nby facing\n", "no colours by the direction to the eye"),
            (".effect light\nbasis step\n.effect highlight\n", "no highlight"),
            (".effect light\nbasis step\n.effect distance\n", "no colours by distance"),
            (".effect light\nbasis step\n.effect silhouette\n", "no silhouette that is darker"),
        ];
        for (text, reason) in refused {
            let error = exported(text).unwrap_err();
            assert!(error.starts_with("VRM's toon material has ") && error.contains(reason));
        }
        let off = ".effect light\nbasis step\n.effect highlight\nstrength 0\n";
        assert!(exported(off).is_ok());
        let metal = "brood 1\n.model lambert\n".parse::<Genome>().unwrap();
        let error =
            export_material(&Program::lower(&metal), Format::Mtoon, Within::default()).unwrap_err();
        assert_eq!(error.to_string(), "vrm-mtoon is a format of painted materials");
    }
}

//! JSON form of effects.

use std::collections::BTreeMap;

use brood_brdf::{ParameterKind, display_codes};
use serde::{Deserialize, Serialize};

use super::pointer::escaped;
use crate::effect::{self, Effect, EffectImage, EffectKind, Palette, hex};
use crate::{ImageHash, ParameterValues};

/// An effect and its parameters. Parameters that are missing have their defaults.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EffectJson {
    kind: String,
    #[serde(default)]
    parameters: BTreeMap<String, EffectValueJson>,
}

/// Value of a parameter of an effect, or an image.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "a number, a word, a list of numbers or colours, or an image")]
enum EffectValueJson {
    Number(f64),
    /// Word of a choice, or a colour.
    Word(String),
    Edges(Vec<f64>),
    Palette(Vec<String>),
    Image(ImageJson),
}

/// Image in a place of an effect.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageJson {
    image: String,
    #[serde(default = "whole")]
    share: f64,
}

fn whole() -> f64 {
    1.0
}

impl EffectJson {
    pub(super) fn of(effect: &Effect) -> Self {
        let own = effect.parameters().map(|(parameter, values)| {
            let value = match parameter.kind {
                ParameterKind::Choice { .. } | ParameterKind::DisplayColor { .. } => {
                    EffectValueJson::Word(parameter.text(values))
                }
                ParameterKind::Scalar { .. } | ParameterKind::Color { .. } => {
                    EffectValueJson::Number(values[0])
                }
            };
            (parameter.name.to_owned(), value)
        });
        let mut parameters: BTreeMap<_, _> = own.collect();
        if let Some(palette) = effect.palette() {
            let colors = palette.colors().iter().map(hex).collect();
            let edges = palette.edges().to_vec();
            parameters.insert(Palette::COLORS.to_owned(), EffectValueJson::Palette(colors));
            parameters.insert(Palette::EDGES.to_owned(), EffectValueJson::Edges(edges));
        }
        for EffectImage { place, image, share } in effect.images() {
            let image = ImageJson { image: image.to_string(), share: *share };
            parameters.insert((*place).to_owned(), EffectValueJson::Image(image));
        }
        Self { kind: effect.kind().name().to_owned(), parameters }
    }

    /// Parses the effect. An error is a JSON pointer relative to it, and a reason.
    fn parse(&self) -> Result<Effect, (String, String)> {
        let kind = EffectKind::from_name(&self.kind).ok_or_else(|| {
            let known = EffectKind::ALL.map(EffectKind::name).join(", ");
            ("/kind".to_owned(), format!("unknown effect; known effects: {known}"))
        })?;
        let mut values = ParameterValues::new(kind.name(), kind.parameters());
        let (mut colors, mut edges, mut images) = (None, None, Vec::new());
        for (name, value) in &self.parameters {
            if let Some(place) = kind.image_place(name) {
                images.push(parse_image(place, value)?);
                continue;
            }
            let set = match (name.as_str(), value) {
                (Palette::COLORS, EffectValueJson::Palette(words)) if kind.has_palette() => {
                    colors = Some(parse_colors(words)?);
                    Ok(())
                }
                (Palette::EDGES, EffectValueJson::Edges(numbers)) if kind.has_palette() => {
                    edges = Some(numbers.clone());
                    Ok(())
                }
                // An empty list is read as one of numbers.
                (Palette::COLORS, EffectValueJson::Edges(numbers))
                    if kind.has_palette() && numbers.is_empty() =>
                {
                    colors = Some(Vec::new());
                    Ok(())
                }
                (Palette::COLORS, _) if kind.has_palette() => {
                    return Err((pointer(name), "expected a list of colours".to_owned()));
                }
                (Palette::EDGES, _) if kind.has_palette() => {
                    return Err((pointer(name), "expected a list of numbers".to_owned()));
                }
                // The words of some choices are numbers.
                (_, EffectValueJson::Number(number)) => values.set_text(name, &number.to_string()),
                (_, EffectValueJson::Word(word)) => values.choose(name, word).map_err(Into::into),
                (_, EffectValueJson::Edges(numbers)) => {
                    values.set(name, numbers).map_err(Into::into)
                }
                (_, EffectValueJson::Palette(words)) => {
                    values.choose(name, &words.join(" ")).map_err(Into::into)
                }
                (_, EffectValueJson::Image(_)) => {
                    return Err((pointer(name), "there is no place for an image".to_owned()));
                }
            };
            set.map_err(|error| (pointer(name), error.to_string()))?;
        }
        let palette = Palette::new(colors, edges)
            .map_err(|error| (pointer(error.parameter()), error.to_string()))?;
        Effect::new(kind, values, kind.has_palette().then_some(palette))
            .and_then(|effect| effect.with_images(images))
            .map_err(|error| (pointer(error.parameter), error.reason))
    }
}

/// Parses all effects. An error is a JSON pointer relative to the list, and a reason.
pub(super) fn parse_all(effects: &[EffectJson]) -> Result<Vec<Effect>, (String, String)> {
    let mut parsed = Vec::new();
    for (index, json) in effects.iter().enumerate() {
        let effect = json.parse().map_err(|(at, reason)| (format!("/{index}{at}"), reason))?;
        effect::check_next(&parsed, effect.kind())
            .map_err(|error| (format!("/{index}/kind"), error.to_string()))?;
        effect::check_images(&parsed, &effect)
            .map_err(|error| (format!("/{index}"), error.to_string()))?;
        parsed.push(effect);
    }
    Ok(parsed)
}

fn parse_colors(words: &[String]) -> Result<Vec<[u8; 3]>, (String, String)> {
    let color = |(index, word): (usize, &String)| {
        let pointer = format!("{}/{index}", pointer(Palette::COLORS));
        display_codes(word).ok_or((pointer, "expected a colour like #2b1e46".to_owned()))
    };
    words.iter().enumerate().map(color).collect()
}

/// Parses an image with a share, or its hash alone.
fn parse_image(
    place: &'static str,
    value: &EffectValueJson,
) -> Result<EffectImage, (String, String)> {
    let (hash, share, at) = match value {
        EffectValueJson::Image(ImageJson { image, share }) => (image, *share, "/image"),
        EffectValueJson::Word(hash) => (hash, 1.0, ""),
        EffectValueJson::Number(_) | EffectValueJson::Edges(_) | EffectValueJson::Palette(_) => {
            return Err((pointer(place), "expected an image: {\"image\": hash}".to_owned()));
        }
    };
    let image = hash.parse::<ImageHash>();
    let image = image.map_err(|error| (format!("{}{at}", pointer(place)), error.to_string()))?;
    Ok(EffectImage { place, image, share })
}

/// JSON pointer to a parameter, relative to the effect.
fn pointer(name: &str) -> String {
    format!("/parameters/{}", escaped(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(json: &str) -> Result<Effect, (String, String)> {
        serde_json::from_str::<EffectJson>(json).unwrap().parse()
    }

    #[test]
    fn number_of_a_choice_is_its_word_and_not_its_place() {
        let index = |value: &str| {
            let json = format!(r#"{{"kind": "glass", "parameters": {{"index": {value}}}}}"#);
            parsed(&json).map(|glass| {
                let EffectValueJson::Word(word) = &EffectJson::of(&glass).parameters["index"]
                else {
                    panic!("a choice is written as its word");
                };
                word.clone()
            })
        };
        for (number, word) in [("1.5", "1.5"), ("1.33", "1.33"), ("2", "2"), (r#""0.5""#, "0.5")] {
            assert_eq!(index(number).as_deref(), Ok(word), "{number}");
        }
        let (at, reason) = index("3").unwrap_err();
        assert_eq!(at, "/parameters/index");
        assert!(reason.contains("1.33"), "{reason}");
        let basis = r#"{"kind": "light", "parameters": {"basis": 3}}"#;
        assert_eq!(parsed(basis).unwrap_err().0, "/parameters/basis");
    }
}

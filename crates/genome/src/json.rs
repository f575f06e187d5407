//! JSON form of a genome: the words of the text form in a structure that scripts can edit.

mod effect;
mod pointer;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use effect::EffectJson;
use pointer::{escaped, pointer};

use crate::text::{parse_destination, parse_operand};
use crate::{
    Bump, CONSTANTS, Dialect, EffectsError, Genome, GenomeError, Instruction, LAYERS_MAX, Model,
    ModelKind, Opcode, Output,
};

/// Error of [`Genome::from_json`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{pointer}: {reason}")]
pub struct JsonError {
    /// JSON pointer to the offending value.
    pub pointer: String,
    /// Description of the error.
    pub reason: String,
}

/// The whole genome. Parts that are left out have their defaults: no energy limit, the identity as
/// output stage, constants 0.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct GenomeJson {
    /// Version of the format, 1.
    brood: u32,
    dialect: Dialect,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    matrix: Option<[[f32; 3]; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scale: Option<[f32; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    offset: Option<[f32; 3]>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    limit: bool,
    /// By name, C0 to C127.
    #[serde(default)]
    constants: ConstantsJson,
    #[serde(default)]
    instructions: Vec<InstructionJson>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    layers: Vec<LayerJson>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    effects: Vec<EffectJson>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bump: Option<BumpJson>,
}

/// Constants that are not 0, by name.
type ConstantsJson = BTreeMap<String, [f32; 4]>;

/// Bumps: their strength, by default 1, and their program.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BumpJson {
    #[serde(default = "one")]
    strength: f32,
    #[serde(default)]
    constants: ConstantsJson,
    instructions: Vec<InstructionJson>,
}

fn one() -> f32 {
    1.0
}

/// A model and its parameters. Parameters that are missing have their defaults.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerJson {
    model: String,
    #[serde(default)]
    parameters: BTreeMap<String, ValueJson>,
}

/// Value of a parameter: a number, three numbers, or a word.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "a number, three numbers or a word")]
enum ValueJson {
    Number(f64),
    Color([f64; 3]),
    Word(String),
}

/// An instruction, with destination and operands as in the text form.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct InstructionJson {
    opcode: String,
    dst: String,
    src: Vec<String>,
}

impl Genome {
    /// Returns the genome as a JSON value.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        let identity = Output::IDENTITY;
        let output = self.output();
        let other = |differs: bool| differs.then_some(());
        let json = GenomeJson {
            brood: 1,
            dialect: *self.dialect(),
            matrix: other(output.matrix() != identity.matrix()).map(|()| *output.matrix()),
            scale: other(output.scale() != identity.scale()).map(|()| *output.scale()),
            offset: other(output.offset() != identity.offset()).map(|()| *output.offset()),
            limit: self.is_limited(),
            constants: constants_json(self),
            instructions: self.instructions().iter().map(instruction_json).collect(),
            layers: self.layers().iter().map(layer_json).collect(),
            effects: self.effects().iter().map(EffectJson::of).collect(),
            bump: self.bump().map(|bump| BumpJson {
                strength: bump.strength(),
                constants: constants_json(bump.program()),
                instructions: bump.program().instructions().iter().map(instruction_json).collect(),
            }),
        };
        serde_json::to_value(json).expect("a genome holds finite numbers and strings only")
    }

    /// Parses a genome from a JSON value.
    ///
    /// # Errors
    /// Returns the first invalid value with its JSON pointer.
    pub fn from_json(value: serde_json::Value) -> Result<Self, JsonError> {
        let json: GenomeJson =
            serde_path(value).map_err(|(pointer, reason)| JsonError { pointer, reason })?;
        let error = |pointer: String, reason: String| JsonError { pointer, reason };
        if json.brood != 1 {
            return Err(error("/brood".into(), "the format version must be 1".into()));
        }
        let effects = effect::parse_all(&json.effects)
            .map_err(|(at, reason)| error(format!("/effects{at}"), reason))?;
        let has_brdf = effects.is_empty() || crate::effect::are_by_brdf(&effects);
        let validated = match has_brdf {
            true => json.dialect.validate(),
            false => json.dialect.validate_painted(),
        };
        validated.map_err(|e| error("/dialect".into(), e.to_string()))?;
        let constants = parse_constants(&json.constants)
            .map_err(|reason| error("/constants".into(), reason))?;
        let instructions = parse_instructions(&json.instructions, &json.dialect)
            .map_err(|(at, reason)| error(format!("/instructions{at}"), reason))?;
        let bump = json.bump.as_ref().map(|bump| match effects.is_empty() {
            true => parse_bump(bump),
            false => Err((String::new(), GenomeError::PaintedBump.to_string())),
        });
        let bump = bump.transpose().map_err(|(at, reason)| error(format!("/bump{at}"), reason))?;
        if json.layers.len() > LAYERS_MAX {
            let reason = format!("a genome can have at most {LAYERS_MAX} models");
            return Err(error(format!("/layers/{LAYERS_MAX}"), reason));
        }
        let mut layers = Vec::with_capacity(json.layers.len());
        for (index, layer) in json.layers.iter().enumerate() {
            let parsed = parse_layer(layer)
                .map_err(|(at, reason)| error(format!("/layers/{index}{at}"), reason))?;
            layers.push(parsed);
        }
        if has_brdf && !effects.is_empty() && instructions.is_empty() && layers.is_empty() {
            let pointer = format!("/effects/0/parameters/{}", crate::effect::BY);
            return Err(error(pointer, EffectsError::NoBrdf.to_string()));
        }
        if !has_brdf {
            check_unpainted(&json)?;
            return Self::painted(json.dialect, instructions, constants, effects)
                .map_err(|e| error(String::new(), e.to_string()));
        }
        let identity = Output::IDENTITY;
        let output = Output::new(
            json.matrix.unwrap_or(*identity.matrix()),
            json.scale.unwrap_or(*identity.scale()),
            json.offset.unwrap_or(*identity.offset()),
        )
        .map_err(|e| error("/matrix".into(), e.to_string()))?;
        let genome = Self::layered(json.dialect, instructions, constants, output, layers)
            .map(|genome| genome.with_limit(json.limit).with_bump(bump));
        let painted = |genome: Self| match effects.is_empty() {
            true => Ok(genome),
            false => genome.with_effects(effects),
        };
        genome.and_then(painted).map_err(|e| error(String::new(), e.to_string()))
    }
}

/// Rejects parts of a BRDF, which effects that paint light cannot have beside them.
fn check_unpainted(json: &GenomeJson) -> Result<(), JsonError> {
    let parts = [
        ("layers", !json.layers.is_empty()),
        ("limit", json.limit),
        ("matrix", json.matrix.is_some()),
        ("scale", json.scale.is_some()),
        ("offset", json.offset.is_some()),
    ];
    match parts.into_iter().find(|(_, is_given)| *is_given) {
        Some((name, _)) => {
            let reason = format!("a genome with effects has no {name}, unless `by brdf`");
            Err(JsonError { pointer: format!("/{name}"), reason })
        }
        None => Ok(()),
    }
}

/// Returns the constants that are not 0.
fn constants_json(genome: &Genome) -> ConstantsJson {
    let constants = genome.constants().iter().enumerate();
    let given = constants.filter(|(_, constant)| constant.iter().any(|v| v.to_bits() != 0));
    given.map(|(index, constant)| (format!("C{index}"), *constant)).collect()
}

fn parse_constants(json: &ConstantsJson) -> Result<Box<[[f32; 4]; CONSTANTS]>, String> {
    let mut constants = Box::new([[0.0; 4]; CONSTANTS]);
    for (name, constant) in json {
        let index = name.strip_prefix('C').and_then(|digits| digits.parse::<usize>().ok());
        let slot = index.and_then(|index| constants.get_mut(index));
        *slot.ok_or("constants are named C0 to C127")? = *constant;
    }
    Ok(constants)
}

/// Parses instructions. An error is a JSON pointer relative to the list, and a reason.
fn parse_instructions(
    json: &[InstructionJson],
    dialect: &Dialect,
) -> Result<Vec<Instruction>, (String, String)> {
    let mut instructions = Vec::with_capacity(json.len().min(1024));
    for (index, instruction) in json.iter().enumerate() {
        let parsed = parse_instruction(instruction, dialect)
            .map_err(|(at, reason)| (format!("/{index}{at}"), reason))?;
        instructions.push(parsed);
    }
    Ok(instructions)
}

/// Parses bumps. An error is a JSON pointer relative to the bumps, and a reason.
fn parse_bump(json: &BumpJson) -> Result<Bump, (String, String)> {
    let BumpJson { strength, constants, instructions } = json;
    let dialect = Bump::dialect(instructions.len());
    let constants =
        parse_constants(constants).map_err(|reason| ("/constants".to_owned(), reason))?;
    let instructions = parse_instructions(instructions, &dialect)
        .map_err(|(at, reason)| (format!("/instructions{at}"), reason))?;
    Bump::new(*strength, instructions, constants).map_err(|error| {
        let at = match error {
            GenomeError::BumpStrength(_) => "/strength",
            GenomeError::BumpLength(_) => "/instructions",
            _ => "",
        };
        (at.to_owned(), error.to_string())
    })
}

fn instruction_json(instruction: &Instruction) -> InstructionJson {
    InstructionJson {
        opcode: instruction.opcode().name().to_owned(),
        dst: format!("R{}{}", instruction.dst(), instruction.write_mask()),
        src: instruction.operands().map(|operand| operand.to_string()).collect(),
    }
}

fn layer_json(model: &Model) -> LayerJson {
    let parameters = model.parameters().map(|(parameter, values)| {
        let value = match (parameter.word(values), values) {
            (Some(word), _) => ValueJson::Word(word.to_owned()),
            (None, &[red, green, blue]) => ValueJson::Color([red, green, blue]),
            (None, values) => ValueJson::Number(values[0]),
        };
        (parameter.name.to_owned(), value)
    });
    LayerJson { model: model.kind().name().to_owned(), parameters: parameters.collect() }
}

/// Parses a layer. An error is a JSON pointer relative to the layer, and a reason.
fn parse_layer(json: &LayerJson) -> Result<Model, (String, String)> {
    let kind: ModelKind =
        json.model.parse().map_err(|_| ("/model".to_owned(), "unknown model".to_owned()))?;
    json.parameters.iter().try_fold(Model::new(kind), |model, (name, value)| {
        let set = match value {
            // A choice takes no number but where one is its word.
            ValueJson::Number(number) => model.with_text(name, &number.to_string()),
            ValueJson::Color(values) => model.with(name, values).map_err(Into::into),
            ValueJson::Word(word) => model.choose(name, word).map_err(Into::into),
        };
        set.map_err(|error| (format!("/parameters/{}", escaped(name)), error.to_string()))
    })
}

/// Parses an instruction. An error is a JSON pointer relative to the instruction, and a reason.
fn parse_instruction(
    json: &InstructionJson,
    dialect: &Dialect,
) -> Result<Instruction, (String, String)> {
    let opcode = Opcode::from_name(&json.opcode)
        .ok_or_else(|| ("/opcode".to_owned(), "unknown opcode".to_owned()))?;
    let (dst, mask) = parse_destination(&json.dst).map_err(|reason| ("/dst".to_owned(), reason))?;
    let mut operands = Vec::with_capacity(3);
    for (index, text) in json.src.iter().enumerate().take(4) {
        let operand = parse_operand(text, opcode);
        operands.push(operand.map_err(|reason| (format!("/src/{index}"), reason))?);
    }
    Instruction::new(opcode, dst, mask, &operands, dialect)
        .map_err(|error| (String::new(), error.to_string()))
}

/// Deserialises, with the path of an error as a JSON pointer.
fn serde_path(value: serde_json::Value) -> Result<GenomeJson, (String, String)> {
    check_numbers(&value)?;
    serde_path_to_error::deserialize(value)
        .map_err(|error| (pointer(error.path()), error.inner().to_string()))
}

/// Checks the constants before deserialisation, because f32 fields would read 1e39 as infinity and
/// the pointer must be exact.
fn check_numbers(value: &serde_json::Value) -> Result<(), (String, String)> {
    for prefix in ["", "/bump"] {
        let at = format!("{prefix}/constants");
        let constants = value.pointer(&at).and_then(|v| v.as_object());
        for (name, list) in constants.into_iter().flatten() {
            for (place, number) in list.as_array().into_iter().flatten().enumerate() {
                if number.as_f64().is_none_or(|v| v.abs() > f64::from(crate::RANGE)) {
                    let reason = "not a number from -65504 to 65504".to_owned();
                    return Err((format!("{at}/{name}/{place}"), reason));
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BirthKey, Variation};

    #[test]
    fn json_round_trips() {
        for seed in 0..50 {
            let key = BirthKey { seed, slot: 0, attempt: 0 };
            let output = Output::saturation(0.65).unwrap();
            let genome = Variation::random(Dialect::default()).with_output(Some(output)).birth(key);
            let text = serde_json::to_string(&genome.to_json()).unwrap();
            let back = Genome::from_json(serde_json::from_str(&text).unwrap()).unwrap();
            assert_eq!(back, genome);
            assert_eq!(back.hash(), genome.hash());
        }
    }

    #[test]
    fn json_errors_point_at_the_value() {
        let key = BirthKey { seed: 1, slot: 0, attempt: 0 };
        let good = Variation::random(Dialect::default()).birth(key).to_json();
        let check = |path: &str, value: serde_json::Value, pointer: &str| {
            let mut json = good.clone();
            *json.pointer_mut(path).unwrap() = value;
            assert_eq!(Genome::from_json(json).unwrap_err().pointer, pointer, "{path}");
        };
        check("/instructions/3/opcode", "FOO".into(), "/instructions/3/opcode");
        check("/instructions/3/dst", "R9".into(), "/instructions/3");
        check("/instructions/7/src/0", "Q1".into(), "/instructions/7/src/0");
        check("/dialect/registers", 3.into(), "/dialect");
        check("/constants/C0/2", 1e9.into(), "/constants/C0/2");
        check("/brood", 2.into(), "/brood");
        check("/instructions/2/src", 5.into(), "/instructions/2/src");
    }
}

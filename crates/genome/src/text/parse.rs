//! Parser of the text form. It checks everything and stops at the first error.

use std::str::FromStr;

use super::TextError;
use super::cursor::{Cursor, Word, quote, shortened};
use super::effect::EffectReader;
use crate::effect::{self, Effect, Palette};
use crate::operand::LETTERS;
use crate::{
    BUMP_LENGTH_MAX, BUMP_STRENGTH_MAX, Bump, CONSTANTS, Dialect, EffectsError, Genome,
    GenomeError, Instruction, LAYERS_MAX, Model, ModelKind, Opcode, OpcodeSet, Operand, Output,
    Parametrisation, RANGE, Register, Swizzle, WriteMask,
};

/// Largest number of instructions that a dialect allows; bounds the memory for any input.
const MAX_LENGTH: usize = 1024;

impl FromStr for Genome {
    type Err = TextError;

    fn from_str(text: &str) -> Result<Self, TextError> {
        let mut reader = Reader::default();
        let mut lines = text.trim_start_matches('\u{feff}').lines();
        check_version(lines.next().unwrap_or_default())?;
        let mut last = 1;
        for (line, text) in (2..).zip(lines) {
            last = line;
            let mut cursor = match reader.takes_colors(text) {
                true => Cursor::with_colors(text, line),
                false => Cursor::new(text, line),
            };
            if !cursor.is_at_end() {
                reader.line(&mut cursor)?;
                cursor.end()?;
            }
        }
        reader.finish(last)
    }
}

fn check_version(line: &str) -> Result<(), TextError> {
    let mut cursor = Cursor::new(line, 1);
    let word = cursor.word("`brood 1`")?;
    if word.text != "brood" {
        return Err(word.error("a genome text must begin with the line `brood 1`"));
    }
    let version = cursor.word("a format version")?;
    if version.text != "1" {
        let given = quote(version.text);
        return Err(version.error(format!("unknown format version {given}; expected 1")));
    }
    cursor.end()
}

/// Parts of the genome read so far. `None` if the directive has not been given.
struct Reader {
    dialect: Option<Dialect>,
    instructions: Vec<Instruction>,
    constants: Box<[[f32; 4]; CONSTANTS]>,
    /// True for constants that have been given; the others are 0.
    given: [bool; CONSTANTS],
    matrix: Option<[[f32; 3]; 3]>,
    scale: Option<[f32; 3]>,
    offset: Option<[f32; 3]>,
    limit: Option<bool>,
    layers: Vec<Model>,
    /// Names of the parameters given for the last layer.
    parameters: Vec<String>,
    effects: Vec<Effect>,
    /// Effect whose lines are being read.
    effect: Option<EffectReader>,
    /// Name of the first line of a BRDF that genomes painted by light cannot have.
    unpainted: Option<&'static str>,
    /// Line and column of the word `brdf` of the light effect.
    by_brdf: Option<(u32, u32)>,
    bump: Option<BumpReader>,
}

/// Bumps read so far.
struct BumpReader {
    strength: Option<f32>,
    program: Box<Reader>,
    /// Line and column of the first line.
    begin: (u32, u32),
}

impl Default for Reader {
    fn default() -> Self {
        Self {
            dialect: None,
            instructions: Vec::new(),
            constants: Box::new([[0.0; 4]; CONSTANTS]),
            given: [false; CONSTANTS],
            matrix: None,
            scale: None,
            offset: None,
            limit: None,
            layers: Vec::new(),
            parameters: Vec::new(),
            effects: Vec::new(),
            effect: None,
            unpainted: None,
            by_brdf: None,
            bump: None,
        }
    }
}

impl Reader {
    fn line(&mut self, cursor: &mut Cursor<'_>) -> Result<(), TextError> {
        let word = cursor.word("an instruction")?;
        if word.text.starts_with('.') {
            self.end_effect()?;
        }
        self.check_unpainted(word)?;
        match word.text {
            ".dialect" => {
                let dialect = parse_dialect(cursor, word)?;
                once(&mut self.dialect, word, dialect)
            }
            ".const" => self.constant(cursor),
            ".model" => self.model(cursor, word),
            ".effect" => self.effect(cursor, word),
            ".bump" => self.bump(cursor, word),
            ".matrix" => {
                let rows = [triple(cursor)?, triple(cursor)?, triple(cursor)?];
                once(&mut self.matrix, word, rows)
            }
            ".scale" => {
                let scale = triple(cursor)?;
                once(&mut self.scale, word, scale)
            }
            ".offset" => {
                let offset = triple(cursor)?;
                once(&mut self.offset, word, offset)
            }
            ".limit" => {
                let state = cursor.word("`on` or `off`")?;
                match state.text {
                    "off" => once(&mut self.limit, word, false),
                    "on" => once(&mut self.limit, word, true),
                    _ => Err(state.error(format!("expected on or off, got {}", quote(state.text)))),
                }
            }
            directive if directive.starts_with('.') => {
                Err(word.error(format!("unknown directive {}", quote(directive))))
            }
            name if name.starts_with(|c: char| c.is_ascii_lowercase()) => match &mut self.effect {
                Some(effect) => effect.parameter(cursor, word),
                None if self.layers.is_empty() => self.instruction(cursor, word),
                None => self.parameter(cursor, word),
            },
            _ => self.instruction(cursor, word),
        }
    }

    /// True if words like `#2b1e46` are colours in a line: in the lines of an effect that take
    /// colours.
    fn takes_colors(&self, text: &str) -> bool {
        let first = text.split_ascii_whitespace().next();
        self.effect.is_some() && matches!(first, Some(Palette::COLORS | "color"))
    }

    /// Rejects lines of BRDFs after effects that paint light.
    fn check_unpainted(&mut self, word: Word<'_>) -> Result<(), TextError> {
        const UNPAINTED: [&str; 5] = [".model", ".limit", ".matrix", ".scale", ".offset"];
        let name = UNPAINTED.into_iter().find(|name| *name == word.text);
        let paints_light = !self.effects.is_empty() && self.by_brdf.is_none();
        if let (Some(name), true) = (name, paints_light) {
            let reason = format!("a genome with effects has no {name} line, unless `by brdf`");
            return Err(word.error(reason));
        }
        self.unpainted = self.unpainted.or(name);
        Ok(())
    }

    /// Reads a line of the bumps: their strength, a constant or an instruction.
    fn bump(&mut self, cursor: &mut Cursor<'_>, directive: Word<'_>) -> Result<(), TextError> {
        let bump = self.bump.get_or_insert_with(|| {
            let dialect = Some(Bump::dialect(BUMP_LENGTH_MAX));
            let program = Box::new(Self { dialect, ..Self::default() });
            BumpReader { strength: None, program, begin: (directive.line, directive.column) }
        });
        let word = cursor.word("`strength`, `const` or an instruction")?;
        match word.text {
            "strength" => {
                let strength = cursor.number_within(-BUMP_STRENGTH_MAX, BUMP_STRENGTH_MAX)?;
                once(&mut bump.strength, word, strength)
            }
            "const" => bump.program.constant(cursor),
            _ if bump.program.instructions.len() == BUMP_LENGTH_MAX => {
                let reason = GenomeError::BumpLength(BUMP_LENGTH_MAX + 1).to_string();
                Err(word.error(reason))
            }
            _ => bump.program.instruction(cursor, word),
        }
    }

    /// Begins an effect; its parameters are in the next lines.
    fn effect(&mut self, cursor: &mut Cursor<'_>, directive: Word<'_>) -> Result<(), TextError> {
        let effect = EffectReader::new(cursor, directive)?;
        effect::check_next(&self.effects, effect.kind())
            .map_err(|error| directive.error(error.to_string()))?;
        self.effect = Some(effect);
        Ok(())
    }

    /// Ends the effect whose lines are being read.
    fn end_effect(&mut self) -> Result<(), TextError> {
        let Some(reader) = self.effect.take() else { return Ok(()) };
        let ((line, column), by) = (reader.begin(), reader.place(effect::BY));
        let effect = reader.finish()?;
        if effect.is_by_brdf() {
            self.by_brdf = Some(by);
        } else if let (Some(name), None) = (self.unpainted, self.by_brdf) {
            // Only now is it known that the effect paints light.
            let reason = format!("a genome with a {name} line has no effects, unless `by brdf`");
            return Err(TextError { line, column, reason });
        }
        effect::check_images(&self.effects, &effect).map_err(|error| TextError {
            line,
            column,
            reason: error.to_string(),
        })?;
        self.effects.push(effect);
        Ok(())
    }

    fn model(&mut self, cursor: &mut Cursor<'_>, directive: Word<'_>) -> Result<(), TextError> {
        let word = cursor.word("the name of a model")?;
        let kind: ModelKind = word.text.parse().map_err(|_| {
            let known = ModelKind::ALL.map(ModelKind::name).join(", ");
            word.error(format!("unknown model {}; known models: {known}", quote(word.text)))
        })?;
        if self.layers.len() == LAYERS_MAX {
            return Err(directive.error(format!("a genome can have at most {LAYERS_MAX} models")));
        }
        self.layers.push(Model::new(kind));
        self.parameters.clear();
        Ok(())
    }

    /// Reads a parameter of the last model.
    fn parameter(&mut self, cursor: &mut Cursor<'_>, word: Word<'_>) -> Result<(), TextError> {
        let model = self.layers.last_mut().expect("a model has been named");
        let known = model.kind().parameters();
        if !known.iter().any(|parameter| parameter.name == word.text) {
            let known: Vec<&str> = known.iter().map(|parameter| parameter.name).collect();
            let (kind, name, known) = (model.kind(), quote(word.text), known.join(", "));
            return Err(word.error(format!("{kind} has no parameter {name}; it has {known}")));
        }
        if self.parameters.iter().any(|given| given == word.text) {
            return Err(word.error(format!("{} is given twice", word.text)));
        }
        self.parameters.push(word.text.to_owned());
        let mut values = Vec::new();
        while !cursor.is_at_end() {
            values.push(cursor.word("a value")?);
        }
        let at = *values.first().unwrap_or(&word);
        let text: Vec<&str> = values.iter().map(|value| value.text).collect();
        let read = model.clone().with_text(word.text, &text.join(" "));
        *model = read.map_err(|error| at.error(shortened(&error.to_string())))?;
        Ok(())
    }

    fn constant(&mut self, cursor: &mut Cursor<'_>) -> Result<(), TextError> {
        let word = cursor.word("a constant register")?;
        let index = match parse_register(word.text) {
            Some(Register::Constant(index)) if usize::from(index) < CONSTANTS => usize::from(index),
            _ => {
                let given = quote(word.text);
                return Err(
                    word.error(format!("expected a constant register C0 to C127, got {given}"))
                );
            }
        };
        if std::mem::replace(&mut self.given[index], true) {
            return Err(word.error(format!("C{index} is given twice")));
        }
        for component in &mut self.constants[index] {
            *component = cursor.number(-RANGE)?;
        }
        Ok(())
    }

    fn instruction(&mut self, cursor: &mut Cursor<'_>, word: Word<'_>) -> Result<(), TextError> {
        self.end_effect()?;
        let Some(dialect) = self.dialect else {
            return Err(
                word.error("the line `.dialect ...` must come before the first instruction")
            );
        };
        let Some(opcode) = Opcode::from_name(word.text) else {
            return Err(word.error(format!("unknown opcode {}", quote(word.text))));
        };
        if self.instructions.len() == MAX_LENGTH {
            return Err(word.error("a genome can have at most 1024 instructions"));
        }
        let target = cursor.word("a destination register")?;
        let (dst, mask) = parse_destination(target.text).map_err(|reason| target.error(reason))?;
        let mut operands = Vec::with_capacity(3);
        while !cursor.is_at_end() {
            cursor.comma()?;
            let word = cursor.word("an operand")?;
            let operand = parse_operand(word.text, opcode).map_err(|reason| word.error(reason))?;
            operands.push(operand);
        }
        let instruction = Instruction::new(opcode, dst, mask, &operands, &dialect)
            .map_err(|error| word.error(error.to_string()))?;
        self.instructions.push(instruction);
        Ok(())
    }

    /// Returns the genome. `last` is the number of the last line, for errors.
    fn finish(mut self, last: u32) -> Result<Genome, TextError> {
        self.end_effect()?;
        let error = |reason: String| TextError { line: last, column: 1, reason };
        let limited = self.limit.unwrap_or(false);
        let has_parts = !self.layers.is_empty() || !self.effects.is_empty();
        let Some(mut dialect) = self.dialect.or(has_parts.then(Dialect::default)) else {
            let reason = "expected a `.dialect` line, a `.model` line or an `.effect` line";
            return Err(error(reason.into()));
        };
        if self.instructions.is_empty() && !has_parts {
            return Err(error(
                "a genome must have at least one instruction, one `.model` or one `.effect`".into(),
            ));
        }
        dialect.length = u16::try_from(self.instructions.len()).expect("at most 1024");
        let identity = Output::IDENTITY;
        let output = Output::new(
            self.matrix.unwrap_or(*identity.matrix()),
            self.scale.unwrap_or(*identity.scale()),
            self.offset.unwrap_or(*identity.offset()),
        )
        .map_err(|e| error(e.to_string()))?;
        let Self { instructions, constants, layers, effects, by_brdf, bump, .. } = self;
        let begin = bump.as_ref().map(|bump| bump.begin);
        let at_bump = |reason: GenomeError| {
            let (line, column) = begin.unwrap_or((last, 1));
            TextError { line, column, reason: reason.to_string() }
        };
        if !effects.is_empty() && bump.is_some() {
            return Err(at_bump(GenomeError::PaintedBump));
        }
        let bump = bump.map(|BumpReader { strength, program, .. }| {
            Bump::new(strength.unwrap_or(1.0), program.instructions, program.constants)
        });
        let bump = bump.transpose().map_err(at_bump)?;
        if let Some((line, column)) = by_brdf.filter(|_| dialect.length == 0 && layers.is_empty()) {
            return Err(TextError { line, column, reason: EffectsError::NoBrdf.to_string() });
        }
        if !effects.is_empty() && by_brdf.is_none() {
            let genome = Genome::painted(dialect, instructions, constants, effects);
            return genome.map_err(|e| error(e.to_string()));
        }
        let genome = Genome::layered(dialect, instructions, constants, output, layers);
        let genome = genome.map(|genome| genome.with_limit(limited).with_bump(bump));
        let painted = |genome: Genome| match effects.is_empty() {
            true => Ok(genome),
            false => genome.with_effects(effects),
        };
        genome.and_then(painted).map_err(|e| error(e.to_string()))
    }
}

/// Stores the value of a directive; error if it was given before.
fn once<T>(slot: &mut Option<T>, word: Word<'_>, value: T) -> Result<(), TextError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(word.error(format!("{} is given twice", word.text))),
    }
}

/// Reads three numbers of the output stage.
fn triple(cursor: &mut Cursor<'_>) -> Result<[f32; 3], TextError> {
    Ok([cursor.number(0.0)?, cursor.number(0.0)?, cursor.number(0.0)?])
}

/// Reads the words of a `.dialect` line. The length is set at the end of the text.
fn parse_dialect(cursor: &mut Cursor<'_>, directive: Word<'_>) -> Result<Dialect, TextError> {
    let mut dialect = Dialect { length: 1, ..Dialect::default() };
    let word = cursor.word("`paper`, `extended` or `directed`")?;
    dialect.opcodes = match word.text {
        "paper" => OpcodeSet::Paper,
        "extended" => OpcodeSet::Extended,
        "directed" => OpcodeSet::Directed,
        _ => return Err(word.error("the opcode set must be `paper`, `extended` or `directed`")),
    };
    let word = cursor.word("`smooth` or `paper`")?;
    dialect.parametrisation = match word.text {
        "smooth" => Parametrisation::Smooth,
        "paper" => Parametrisation::Paper,
        _ => return Err(word.error("the parametrisation must be `smooth` or `paper`")),
    };
    let word = cursor.word("`registers`")?;
    if word.text != "registers" {
        return Err(word.error("expected `registers` and their number"));
    }
    let word = cursor.word("the number of registers")?;
    dialect.registers = word
        .text
        .parse()
        .map_err(|_| word.error(format!("{} is not a number of registers", quote(word.text))))?;
    while !cursor.is_at_end() {
        let word = cursor.word("`isotropic` or `homogeneous`")?;
        let switch = match word.text {
            "isotropic" => &mut dialect.isotropic,
            "homogeneous" => &mut dialect.homogeneous,
            other => {
                return Err(
                    word.error(format!("expected isotropic or homogeneous, got {}", quote(other)))
                );
            }
        };
        if std::mem::replace(switch, true) {
            return Err(word.error(format!("{} is given twice", word.text)));
        }
    }
    // Effects may follow; the genome checks that a directed dialect has them.
    dialect.validate_painted().map_err(|error| directive.error(error.to_string()))?;
    Ok(dialect)
}

/// Parses `R5` or `C12`; leading zeros are rejected.
fn parse_register(text: &str) -> Option<Register> {
    let (kind, digits) = text.split_at_checked(1)?;
    let canonical = digits == "0" || !digits.starts_with('0');
    let index = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())??;
    match kind {
        "R" if canonical => Some(Register::Temporary(index)),
        "C" if canonical => Some(Register::Constant(index)),
        _ => None,
    }
}

/// Parses `R5` or `R5.xyz`.
pub(crate) fn parse_destination(text: &str) -> Result<(u8, WriteMask), String> {
    let (register, mask) = split_suffix(text);
    let Some(Register::Temporary(dst)) = parse_register(register) else {
        return Err(format!("{} is not a temporary register", quote(register)));
    };
    let Some(mask) = mask else { return Ok((dst, WriteMask::ALL)) };
    let mut bits = 0;
    for letter in mask.chars() {
        let component = LETTERS.iter().position(|l| *l == letter);
        match component {
            Some(component) if bits >> component == 0 => bits |= 1 << component,
            _ => {
                return Err(format!(
                    "a write mask must be letters of xyzw in order, got {}",
                    quote(mask)
                ));
            }
        }
    }
    match WriteMask::new(bits) {
        Some(mask) => Ok((dst, mask)),
        None => Err("a write mask must have at least one letter".into()),
    }
}

/// Parses `-R1.yzyy`, `C5.x` or `R2`.
pub(crate) fn parse_operand(text: &str, opcode: Opcode) -> Result<Operand, String> {
    let (negate, rest) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let (register, letters) = split_suffix(rest);
    let register =
        parse_register(register).ok_or_else(|| format!("{} is not a register", quote(register)))?;
    let letters = letters.unwrap_or_default();
    let components: Option<Vec<u8>> = letters
        .chars()
        .map(|letter| LETTERS.iter().position(|l| *l == letter).map(|index| index as u8))
        .collect();
    let swizzle = match components.as_deref() {
        Some([]) if rest.contains('.') => Err("a swizzle must have one letter or four".to_owned()),
        Some([]) if opcode.is_scalar() => {
            Err(format!("{} takes an operand with exactly one swizzle letter", opcode.name()))
        }
        Some([]) => Ok(Swizzle::IDENTITY),
        Some([component]) => Ok(Swizzle::splat(*component)),
        Some(_) if opcode.is_scalar() => {
            Err(format!("{} takes an operand with exactly one swizzle letter", opcode.name()))
        }
        Some(&[x, y, z, w]) => Ok(Swizzle::new([x, y, z, w])),
        _ => Err(format!("a swizzle must be one letter or four of xyzw, got {}", quote(letters))),
    }?;
    Ok(Operand { register, swizzle, negate })
}

fn split_suffix(text: &str) -> (&str, Option<&str>) {
    match text.split_once('.') {
        Some((register, suffix)) => (register, Some(suffix)),
        None => (text, None),
    }
}

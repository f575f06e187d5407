//! Parser of the lines of an effect.

use brood_brdf::display_codes;

use super::TextError;
use super::cursor::{Cursor, Word, quote, shortened};
use crate::effect::{Effect, EffectImage, EffectKind, Palette};
use crate::{ImageHash, ParameterValues};

/// Effect whose lines are being read.
pub(super) struct EffectReader {
    kind: EffectKind,
    values: ParameterValues,
    colors: Option<Vec<[u8; 3]>>,
    edges: Option<Vec<f64>>,
    images: Vec<EffectImage>,
    /// Line and column of the `.effect` line.
    begin: (u32, u32),
    /// Names of the parameters given, each with line and column of its first value.
    given: Vec<(String, (u32, u32))>,
}

impl EffectReader {
    /// Reads the rest of an `.effect` line.
    pub(super) fn new(cursor: &mut Cursor<'_>, directive: Word<'_>) -> Result<Self, TextError> {
        let word = cursor.word("the name of an effect")?;
        let kind = EffectKind::from_name(word.text).ok_or_else(|| {
            let known = EffectKind::ALL.map(EffectKind::name).join(", ");
            word.error(format!("unknown effect {}; known effects: {known}", quote(word.text)))
        })?;
        Ok(Self {
            kind,
            values: ParameterValues::new(kind.name(), kind.parameters()),
            colors: None,
            edges: None,
            images: Vec::new(),
            begin: (directive.line, directive.column),
            given: Vec::new(),
        })
    }

    pub(super) fn kind(&self) -> EffectKind {
        self.kind
    }

    /// Line and column of the value given for a parameter, or else of the effect.
    pub(super) fn place(&self, parameter: &str) -> (u32, u32) {
        let found = self.given.iter().find(|(name, _)| name == parameter);
        found.map_or(self.begin, |(_, at)| *at)
    }

    /// Line and column of the `.effect` line.
    pub(super) fn begin(&self) -> (u32, u32) {
        self.begin
    }

    /// Reads a line of a parameter, a palette or edges; `word` is its name.
    pub(super) fn parameter(
        &mut self,
        cursor: &mut Cursor<'_>,
        word: Word<'_>,
    ) -> Result<(), TextError> {
        let name = word.text;
        if self.given.iter().any(|(given, _)| given == name) {
            return Err(word.error(format!("{name} is given twice")));
        }
        let mut values = Vec::new();
        while !cursor.is_at_end() {
            values.push(cursor.word("a value")?);
        }
        let at = *values.first().unwrap_or(&word);
        self.given.push((name.to_owned(), (at.line, at.column)));
        if let Some(place) = self.kind.image_place(name) {
            self.images.push(image(place, &values, at)?);
            return Ok(());
        }
        match (name, self.kind.has_palette()) {
            (Palette::COLORS, true) => {
                self.colors = Some(values.iter().map(color).collect::<Result<_, _>>()?);
            }
            (Palette::EDGES, true) => {
                self.edges = Some(values.iter().map(number).collect::<Result<_, _>>()?);
            }
            _ => {
                let known = self.names();
                if !known.contains(&name) {
                    let (kind, name, known) = (self.kind, quote(name), known.join(", "));
                    let reason = format!("{kind} has no parameter {name}; it has {known}");
                    return Err(word.error(reason));
                }
                let text: Vec<&str> = values.iter().map(|value| value.text).collect();
                let set = self.values.set_text(name, &text.join(" "));
                set.map_err(|error| at.error(shortened(&error.to_string())))?;
            }
        }
        Ok(())
    }

    /// Returns the effect.
    pub(super) fn finish(self) -> Result<Effect, TextError> {
        let error = |parameter: &str, reason: String| {
            let (line, column) = self.place(parameter);
            TextError { line, column, reason }
        };
        let palette = Palette::new(self.colors.clone(), self.edges.clone())
            .map_err(|palette| error(palette.parameter(), palette.to_string()))?;
        let palette = self.kind.has_palette().then_some(palette);
        Effect::new(self.kind, self.values.clone(), palette)
            .and_then(|effect| effect.with_images(self.images.clone()))
            .map_err(|effect| error(effect.parameter, effect.reason))
    }

    /// Names of the parameters of the kind.
    fn names(&self) -> Vec<&'static str> {
        let palette = [Palette::COLORS, Palette::EDGES].into_iter();
        let palette = palette.filter(|_| self.kind.has_palette());
        let images = self.kind.image_places().iter().map(|place| place.name);
        let own = self.kind.parameters().iter().map(|parameter| parameter.name);
        palette.chain(own).chain(images).collect()
    }
}

/// Reads an image: its hash, and its share if that is not 1.
fn image(place: &'static str, values: &[Word<'_>], at: Word<'_>) -> Result<EffectImage, TextError> {
    let (hash, share) = match values {
        [hash] => (hash, 1.0),
        [hash, share] => (hash, number(share)?),
        _ => {
            let count = values.len();
            let reason =
                format!("{place} takes the hash of an image and its share, got {count} values");
            return Err(at.error(reason));
        }
    };
    let image = hash.text.parse::<ImageHash>();
    let image = image.map_err(|_| {
        let given = quote(hash.text);
        hash.error(format!(
            "an image is named by the 64 hexadecimal digits of its hash, got {given}"
        ))
    })?;
    Ok(EffectImage { place, image, share })
}

fn color(word: &Word<'_>) -> Result<[u8; 3], TextError> {
    display_codes(word.text).ok_or_else(|| {
        word.error(format!("expected a colour like #2b1e46, got {}", quote(word.text)))
    })
}

fn number(word: &Word<'_>) -> Result<f64, TextError> {
    let number = word.text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| word.error(format!("expected a number, got {}", quote(word.text))))
}

//! Words of the effects of a style: their number, then for each the number of its kind, its palette
//! if the kind has one (number of colours, one word 0xRRGGBB for each, two words for each edge),
//! and two words for each parameter value. Bit 8 of the first word marks an effect with images. Its
//! images are last: their number, then for each image one word for the place, eight for the hash
//! and two for the share.

use brood_genome::{
    Effect, EffectImage, EffectKind, ImageHash, Palette, Parameter, ParameterValues,
};

use super::part::{WordsError, halves, joined, length};

/// Bit of an effect with images.
const HAS_IMAGES: u32 = 1 << 8;
/// Number of words of a hash.
const HASH: usize = 8;

pub(super) fn write(effects: &[Effect], words: &mut Vec<u32>) {
    words.push(length(effects.len()));
    for effect in effects {
        let images = effect.images();
        let flag = if images.is_empty() { 0 } else { HAS_IMAGES };
        words.push(u32::from(effect.kind().number()) | flag);
        if let Some(palette) = effect.palette() {
            words.push(length(palette.colors().len()));
            let color = |[red, green, blue]: &[u8; 3]| u32::from_be_bytes([0, *red, *green, *blue]);
            words.extend(palette.colors().iter().map(color));
            words.extend(palette.edges().iter().copied().flat_map(halves));
        }
        words.extend(effect.values().values().iter().copied().flat_map(halves));
        if flag != 0 {
            words.push(length(images.len()));
        }
        for EffectImage { place, image, share } in images {
            let places = effect.kind().image_places();
            let at = places.iter().position(|own| own.name == *place);
            words.push(length(at.expect("images take places of their effect")));
            let hash = image.as_bytes().as_chunks().0.iter();
            words.extend(hash.map(|bytes| u32::from_le_bytes(*bytes)));
            words.extend(halves(*share));
        }
    }
}

/// Reads the effects, which end with the words.
pub(super) fn read(words: &[u32], start: usize) -> Result<Vec<Effect>, WordsError> {
    let mut reader = Reader { words, at: start };
    let count = reader.count(1, EffectKind::ALL.len())?;
    let effects = (0..count).map(|_| reader.effect()).collect::<Result<Vec<_>, _>>()?;
    if reader.at != words.len() {
        return Err(WordsError::Length);
    }
    Effect::check_all(&effects).map_err(|_| WordsError::Effect(start))?;
    Ok(effects)
}

struct Reader<'a> {
    words: &'a [u32],
    at: usize,
}

impl Reader<'_> {
    fn word(&mut self) -> Result<u32, WordsError> {
        let word = self.words.get(self.at).ok_or(WordsError::Length)?;
        self.at += 1;
        Ok(*word)
    }

    fn count(&mut self, least: usize, most: usize) -> Result<usize, WordsError> {
        let at = self.at;
        let count = self.word()? as usize;
        if (least..=most).contains(&count) { Ok(count) } else { Err(WordsError::Effect(at)) }
    }

    fn numbers(&mut self, count: usize) -> Result<Vec<f64>, WordsError> {
        (0..count).map(|_| Ok(joined(self.word()?, self.word()?))).collect()
    }

    fn effect(&mut self) -> Result<Effect, WordsError> {
        let at = self.at;
        let invalid = || WordsError::Effect(at);
        let word = self.word()?;
        let has_images = word & HAS_IMAGES != 0;
        let kind = u8::try_from(word & !HAS_IMAGES).ok().and_then(EffectKind::from_number);
        let kind = kind.ok_or_else(invalid)?;
        let palette = if kind.has_palette() { Some(self.palette(at)?) } else { None };
        let table = kind.parameters();
        let values = self.numbers(table.iter().map(Parameter::count).sum())?;
        let values = ParameterValues::from_values(kind.name(), table, &values);
        let effect = Effect::new(kind, values.map_err(|_| invalid())?, palette);
        let images = if has_images { self.images(kind)? } else { Vec::new() };
        effect.and_then(|effect| effect.with_images(images)).map_err(|_| invalid())
    }

    /// Reads the images of an effect, in the order of their places.
    fn images(&mut self, kind: EffectKind) -> Result<Vec<EffectImage>, WordsError> {
        let places = kind.image_places();
        let count = self.count(1, places.len())?;
        let mut next = 0;
        let image = |_| {
            let place = self.count(next, places.len() - 1)?;
            next = place + 1;
            let mut hash = [0; 4 * HASH];
            for bytes in hash.chunks_exact_mut(4) {
                bytes.copy_from_slice(&self.word()?.to_le_bytes());
            }
            let share = joined(self.word()?, self.word()?);
            let image = ImageHash::from_bytes(hash);
            Ok(EffectImage { place: places[place].name, image, share })
        };
        (0..count).map(image).collect()
    }

    /// Reads the palette of the effect at a word.
    fn palette(&mut self, at: usize) -> Result<Palette, WordsError> {
        let count = self.count(brood_genome::PALETTE_MIN, brood_genome::PALETTE_MAX)?;
        let color = |word: u32| match word.to_be_bytes() {
            [0, red, green, blue] => Ok([red, green, blue]),
            _ => Err(WordsError::Effect(at)),
        };
        let colors = (0..count).map(|_| color(self.word()?)).collect::<Result<_, _>>()?;
        let edges = self.numbers(count - 1)?;
        Palette::new(Some(colors), Some(edges)).map_err(|_| WordsError::Effect(at))
    }
}

//! What becomes of the pixels of a picture, and how many each fate has.

use std::fmt;

use brood_brdf::DirectionPair;

/// What became of the pixels of pictures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct PixelCounts {
    /// All of them.
    pub pixels: u64,
    /// Those that are samples.
    pub used: u64,
    /// Left out by the mask.
    pub masked: u64,
    /// Nothing is there.
    pub background: u64,
    /// The edge of the object, or one within it.
    pub edge: u64,
    /// As bright as the picture can show.
    pub clipped: u64,
    /// No light arrives.
    pub unlit: u64,
    /// The edge of light and shadow.
    pub half_lit: u64,
    /// Light of several lamps arrives, which cannot be told apart.
    pub several_lights: u64,
    /// Light or eye is at the horizon.
    pub grazing: u64,
}

/// What became of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelFate {
    /// It is a sample.
    Used,
    /// Left out by the mask.
    Masked,
    /// Nothing is there.
    Background,
    /// The edge of the object, or one within it.
    Edge,
    /// As bright as the picture can show.
    Clipped,
    /// No light arrives.
    Unlit,
    /// The edge of light and shadow.
    HalfLit,
    /// Light of several lamps arrives.
    SeveralLights,
    /// Light or eye is at the horizon.
    Grazing,
}

/// What a pixel that is covered says of the material, or why it says nothing.
pub(super) enum Look {
    Sample(DirectionPair, [f64; 3]),
    /// f is not below that.
    Least(DirectionPair, [f64; 3]),
    Nothing(PixelFate),
}

impl PixelCounts {
    pub(super) fn add(&mut self, fate: PixelFate) {
        *match fate {
            PixelFate::Used => &mut self.used,
            PixelFate::Masked => &mut self.masked,
            PixelFate::Background => &mut self.background,
            PixelFate::Edge => &mut self.edge,
            PixelFate::Clipped => &mut self.clipped,
            PixelFate::Unlit => &mut self.unlit,
            PixelFate::HalfLit => &mut self.half_lit,
            PixelFate::SeveralLights => &mut self.several_lights,
            PixelFate::Grazing => &mut self.grazing,
        } += 1;
    }
}

impl fmt::Display for PixelCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "of {} pixels", self.pixels)?;
        let all = [
            (self.masked, "masked"),
            (self.background, "background"),
            (self.edge, "at edges"),
            (self.clipped, "clipped"),
            (self.unlit, "unlit"),
            (self.half_lit, "partly in shadow"),
            (self.several_lights, "lit by several lights"),
            (self.grazing, "at grazing angles"),
        ];
        let mut before = " ";
        for (count, what) in all.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "{before}{count} are {what}")?;
            before = ", ";
        }
        Ok(())
    }
}

impl PixelCounts {
    /// Of two pictures together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            used: self.used + other.used,
            masked: self.masked + other.masked,
            background: self.background + other.background,
            edge: self.edge + other.edge,
            clipped: self.clipped + other.clipped,
            unlit: self.unlit + other.unlit,
            half_lit: self.half_lit + other.half_lit,
            several_lights: self.several_lights + other.several_lights,
            grazing: self.grazing + other.grazing,
        }
    }
}

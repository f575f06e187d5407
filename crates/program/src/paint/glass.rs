//! Lowering of clear bodies: colours that mirrored and refracted rays see, by inputs.

use brood_brdf::{Input, InputMask};
use brood_genome::{Effect, EffectKind, Function, ScalarMachine};

use super::Painter;
use crate::build::Reference;
use crate::{Meaning, Program};

/// Inputs of the mirrored way: red, green, blue and length.
const MIRRORED: [Input; 4] =
    [Input::MirroredRed, Input::MirroredGreen, Input::MirroredBlue, Input::MirroredLength];
/// Inputs of a way out of a body: red, green, blue and length.
const WAYS: [[Input; 4]; 2] = [
    [Input::Way0Red, Input::Way0Green, Input::Way0Blue, Input::Way0Length],
    [Input::Way1Red, Input::Way1Green, Input::Way1Blue, Input::Way1Length],
];

impl Program {
    /// Returns the glass effect of a style that shows one; `None` for other programs.
    #[must_use]
    pub fn glass(&self) -> Option<&Effect> {
        let Meaning::Style(effects) = &self.meaning else { return None };
        let glass = effects.iter().find(|effect| effect.kind() == EffectKind::Glass);
        glass.filter(|effect| effect.scalar("strength") > 0.0)
    }

    /// Returns the share of light that passes through a body of this material into shadows, in
    /// steps of one eighth, so that similar materials share samples; 0 if it is opaque.
    #[must_use]
    pub fn clearness(&self) -> f64 {
        self.glass().map_or(0.0, |glass| (8.0 * glass.scalar("strength")).round() / 8.0)
    }

    /// Returns the style without its glass effect. Other programs are returned as they are.
    #[must_use]
    pub fn without_glass(&self) -> Self {
        let mut program = self.clone();
        if let Meaning::Style(effects) = &mut program.meaning {
            effects.retain(|effect| effect.kind() != EffectKind::Glass);
        }
        program
    }

    /// True if the program reads what mirrored eye rays see.
    #[must_use]
    pub fn reads_mirrored(&self) -> bool {
        self.inputs().contains(Input::MirroredLength)
    }

    /// True if the program reads what the eye sees through a clear body.
    #[must_use]
    pub fn reads_ways(&self) -> bool {
        let ways: InputMask = WAYS.as_flattened().iter().copied().collect();
        self.inputs().iter().any(|input| ways.contains(input))
    }
}

impl Painter<'_> {
    /// Mixes glass over colours: I + k (J - I) with J = F M + (1 - F) X.
    pub(super) fn glass(&mut self, effect: &Effect, under: [Reference; 3]) -> [Reference; 3] {
        let mirrored_share = self.fresnel(effect);
        let passed_share = self.complement(mirrored_share);
        let strength = self.strength(effect);
        let (mirror, see) = (effect.scalar("mirror"), effect.scalar("see"));
        let (mirror, see) = (self.number(mirror), self.number(see));
        let depth = effect.color("color");
        let mut over = under;
        for (channel, over) in over.iter_mut().enumerate() {
            let depth = self.number(depth[channel]);
            let mirrored = self.way(effect, (MIRRORED, channel), depth);
            let mirrored = self.mul(mirror, mirrored);
            let [first, second] = WAYS.map(|way| self.way(effect, (way, channel), depth));
            let share = self.builder.input(Input::Way0Share);
            let seen = self.mixed(second, first, share);
            let seen = self.mul(see, seen);
            let (mirrored, seen) =
                (self.mul(mirrored_share, mirrored), self.mul(passed_share, seen));
            let color = self.add(mirrored, seen);
            *over = self.mixed(*over, color, strength);
        }
        over
    }

    /// Share of the mirror: F = f0 + (f1 - f0) (1 - n.e)^q.
    fn fresnel(&mut self, effect: &Effect) -> Reference {
        let (from, to) = (effect.scalar("from"), effect.scalar("to"));
        let cosine = self.builder.input(Input::NormalDotEye);
        let limb = self.complement(cosine);
        let limb = self.saturate(limb);
        let power = self.power(limb, effect.scalar("exponent"));
        let (least, more) = (self.number(from), self.number(to - from));
        let more = self.mul(more, power);
        self.add(least, more)
    }

    /// Colour through a way out: D + T (X - D) with T = 2^(-d / h).
    fn way(
        &mut self,
        effect: &Effect,
        (way, channel): ([Input; 4], usize),
        depth: Reference,
    ) -> Reference {
        let length = self.builder.input(way[3]);
        let per_radius = self.number(-1.0 / effect.scalar("depth"));
        let exponent = self.mul(per_radius, length);
        let clear = self.builder.function(Function::Ex2, exponent);
        let clear = self.saturate(clear);
        let color = self.builder.input(way[channel]);
        self.mixed(depth, color, clear)
    }

    /// x^q for x in [0, 1], as 2^(q/2 log2(x^2)).
    pub(super) fn power(&mut self, x: Reference, exponent: f64) -> Reference {
        if exponent <= 1.0 {
            return x;
        }
        let logarithm = self.builder.function(Function::Lg2, x);
        let half = self.number(0.5 * exponent);
        let power = self.mul(half, logarithm);
        let power = self.builder.function(Function::Ex2, power);
        self.saturate(power)
    }
}

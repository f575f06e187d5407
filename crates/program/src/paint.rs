//! Lowering of styles: the effects of a painted material become scalar code for a number of lights.
//!
//! docs/maths/painted.md has the formulas. Weights of colours are saturated ramps of one monotone
//! form, so they are not negative and sum to 1; every overlay is a convex step. Ramps are at least
//! as wide as the change of their argument over a pixel, so edges have no stairs.

mod glass;
mod image;
mod ramp;
mod reflected;

use brood_brdf::Lighting;
use brood_genome::{
    Basis, Effect, EffectKind, Function, Input, LightInput, Palette, ScalarMachine,
};

use crate::build::{Builder, Reference};
use crate::lower::{SCRATCH, Scratch};
use crate::{Meaning, Operand, Program};
use image::Control;
use ramp::{Amount, Painter, Ramp};

impl Program {
    /// Lowers a style for lights: returns the code of its colour at a point. Other programs are
    /// returned as they are.
    ///
    /// # Panics
    /// If there are more than [`Input::LIGHTS`] lights.
    #[must_use]
    pub fn painted(&self, lighting: Lighting) -> Self {
        assert!(lighting.lights <= Input::LIGHTS, "at most {} lights are painted", Input::LIGHTS);
        let Meaning::Style(effects) = &self.meaning else { return self.clone() };
        SCRATCH.with_borrow_mut(|Scratch { builder, collected, .. }| {
            builder.clear(false);
            let shift = shift(self, builder);
            let images = self.images();
            let mut painter = Painter { builder, lighting, images: &images };
            let mut color = [Reference::default(); 3];
            for effect in effects {
                color = match effect.kind() {
                    EffectKind::Light => painter.light(effect, shift),
                    EffectKind::Silhouette => {
                        let cosine = painter.builder.input(Input::NormalDotEye);
                        let amount = painter.complement(cosine);
                        let gradient = painter.builder.input(Input::NormalDotEyeStep);
                        painter.overlay_by(effect, color, Amount { value: amount, gradient })
                    }
                    EffectKind::Distance => {
                        let value = painter.builder.input(Input::Depth);
                        let gradient = painter.builder.input(Input::DepthStep);
                        painter.overlay_by(effect, color, Amount { value, gradient })
                    }
                    EffectKind::Highlight => painter.highlight(effect, color),
                    EffectKind::Glass => painter.glass(effect, color),
                };
            }
            let color = color.map(|channel| painter.saturate(channel));
            collected.code(builder, color, Meaning::Color)
        })
    }
}

/// Adds the steps of a style's program, and returns 2 p - 1 with p = g^2 / (1 + g^2) of the first
/// result; 0 if that is a constant, as it is without a program.
fn shift(program: &Program, builder: &mut Builder) -> Reference {
    // The program of a BRDF makes the light instead.
    if program.is_by_brdf() || matches!(program.results[0], Operand::Constant(_)) {
        return builder.constant(0.0);
    }
    let constants: Vec<Reference> =
        program.constants.iter().map(|c| builder.folded(c.canonical, c.reference)).collect();
    let mut steps: Vec<Reference> = Vec::with_capacity(program.steps.len());
    let read = |builder: &mut Builder, steps: &[Reference], operand| match operand {
        Operand::Step(index) => steps[usize::from(index)],
        Operand::Input(input) => builder.input(input),
        Operand::Constant(index) => constants[usize::from(index)],
    };
    for step in &program.steps {
        let (a, b) = (read(builder, &steps, step.a), read(builder, &steps, step.b));
        steps.push(builder.apply(step.operation, a, b));
    }
    let g = read(builder, &steps, program.results[0]);
    let one = builder.constant(1.0);
    let square = builder.mul(g, g);
    let sum = builder.add(one, square);
    let inverse = builder.function(Function::Rcp, sum);
    // 2 p - 1 = 1 - 2 / (1 + g^2).
    let minus_two = builder.constant(-2.0);
    let twice = builder.mul(minus_two, inverse);
    builder.add(one, twice)
}

/// Light that is left after some lights have been mixed in, with the length of its gradient.
#[derive(Clone, Copy)]
struct Rest {
    value: Reference,
    gradient: Reference,
}

impl Painter<'_> {
    /// Colours of a palette by the amount of light. `shift` is 2 p - 1.
    fn light(&mut self, effect: &Effect, shift: Reference) -> [Reference; 3] {
        let palette = effect.palette().expect("a light effect has a palette");
        let basis = Basis::from_name(effect.word("basis")).expect("words are those of the basis");
        let shift = self.shift_by_map(effect).unwrap_or(shift);
        let amounts = self.amounts(effect).map(|amount| self.brushed(effect, amount, shift));
        let mut mixed: [Option<Reference>; 3] = [None; 3];
        for channel in 0..3 {
            // Equal amounts give equal nodes, so that a grey amount is computed once.
            mixed[channel] = Some(match basis {
                Basis::Bezier => {
                    let colors = self.controls((palette, effect), channel);
                    self.bezier(&colors, amounts[channel].value)
                }
                _ => self.mixture((palette, effect), basis, channel, amounts[channel]),
            });
        }
        mixed.map(|channel| channel.expect("each channel has been mixed"))
    }

    /// Amounts of light of the three channels.
    fn amounts(&mut self, effect: &Effect) -> [Amount; 3] {
        if effect.word("by") == "facing" {
            return [self.facing(effect); 3];
        }
        if effect.is_by_brdf() {
            return self.reflected(effect);
        }
        self.quantities(effect).map(|quantity| {
            let mut rest = self.all();
            for light in 0..self.lighting.lights {
                let cosine = self.shadowed_cosine(effect, light);
                let gradient = self.of_light(light, LightInput::CosStep);
                let ramp = self.ramp_of(effect, Amount { value: cosine, gradient });
                let color = self.of_light(light, quantity);
                let (value, gradient) =
                    (self.mul(color, ramp.value), self.mul(color, ramp.gradient));
                rest = self.without(rest, Amount { value, gradient });
            }
            let strength = self.scalar(effect, "strength");
            let value = self.complement(rest.value);
            Amount { value: self.mul(strength, value), gradient: self.mul(strength, rest.gradient) }
        })
    }

    /// Amount by the cosine to the eye: a power of its ramp.
    fn facing(&mut self, effect: &Effect) -> Amount {
        let value = self.builder.input(Input::NormalDotEye);
        let gradient = self.builder.input(Input::NormalDotEyeStep);
        let ramp = self.ramp_of(effect, Amount { value, gradient });
        let exponent = effect.scalar("exponent");
        let strength = self.scalar(effect, "strength");
        if exponent <= 1.0 {
            let (value, gradient) = (ramp.value, ramp.gradient);
            return Amount {
                value: self.mul(strength, value),
                gradient: self.mul(strength, gradient),
            };
        }
        let power = self.power(ramp.value, exponent);
        let slope = self.number(exponent);
        let gradient = self.mul(slope, ramp.gradient);
        Amount { value: self.mul(strength, power), gradient: self.mul(strength, gradient) }
    }

    /// Cosine to a light, lowered where the light is occluded: c - kappa (1 - V) max(c, 0).
    /// Continuous at c = 0, where shadows end.
    fn shadowed_cosine(&mut self, effect: &Effect, light: usize) -> Reference {
        let cosine = self.of_light(light, LightInput::Cos);
        if !self.lighting.has_shadows {
            return cosine;
        }
        let lit = self.saturate(cosine);
        let occluded = self.occluded(effect, light);
        let taken = self.mul(occluded, lit);
        self.sub(cosine, taken)
    }

    /// Share of a light that its shadow takes: kappa (1 - V).
    fn occluded(&mut self, effect: &Effect, light: usize) -> Reference {
        let visibility = self.of_light(light, LightInput::Visibility);
        let hidden = self.complement(visibility);
        let shadow = self.scalar(effect, "shadow");
        self.mul(shadow, hidden)
    }

    /// Amount shifted by the program where it is neither 0 nor 1: a + 4 w (2 p - 1) a (1 - a).
    fn brushed(&mut self, effect: &Effect, amount: Amount, shift: Reference) -> Amount {
        let weight = self.number(4.0 * effect.scalar("brush"));
        let rest = self.complement(amount.value);
        let middle = self.mul(amount.value, rest);
        let weight = self.mul(weight, shift);
        let change = self.mul(weight, middle);
        let sum = self.add(amount.value, change);
        Amount { value: self.saturate(sum), ..amount }
    }

    /// One channel of a palette: C_0 + sum of (C_i - C_{i-1}) S_i.
    fn mixture(
        &mut self,
        (palette, effect): (&Palette, &Effect),
        basis: Basis,
        channel: usize,
        amount: Amount,
    ) -> Reference {
        let feather = if basis == Basis::Step { 0.0 } else { effect.scalar("feather") };
        let width = self.width(feather, amount.gradient);
        let colors = self.controls((palette, effect), channel);
        let mut sum = self.control(colors[0]);
        for (pair, edge) in colors.windows(2).zip(palette.edges()) {
            let share = self.ramp(amount.value, *edge, width);
            let share = self.smoothed(basis, share);
            let difference = self.difference(pair[0], pair[1]);
            let part = self.mul(difference, share);
            sum = self.add(sum, part);
        }
        sum
    }

    /// Transition of a basis, for x in [0, 1].
    fn smoothed(&mut self, basis: Basis, x: Reference) -> Reference {
        match basis {
            Basis::Step | Basis::Linear | Basis::Bezier => x,
            Basis::Quadratic => {
                // 2 x^2 up to 1/2, then 1 - 2 (1 - x)^2: 2 x^2 - (2 x - 1)^2 where 2 x > 1.
                let twice = self.add(x, x);
                let minus_one = self.number(-1.0);
                let above = self.add(twice, minus_one);
                let above = self.saturate(above);
                let (low, high) = (self.mul(twice, x), self.mul(above, above));
                self.sub(low, high)
            }
            Basis::Cubic => {
                let twice = self.add(x, x);
                let three = self.number(3.0);
                let (square, factor) = (self.mul(x, x), self.sub(three, twice));
                self.mul(square, factor)
            }
        }
    }

    /// One channel of the Bezier curve through a palette, by de Casteljau's steps.
    fn bezier(&mut self, colors: &[Control], amount: Reference) -> Reference {
        let mut points: Vec<Reference> =
            colors.iter().map(|control| self.control(*control)).collect();
        while points.len() > 1 {
            points = points.windows(2).map(|pair| self.mixed(pair[0], pair[1], amount)).collect();
        }
        points[0]
    }

    /// Paints the colour of an effect where an amount is within its ramp.
    fn overlay_by(&mut self, effect: &Effect, under: [Reference; 3], by: Amount) -> [Reference; 3] {
        let ramp = self.ramp_of(effect, by);
        self.overlay(effect, under, [ramp.value; 3])
    }

    /// Paints the colour of a highlight: w = 1 - prod (1 - C (1 - kappa (1 - V)) [c > 0] ramp(m)).
    fn highlight(&mut self, effect: &Effect, under: [Reference; 3]) -> [Reference; 3] {
        let shares = self.quantities(effect).map(|quantity| {
            let mut rest = self.number(1.0);
            for light in 0..self.lighting.lights {
                let value = self.of_light(light, LightInput::Mirror);
                let gradient = self.of_light(light, LightInput::MirrorStep);
                let ramp = self.ramp_of(effect, Amount { value, gradient });
                let cosine = self.of_light(light, LightInput::Cos);
                let gradient = self.of_light(light, LightInput::CosStep);
                let width = self.width(0.0, gradient);
                let is_lit = self.ramp(cosine, 0.0, width);
                let color = self.of_light(light, quantity);
                let mut share = self.mul(color, is_lit);
                share = self.mul(share, ramp.value);
                if self.lighting.has_shadows {
                    let occluded = self.occluded(effect, light);
                    let visible = self.complement(occluded);
                    share = self.mul(share, visible);
                }
                let left = self.complement(share);
                rest = self.mul(rest, left);
            }
            self.complement(rest)
        });
        self.overlay(effect, under, shares)
    }

    /// Mixes the colour of an effect over others: I + k w (J - I).
    fn overlay(
        &mut self,
        effect: &Effect,
        under: [Reference; 3],
        shares: [Reference; 3],
    ) -> [Reference; 3] {
        let color = effect.color("color");
        let strength = self.strength(effect);
        let mut over = under;
        for (channel, over) in over.iter_mut().enumerate() {
            let share = self.mul(strength, shares[channel]);
            let color = self.number(color[channel]);
            *over = match effect.image("image") {
                Some(image) => self.overlay_image((image, channel), *over, (color, share)),
                None => self.mixed(*over, color, share),
            };
        }
        over
    }

    /// Quantity of the lights' colours that each channel reads.
    fn quantities(&self, effect: &Effect) -> [LightInput; 3] {
        match effect.word("property") {
            "box" => [LightInput::Red, LightInput::Green, LightInput::Blue],
            _ => [LightInput::Level; 3],
        }
    }

    /// All of the light, before any is mixed in.
    fn all(&mut self) -> Rest {
        Rest { value: self.number(1.0), gradient: self.number(0.0) }
    }

    /// Light that is left when an amount is mixed in, and the bound of its gradient by the product
    /// rule.
    fn without(&mut self, rest: Rest, amount: Amount) -> Rest {
        let left = self.complement(amount.value);
        let (old, new) = (self.mul(rest.gradient, left), self.mul(rest.value, amount.gradient));
        Rest { value: self.mul(rest.value, left), gradient: self.add(old, new) }
    }

    /// Ramp of an effect between its parameters `from` and `to`.
    fn ramp_of(&mut self, effect: &Effect, amount: Amount) -> Ramp {
        let (from, to) = (effect.scalar("from"), effect.scalar("to"));
        self.ramp_between(from, to, amount)
    }

    fn of_light(&mut self, light: usize, quantity: LightInput) -> Reference {
        self.builder.input(Input::of_light(light, quantity))
    }

    fn scalar(&mut self, effect: &Effect, name: &str) -> Reference {
        self.number(effect.scalar(name))
    }
}

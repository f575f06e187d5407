//! Ramps of a fixed least width, and the arithmetic that all effects share.

use brood_brdf::Lighting;
use brood_genome::{Function, ImageHash, ScalarMachine};

use crate::build::{Builder, Reference};

/// Least width of a ramp. Below it, 1 / width would be inexact: a reciprocal is x / (x^2 + 2^-24).
const WIDTH_MIN: f64 = 1.0 / 1024.0;

/// Adds the nodes of effects.
pub(super) struct Painter<'a> {
    pub(super) builder: &'a mut Builder,
    pub(super) lighting: Lighting,
    /// Control images of the style, in the order of their inputs.
    pub(super) images: &'a [ImageHash],
}

/// A value and the length of its gradient over a pixel.
#[derive(Clone, Copy)]
pub(super) struct Amount {
    pub(super) value: Reference,
    pub(super) gradient: Reference,
}

/// Position on a ramp, within [0, 1], and the length of its gradient over a pixel: 0 where the ramp
/// ends within the pixel or before.
#[derive(Clone, Copy)]
pub(super) struct Ramp {
    pub(super) value: Reference,
    pub(super) gradient: Reference,
}

/// Reciprocal of the width of a ramp.
#[derive(Clone, Copy)]
pub(super) struct Width {
    inverse: Reference,
}

impl Painter<'_> {
    /// Width of a ramp: that of its parameters, but at least the change over a pixel, which counts
    /// up to 1.
    pub(super) fn width(&mut self, own: f64, gradient: Reference) -> Width {
        let own = self.number(own.max(WIDTH_MIN));
        let more = self.sub(gradient, own);
        let more = self.saturate(more);
        let width = self.add(own, more);
        Width { inverse: self.builder.function(Function::Rcp, width) }
    }

    /// (value - middle) / width + 1/2, not clamped.
    fn position(&mut self, value: Reference, middle: f64, width: Width) -> Reference {
        let (middle, half) = (self.number(middle), self.number(0.5));
        let from_middle = self.sub(value, middle);
        let scaled = self.mul(from_middle, width.inverse);
        self.add(scaled, half)
    }

    /// Ramp of a width around a middle.
    pub(super) fn ramp(&mut self, value: Reference, middle: f64, width: Width) -> Reference {
        let position = self.position(value, middle, width);
        self.saturate(position)
    }

    /// Ramp from 0 at `from` to 1 at `to`, with its gradient.
    pub(super) fn ramp_between(&mut self, from: f64, to: f64, amount: Amount) -> Ramp {
        let width = self.width(to - from, amount.gradient);
        let position = self.position(amount.value, 0.5 * (from + to), width);
        let scaled = self.mul(amount.gradient, width.inverse);
        // The gradient counts if the ramp reaches into the pixel: half a pixel beyond its ends.
        let (one, half) = (self.number(1.0), self.number(0.5));
        let reach = self.mul(half, scaled);
        let begins = self.add(position, reach);
        let begins = self.builder.function(Function::Step, begins);
        let end = self.add(one, reach);
        let ends = self.sub(end, position);
        let ends = self.builder.function(Function::Step, ends);
        let inside = self.mul(begins, ends);
        Ramp { value: self.saturate(position), gradient: self.mul(inside, scaled) }
    }

    /// a + t (b - a).
    pub(super) fn mixed(&mut self, a: Reference, b: Reference, t: Reference) -> Reference {
        let difference = self.sub(b, a);
        let part = self.mul(t, difference);
        self.add(a, part)
    }

    /// 1 - x.
    pub(super) fn complement(&mut self, x: Reference) -> Reference {
        let one = self.number(1.0);
        self.sub(one, x)
    }

    /// x clamped to [0, 1].
    pub(super) fn saturate(&mut self, x: Reference) -> Reference {
        self.builder.function(Function::Saturate, x)
    }

    pub(super) fn add(&mut self, a: Reference, b: Reference) -> Reference {
        self.builder.add(a, b)
    }

    pub(super) fn sub(&mut self, a: Reference, b: Reference) -> Reference {
        let b = self.builder.neg(b);
        self.builder.add(a, b)
    }

    pub(super) fn mul(&mut self, a: Reference, b: Reference) -> Reference {
        self.builder.mul(a, b)
    }

    /// Constant, rounded to the nearest f32.
    #[expect(clippy::cast_possible_truncation, reason = "rounded to the nearest f32")]
    pub(super) fn number(&mut self, value: f64) -> Reference {
        self.builder.constant(value as f32)
    }
}

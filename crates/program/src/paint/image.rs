//! Lowering of control images, which are inputs, into colours and weights of effects.

use brood_brdf::Input;
use brood_genome::{Effect, EffectImage, ImageHash, Palette, ScalarMachine};

use super::Painter;
use crate::build::Reference;
use crate::{Meaning, Program};

/// Weights of red, green and blue in the brightness of an image.
const BRIGHTNESS: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Place of the opacity among the inputs of an image.
const OPACITY: usize = 3;

/// One channel of a control colour.
#[derive(Clone, Copy)]
pub(super) enum Control {
    Number(f64),
    Image(Reference),
}

impl Program {
    /// Control images of a style, in the order of their inputs ([`Input::IMAGES`]); none for other
    /// programs.
    #[must_use]
    pub fn images(&self) -> Vec<ImageHash> {
        match &self.meaning {
            Meaning::Style(effects) => Effect::images_of(effects),
            Meaning::Reflectance | Meaning::Color | Meaning::Slopes => Vec::new(),
        }
    }
}

impl Painter<'_> {
    /// Control colours of a palette with its images, one channel.
    pub(super) fn controls(
        &mut self,
        (palette, effect): (&Palette, &Effect),
        channel: usize,
    ) -> Vec<Control> {
        let codes = palette.colors().iter().map(|color| f64::from(color[channel]) / 255.0);
        let mut controls: Vec<Control> = codes.map(Control::Number).collect();
        for (place, at) in [("dark", 0), ("bright", controls.len() - 1)] {
            if let Some(image) = effect.image(place) {
                let color = self.control(controls[at]);
                controls[at] = Control::Image(self.mixed_in(image, channel, color));
            }
        }
        controls
    }

    pub(super) fn control(&mut self, control: Control) -> Reference {
        match control {
            Control::Number(number) => self.number(number),
            Control::Image(value) => value,
        }
    }

    /// Returns b - a. The difference of two numbers is rounded once, as without images.
    pub(super) fn difference(&mut self, a: Control, b: Control) -> Reference {
        if let (Control::Number(a), Control::Number(b)) = (a, b) {
            return self.number(b - a);
        }
        let (a, b) = (self.control(a), self.control(b));
        self.sub(b, a)
    }

    /// Mixes an overlay with an image over one channel: I + w ((1 - s) (C - I) + s (J - a I)), with
    /// the overlay's colour C, the image's share s, opacity a and colour J times a.
    pub(super) fn overlay_image(
        &mut self,
        (image, channel): (&EffectImage, usize),
        under: Reference,
        (color, share): (Reference, Reference),
    ) -> Reference {
        let plain = self.sub(color, under);
        let seen = self.over(image, channel, under);
        let image_share = self.number(image.share);
        let change = self.mixed(plain, seen, image_share);
        let part = self.mul(share, change);
        self.add(under, part)
    }

    /// Strength of an overlay, scaled by its map: k (1 + share (brightness - opacity)).
    pub(super) fn strength(&mut self, effect: &Effect) -> Reference {
        let strength = self.number(effect.scalar("strength"));
        let Some(map) = effect.image("map") else { return strength };
        let (one, share) = (self.number(1.0), self.number(map.share));
        let (brightness, opacity) = (self.brightness(map), self.channel(map, OPACITY));
        let darker = self.sub(brightness, opacity);
        let change = self.mul(share, darker);
        let scale = self.add(one, change);
        let scale = self.saturate(scale);
        self.mul(strength, scale)
    }

    /// Shift of the amount of light by a map, 2 p - 1, with p its brightness: 0 where the map is
    /// transparent.
    pub(super) fn shift_by_map(&mut self, effect: &Effect) -> Option<Reference> {
        let map = effect.image("map")?;
        let brightness = self.brightness(map);
        let opacity = self.channel(map, OPACITY);
        let twice = self.add(brightness, brightness);
        let (shift, share) = (self.sub(twice, opacity), self.number(map.share));
        Some(self.mul(share, shift))
    }

    /// Mixes one channel of an image over a colour by the image's share: I + share (J - a I), with
    /// J times its opacity a.
    fn mixed_in(&mut self, image: &EffectImage, channel: usize, color: Reference) -> Reference {
        let (difference, share) = (self.over(image, channel, color), self.number(image.share));
        let part = self.mul(share, difference);
        self.add(color, part)
    }

    /// Change of one channel of a colour by an image over it: J - a I.
    fn over(&mut self, image: &EffectImage, channel: usize, color: Reference) -> Reference {
        let (value, opacity) = (self.channel(image, channel), self.channel(image, OPACITY));
        let covered = self.mul(opacity, color);
        self.sub(value, covered)
    }

    fn brightness(&mut self, image: &EffectImage) -> Reference {
        let parts = [0, 1, 2].map(|channel| {
            let value = self.channel(image, channel);
            let weight = self.number(BRIGHTNESS[channel]);
            self.mul(weight, value)
        });
        let sum = self.add(parts[0], parts[1]);
        let sum = self.add(sum, parts[2]);
        self.saturate(sum)
    }

    fn channel(&mut self, image: &EffectImage, channel: usize) -> Reference {
        let slot = self.images.iter().position(|own| *own == image.image);
        let slot = slot.expect("the images are those of the effects");
        self.builder.input(Input::IMAGES[slot][channel])
    }
}

//! Amount of light of a style that paints what its BRDF reflects.

use brood_brdf::Input;
use brood_genome::{Effect, ScalarMachine};

use super::ramp::{Amount, Painter};

impl Painter<'_> {
    /// Amounts of the three channels: ramps of the reflected levels, which are L / (1 + L) and
    /// inputs of the point.
    pub(super) fn reflected(&mut self, effect: &Effect) -> [Amount; 3] {
        let [level, red, green, blue] = Input::REFLECTED;
        let levels = match effect.word("property") {
            "box" => [red, green, blue],
            _ => [level; 3],
        };
        let gradient = self.builder.input(Input::ReflectedStep);
        let strength = self.scalar(effect, "strength");
        levels.map(|level| {
            let value = self.builder.input(level);
            let ramp = self.ramp_of(effect, Amount { value, gradient });
            let value = self.mul(strength, ramp.value);
            Amount { value, gradient: self.mul(strength, ramp.gradient) }
        })
    }
}

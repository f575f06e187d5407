//! Locks of effects.

use serde::{Deserialize, Serialize};

use crate::effect::MAP;
use crate::{Effect, EffectKind, Palette};

/// A parameter of an effect.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectLock {
    /// Kind of the effect.
    pub effect: EffectKind,
    /// Name of the parameter or of the place of an image, or `palette` or `edges` of a light
    /// effect.
    pub name: String,
}

/// Locks of effects, resolved for the first parent.
#[derive(Default)]
pub(crate) struct LockedEffects {
    whole: Vec<EffectKind>,
    parts: Vec<EffectLock>,
}

impl LockedEffects {
    pub(super) fn of(whole: &[EffectKind], parts: &[EffectLock]) -> Self {
        Self { whole: whole.to_vec(), parts: parts.to_vec() }
    }

    /// True if a parameter, or the colours or edges of the palette, is locked.
    pub(crate) fn locks(&self, kind: EffectKind, name: &str) -> bool {
        let is_part = |part: &EffectLock| part.effect == kind && part.name == name;
        self.whole.contains(&kind) || self.parts.iter().any(is_part)
    }

    /// True if anything of an effect is locked, and with it that the child has the effect.
    pub(crate) fn locks_any_of(&self, kind: EffectKind) -> bool {
        self.whole.contains(&kind) || self.parts.iter().any(|part| part.effect == kind)
    }

    /// True if a parameter in the table of an effect, or the image of its number, is locked.
    pub(crate) fn locks_values_of(&self, kind: EffectKind) -> bool {
        let is_locked = |name| self.locks(kind, name);
        kind.parameters().iter().any(|parameter| is_locked(parameter.name)) || is_locked(MAP)
    }
}

/// True if an effect has a parameter, a palette, edges or an image of this name.
pub(super) fn has(effect: &Effect, name: &str) -> bool {
    let is_palette =
        effect.palette().is_some() && [Palette::COLORS, Palette::EDGES].contains(&name);
    let is_image = effect.image(name).is_some();
    is_palette || is_image || effect.values().get(name).is_some()
}

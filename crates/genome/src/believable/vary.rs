//! Mutation and crossover of believable programs, by parameters. All children are believable.

use super::anchor::{Anchor, Class, VALUES};
use super::parameters::Parameters;
use super::structure::{
    BODY, NARROW, Structure, TERMS, WEIGHTS, WIDE, fall_off_of, inputs_of, is_highlight, unit_of,
};
use super::{colour, draw};
use crate::random::{Operator, Stream};
use crate::steer::{Kept, Toward};
use crate::{BirthKey, CONSTANTS, Instruction};

/// Probability of a new shape in the old colour, and of a new colour, at amount 1; grows with the
/// square of the amount, so that small amounts keep both.
const RESHAPE: f32 = 1.0;
const RECOLOUR: f32 = 1.0;
/// Change of the shape at amount 1, in differences of two anchors.
const STEP: f64 = 0.7;
/// Standard deviation of the change of log2 of the albedo of each channel at amount 1.
const COLOUR_STEP: f64 = 1.5;
/// Probability of a new pattern at amount 1.
const REPATTERN: f32 = 1.0;
/// Probability of a new structure at amount 1. Modules that differ are added or removed.
const RESTRUCTURE: f32 = 1.5;
/// Change of the second colours of a pattern, as a share of that of the first.
const SECOND: f64 = 0.7;
/// Standard deviation of the change of a stretch at amount 1.
const STRETCH_STEP: f64 = 1.3;
/// Largest stretch: widths of 20 to 1.
const STRETCH_MOST: f64 = 3.0;
/// Step of ln of the width of highlights in the direction of a steer, of log2 of the albedo of each
/// channel, and of log2 of the contrast of a pattern.
const GLOSS_STEP: f64 = 2.0;
const WARM_STEP: [f64; 3] = [1.6, 0.3, -2.2];
const CONTRAST_STEP: f64 = 2.5;
/// Probability at amount 1 that `less-pattern` removes the pattern.
const REMOVE: f32 = 0.8;
/// Channels of bodies stay between these albedos.
const ALBEDOS: (f64, f64) = (0.03, 0.9);
/// Largest channel of a metal's colour where it becomes that of a body.
const METAL: f64 = 0.7;

/// Rules of a variation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules {
    /// Channels that stay the same function, red in the lowest bit; then the others change in
    /// colour only.
    pub(crate) channels: u8,
    /// Parts that a steer keeps: the hue of each term, or everything but the shape of the
    /// highlights.
    pub(crate) steered: Kept,
    /// Modules that children may have; `None` if the structure stays.
    pub(crate) most: Option<Structure>,
}

/// Mutates a believable program. Returns false if the program is not believable.
pub(crate) fn mutate(
    (instructions, constants): (&mut Vec<Instruction>, &mut [[f32; 4]; CONSTANTS]),
    mutation: f32,
    rules: Rules,
    key: BirthKey,
) -> bool {
    let Some(old) = Parameters::of(instructions, constants) else { return false };
    if mutation > 0.0 {
        mutant(&old, mutation, rules, key).write(&old, (instructions, constants));
    }
    true
}

/// Parameters of a mutant.
fn mutant(old: &Parameters, mutation: f32, rules: Rules, key: BirthKey) -> Parameters {
    let Rules { channels: kept, steered, most } = rules;
    let mut stream = Stream::new(key, Operator::MutateBelievable);
    // Plain programs do not read this stream except for a new structure.
    let mut modules = Stream::new(key, Operator::MutateStructure);
    let mut toward = Steps { stream: Stream::new(key, Operator::Toward), mutation, key };
    let nearest = nearest(old);
    let (mut new, mut class) = (*old, nearest.class);
    let step = STEP * f64::from(mutation);
    if kept == 0 && steered.all_but_gloss {
        change_highlights(&mut new, &draw::difference(class, &mut stream), step);
        change_stretch(&mut new, mutation, &mut modules);
        toward.step(&mut new, steered);
        return new;
    }
    if kept == 0 {
        if !steered.colour && stream.chance(RESHAPE * mutation * mutation) {
            class = draw::class(&mut stream);
            let shape = draw::shape(class, &mut stream);
            new = draw::coloured(class, &shape, colour_of(old, nearest.class));
            match most {
                Some(most) => {
                    let structure = draw::structure(class, most, &mut modules);
                    draw::dress(&mut new, class, structure, &mut modules);
                }
                None => (new.stretch, new.pattern) = (old.stretch, old.pattern),
            }
        }
        let change = draw::difference(class, &mut stream);
        for (weight, change) in new.weights.iter_mut().zip(change) {
            *weight += step * change;
        }
        let levels = &change[WEIGHTS..][..TERMS];
        for (term, change) in new.colours.iter_mut().zip(levels) {
            *term = term.map(|colour| colour + step * change);
        }
        change_stretch(&mut new, mutation, &mut modules);
        change_pattern(&mut new, (class, steered), mutation, &mut modules);
        let restructures = modules.chance(RESTRUCTURE * mutation * mutation);
        if let Some(most) = most.filter(|_| restructures && !steered.colour) {
            restructure(&mut new, class, most, &mut modules);
        }
        toward.step(&mut new, steered);
        if let Some(most) = most {
            toward.change_structure(&mut new, (class, most), steered);
        }
    }
    if steered.is_any() {
        // The shape has changed all channels of a term alike, so each term has its old hue.
        return new;
    }
    let change = |stream: &mut Stream| {
        std::array::from_fn(|_| COLOUR_STEP * f64::from(mutation * stream.bell()))
    };
    let warmth = steered.toward.warmth;
    if stream.chance(RECOLOUR * mutation * mutation) && warmth == 0 {
        let albedo = colour::draw(class, &mut stream);
        draw::colour(&mut new, class, albedo);
    } else {
        let warmer = toward.warmth(warmth);
        let change: [f64; 3] = change(&mut stream);
        let change = [0, 1, 2].map(|channel| change[channel] + warmer[channel]);
        tint(&mut new, (old, nearest.class), class, change);
    }
    if let Some(pattern) = &mut new.pattern {
        pattern.tint(colour::tints(class), change(&mut modules).map(|one: f64| SECOND * one));
    }
    keep(&mut new, old, kept);
    new
}

/// Crosses two believable programs: the roles, the colour, the stretch and the pattern of the
/// second replace those of the first, each with probability `share`. Returns false if one of the
/// programs is not believable.
pub(crate) fn recombine(
    (instructions, constants): (&mut Vec<Instruction>, &mut [[f32; 4]; CONSTANTS]),
    second: (&[Instruction], &[[f32; 4]; CONSTANTS]),
    (share, rules): (f32, Rules),
    key: BirthKey,
) -> bool {
    let Some(first) = Parameters::of(instructions, constants) else { return false };
    let Some(second) = Parameters::of(second.0, second.1) else { return false };
    child([&first, &second], share, rules, key).write(&first, (instructions, constants));
    true
}

/// Parameters of a child of two.
fn child([first, second]: [&Parameters; 2], share: f32, rules: Rules, key: BirthKey) -> Parameters {
    let Rules { channels: kept, steered, .. } = rules;
    let rules = Rules { most: rules.most.filter(|_| !steered.all_but_gloss), ..rules };
    let mut stream = Stream::new(key, Operator::RecombineBelievable);
    // The terms, then the colour.
    let mut taken: [bool; TERMS + 1] = std::array::from_fn(|_| stream.chance(share));
    if share > 0.0 && share < 1.0 && taken.iter().all(|one| *one == taken[0]) {
        let one = &mut taken[stream.below(TERMS as u32 + 1) as usize];
        *one = !*one;
    }
    if kept != 0 {
        taken[..TERMS].fill(false);
    }
    if steered.all_but_gloss {
        let is_highlight = |term: usize| term < TERMS && is_highlight(term);
        (0..=TERMS).filter(|term| !is_highlight(*term)).for_each(|term| taken[term] = false);
    }
    taken[TERMS] &= !steered.colour;
    let mut child = *first;
    if kept == 0 {
        take_modules(&mut child, second, (share, rules), key);
    }
    for term in (BODY..TERMS).filter(|term| taken[*term]) {
        for at in weights_of(term) {
            child.weights[at] = second.weights[at];
        }
        child.colours[term] = second.colours[term];
        if steered.is_any() {
            let mean = |of: &Parameters| of.colours[term].iter().sum::<f64>() / 3.0;
            let level = mean(second) - mean(first);
            child.colours[term] = first.colours[term].map(|colour| colour + level);
        }
    }
    if steered.is_any() {
        return child;
    }
    let nearest = nearest(&child);
    let albedo = if taken[TERMS] { second } else { first };
    let albedo = colour_of(albedo, self::nearest(albedo).class);
    if taken.iter().any(|one| *one != taken[0]) {
        draw::colour(&mut child, nearest.class, albedo);
    }
    keep(&mut child, first, kept);
    child
}

/// Takes the stretch and the pattern of the second parent, or their absence, each with probability
/// `share`, as far as the rules allow.
fn take_modules(
    child: &mut Parameters,
    second: &Parameters,
    (share, rules): (f32, Rules),
    key: BirthKey,
) {
    let mut stream = Stream::new(key, Operator::RecombineStructure);
    let (stretch, pattern) = (stream.chance(share), stream.chance(share));
    let most = rules.most.unwrap_or(child.structure());
    // Without `most`, a module is exchanged for one of its kind only.
    let may = |own: bool, other: bool, most: bool| {
        own == other || rules.most.is_some() && (most || !other)
    };
    let [own, other] = [child.structure(), second.structure()];
    if stretch && may(own.is_brushed, other.is_brushed, most.is_brushed) {
        child.stretch = second.stretch;
    }
    // The mean colour depends on the second colours.
    let keeps_pattern = rules.steered.colour && own.is_patterned && !other.is_patterned;
    let may_change = !keeps_pattern && may(own.is_patterned, other.is_patterned, most.is_patterned);
    if pattern && may_change && !rules.steered.all_but_gloss {
        let contrast = child.pattern.map(|pattern| pattern.contrast);
        child.pattern = second.pattern;
        if rules.steered.colour
            && let Some(pattern) = &mut child.pattern
        {
            match contrast {
                Some(contrast) => pattern.contrast = contrast,
                None => pattern.keep_hue(),
            }
        }
    }
}

/// Draws the structure anew. Modules that stay keep their values.
fn restructure(new: &mut Parameters, class: Class, most: Structure, stream: &mut Stream) {
    let drawn = draw::structure(class, most, stream);
    let own = new.structure();
    let added = Structure {
        is_brushed: drawn.is_brushed && !own.is_brushed,
        is_patterned: drawn.is_patterned && !own.is_patterned,
    };
    new.stretch = new.stretch.filter(|_| drawn.is_brushed);
    new.pattern = new.pattern.filter(|_| drawn.is_patterned);
    draw::dress(new, class, added, stream);
}

/// Steps in the directions of a steer.
struct Steps {
    stream: Stream,
    mutation: f32,
    key: BirthKey,
}

impl Steps {
    fn size(&mut self) -> f64 {
        Toward::step(self.mutation, self.key.attempt, &mut self.stream)
    }

    /// Change of log2 of the albedo of each channel.
    fn warmth(&mut self, direction: i8) -> [f64; 3] {
        if direction == 0 {
            return [0.0; 3];
        }
        let size = f64::from(direction) * self.size();
        WARM_STEP.map(|step| size * step)
    }

    /// Changes width and level of the highlights, and the contrast of the pattern. Hues stay where
    /// they are kept.
    fn step(&mut self, new: &mut Parameters, steered: Kept) {
        let Toward { gloss, pattern, .. } = steered.toward;
        if gloss != 0 {
            let narrowing = GLOSS_STEP * f64::from(gloss) * self.size();
            for term in [NARROW, WIDE] {
                let unit = unit_of(term);
                new.weights[unit.start + 1] += new.weights[unit.start] * narrowing;
                // A narrower highlight with as much light is brighter.
                let level = narrowing / std::f64::consts::LN_2;
                new.colours[term] = new.colours[term].map(|colour| colour + level);
            }
        }
        if pattern != 0
            && let Some(own) = &mut new.pattern
        {
            own.scale(CONTRAST_STEP * f64::from(pattern) * self.size(), steered.colour);
        }
    }

    /// Adds a pattern, or removes it.
    fn change_structure(
        &mut self,
        new: &mut Parameters,
        (class, most): (Class, Structure),
        steered: Kept,
    ) {
        let direction = steered.toward.pattern;
        if direction > 0 && new.pattern.is_none() && most.is_patterned {
            let mut pattern = draw::pattern(new, class, &mut self.stream);
            if steered.colour {
                pattern.keep_hue();
            }
            new.pattern = Some(pattern);
        }
        if direction < 0 && new.pattern.is_some() && self.stream.chance(REMOVE * self.mutation) {
            new.pattern = None;
        }
    }
}

/// Changes the stretch, if there is one.
fn change_stretch(new: &mut Parameters, mutation: f32, stream: &mut Stream) {
    if let Some(stretch) = &mut new.stretch {
        let changed = *stretch + STRETCH_STEP * f64::from(mutation * stream.bell());
        *stretch = changed.clamp(-STRETCH_MOST, STRETCH_MOST);
    }
}

/// Changes the pattern, if there is one, or draws it anew. If the steer keeps the colour, its
/// colours keep their hues.
fn change_pattern(
    new: &mut Parameters,
    (class, steered): (Class, Kept),
    mutation: f32,
    stream: &mut Stream,
) {
    let Some(mut pattern) = new.pattern else { return };
    if stream.chance(REPATTERN * mutation * mutation) {
        let drawn = draw::pattern(new, class, stream);
        pattern.values = drawn.values;
        if !steered.colour {
            pattern.contrast = drawn.contrast;
        }
    } else {
        pattern.step(f64::from(mutation), stream);
    }
    new.pattern = Some(pattern);
}

/// Gives the old colour to the body again after a change of the shape, each channel multiplied by
/// 2^`change`. Without a change of shape and colour, everything stays as it is.
fn tint(new: &mut Parameters, old: (&Parameters, Class), class: Class, change: [f64; 3]) {
    let (old, old_class) = old;
    let half_log = |albedo: f64| 0.5 * libm::log2(albedo.max(1e-6));
    let factor = scale_of(old, old_class);
    let (own, body) = (old.body_albedo(), new.body_albedo());
    let shift: [f64; 3] = std::array::from_fn(|at| {
        let own = factor * own[at];
        // Channels that are out of range already stay there.
        let (least, most) = (ALBEDOS.0.min(own), ALBEDOS.1.max(own));
        half_log((own * libm::exp2(change[at])).clamp(least, most)) - half_log(factor * body[at])
    });
    draw::shift_colour(new, class, shift);
}

/// Changes the highlights by a multiple of a difference of two anchors; their hues stay.
fn change_highlights(new: &mut Parameters, change: &[f64; VALUES], step: f64) {
    for term in [NARROW, WIDE] {
        for at in weights_of(term) {
            new.weights[at] += step * change[at];
        }
        new.colours[term] = new.colours[term].map(|colour| colour + step * change[WEIGHTS + term]);
    }
}

/// Brings the colours of kept channels back.
fn keep(new: &mut Parameters, old: &Parameters, kept: u8) {
    let keep = |new: &mut [[f64; 3]; TERMS], old: &[[f64; 3]; TERMS]| {
        for (new, old) in new.iter_mut().zip(old) {
            for channel in (0..3).filter(|channel| kept >> channel & 1 == 1) {
                new[channel] = old[channel];
            }
        }
    };
    keep(&mut new.colours, &old.colours);
    if let (Some(new), Some(old)) = (&mut new.pattern, &old.pattern) {
        keep(&mut new.contrast, &old.contrast);
    }
}

/// Colour of a program. The body of a metal is dark, so it is scaled to the reflectance of one.
fn colour_of(parameters: &Parameters, class: Class) -> [f64; 3] {
    let factor = scale_of(parameters, class);
    parameters.body_albedo().map(|albedo| (factor * albedo).clamp(ALBEDOS.0, ALBEDOS.1))
}

/// Factor from the albedo of a body to its colour.
fn scale_of(parameters: &Parameters, class: Class) -> f64 {
    let largest = parameters.body_albedo().iter().fold(1e-6, |a: f64, b| a.max(*b));
    if class == Class::Metal { METAL / largest } else { 1.0 }
}

/// Indices of the weights of a term and its unit.
fn weights_of(term: usize) -> Vec<usize> {
    let mut all: Vec<usize> = inputs_of(term).collect();
    if is_highlight(term) {
        all.extend(unit_of(term));
        all.push(fall_off_of(term));
    }
    all
}

/// Anchor with the most similar weights.
fn nearest(parameters: &Parameters) -> &'static Anchor {
    let distance = |anchor: &Anchor| -> f64 {
        let both = parameters.weights.iter().zip(anchor.values);
        both.map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let anchors = Anchor::all().iter();
    anchors.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("there are anchors")
}

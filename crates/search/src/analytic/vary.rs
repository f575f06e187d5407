//! Where later generations start from: what was told, and what is kept in another place or another form.

use brood_brdf::ModelKind;
use brood_genome::{Genome, Stream};

use super::climb::Climb;
use super::recover::drawn;
use super::residual::Space;
use super::schedule::Kept;
use super::{Form, LobeForm};

/// What a genome of one or two models is; none where it is something else.
pub(super) fn told(genome: &Genome) -> Option<(Space, Climb)> {
    let layers = genome.layers();
    let (first, rest) = layers.split_first()?;
    if !genome.instructions().is_empty() || rest.len() > 1 {
        return None;
    }
    let form = Form::of(first);
    let form =
        rest.first().map_or(form.clone(), |second| form.with(Form::of(second).lobes()[0].clone()));
    let x = form.place(layers);
    Some((Space::new(form), Climb::new(x)))
}

/// Some numbers of a fit pushed.
pub(super) fn pushed(parent: &Kept, stream: &mut Stream) -> (Space, Climb) {
    let space = parent.space.clone();
    let mut x = parent.climb.x.clone();
    for _ in 0..=stream.below(3) {
        let at = stream.below(x.len() as u32) as usize;
        x[at] += 0.6 * space.coordinates[at].longest * f64::from(stream.bell());
    }
    space.clamp(&mut x);
    (space, Climb::new(x))
}

/// The numbers of a fit in another form of the same kinds.
pub(super) fn changed(parent: &Kept, form: Form) -> (Space, Climb) {
    let x = form.place(&parent.space.models(&parent.climb.x));
    (Space::new(form), Climb::new(x))
}

/// A fit with a second model; none where it has one.
pub(super) fn second(
    parent: &Kept,
    kinds: &[ModelKind],
    stream: &mut Stream,
) -> Option<(Space, Climb)> {
    if parent.space.form.lobes().len() > 1 {
        return None;
    }
    let kind = kinds[stream.below(kinds.len() as u32) as usize];
    let form = parent.space.form.with(LobeForm::new(kind));
    let space = Space::new(form);
    let mut x = drawn(&space, stream);
    x[..parent.climb.x.len()].copy_from_slice(&parent.climb.x);
    Some((space, Climb::new(x)))
}

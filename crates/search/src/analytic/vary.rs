//! Starting points of fits: given genomes in the first generation; perturbed fits and fits in
//! another form later.

use std::sync::Arc;

use brood_brdf::ModelKind;
use brood_genome::{Genome, Stream};

use super::kept::Kept;
use super::prior::PriorMaterials;
use super::recover::random_point;
use super::residual::Space;
use super::{Form, LobeForm};
use crate::levenberg_marquardt::Solution;

/// Starting point with the models of a genome; `None` unless it consists of one or two models.
pub(super) fn from_genome(
    genome: &Genome,
    materials: &Arc<PriorMaterials>,
) -> Option<(Space, Solution<Vec<f64>>)> {
    let layers = genome.layers();
    let (first, rest) = layers.split_first()?;
    if !genome.instructions().is_empty() || rest.len() > 1 {
        return None;
    }
    let form = Form::of(first);
    let form =
        rest.first().map_or(form.clone(), |second| form.with(Form::of(second).lobes()[0].clone()));
    let x = form.place(layers);
    Some((Space::new(form, materials), Solution::new(x)))
}

/// A fit with one to three of its coordinates perturbed.
pub(super) fn perturbed(parent: &Kept, stream: &mut Stream) -> (Space, Solution<Vec<f64>>) {
    let space = parent.space.clone();
    let mut x = parent.fit.point.clone();
    for _ in 0..=stream.below(3) {
        let at = stream.below(x.len() as u32) as usize;
        x[at] += 0.6 * space.coordinates[at].longest * f64::from(stream.bell());
    }
    space.clamp(&mut x);
    (space, Solution::new(x))
}

/// A fit's parameter values in another form of the same kinds.
pub(super) fn in_form(parent: &Kept, form: Form) -> (Space, Solution<Vec<f64>>) {
    let x = form.place(&parent.space.models(&parent.fit.point));
    (parent.space.of_form(form), Solution::new(x))
}

/// One of a fit's two models with its parameter values; `None` if the fit has one model.
pub(super) fn with_one_model(
    parent: &Kept,
    stream: &mut Stream,
) -> Option<(Space, Solution<Vec<f64>>)> {
    let models = parent.space.models(&parent.fit.point);
    if models.len() < 2 {
        return None;
    }
    let model = &models[stream.below(models.len() as u32) as usize];
    let form = Form::of(model);
    let x = form.place(std::slice::from_ref(model));
    Some((parent.space.of_form(form), Solution::new(x)))
}

/// A fit with a second model at a random point; `None` if it already has two models, or there is
/// no kind to choose from.
pub(super) fn with_second_model(
    parent: &Kept,
    kinds: &[ModelKind],
    stream: &mut Stream,
) -> Option<(Space, Solution<Vec<f64>>)> {
    if parent.space.form.lobes().len() > 1 || kinds.is_empty() {
        return None;
    }
    let kind = kinds[stream.below(kinds.len() as u32) as usize];
    let form = parent.space.form.with(LobeForm::new(kind));
    let space = parent.space.of_form(form);
    let mut x = random_point(&space, stream);
    x[..parent.fit.point.len()].copy_from_slice(&parent.fit.point);
    Some((space, Solution::new(x)))
}

//! What is fitted: one model or the sum of two, with the words that are chosen and the numbers that are free.

use brood_brdf::{Model, ModelKind, Shape};
use brood_genome::{Genome, GenomeError, Stream};
use serde::{Deserialize, Serialize};

use super::coordinate::Coordinate;

/// One model of a form.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct LobeForm {
    /// [`ModelKind::number`].
    kind: u8,
    /// The word of each parameter that is a choice, in their order.
    words: Vec<u8>,
}

/// Models whose sum is fitted.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Form {
    lobes: Vec<LobeForm>,
    /// Whether highlights may be drawn out along u or v.
    turned: bool,
}

/// Numbers that stay 0 unless a highlight may be drawn out.
const TURNED: [&str; 2] = ["stretch", "anisotropic"];
/// Numbers that are another one's unless it may.
const TIED: [(&str, &str); 2] = [("alpha_y", "alpha_x"), ("exponent_v", "exponent_u")];
/// What a second model leaves to the first.
const BASE: &str = "diffuse";

impl LobeForm {
    /// A model with the first of all words.
    #[must_use]
    pub fn new(kind: ModelKind) -> Self {
        let choices = kind.parameters().iter().filter(|parameter| parameter.words().is_some());
        Self { kind: kind.number(), words: choices.map(|_| 0).collect() }
    }

    /// Which model; none where there is no such number.
    #[must_use]
    pub fn kind(&self) -> Option<ModelKind> {
        ModelKind::from_number(self.kind)
    }

    fn known(&self) -> ModelKind {
        self.kind().expect("a form is of models that there are")
    }

    fn is_sound(&self) -> bool {
        let Some(kind) = self.kind() else { return false };
        let counts: Vec<usize> =
            kind.parameters().iter().filter_map(|p| p.words()).map(<[_]>::len).collect();
        let fits = counts.iter().zip(&self.words).all(|(count, word)| usize::from(*word) < *count);
        counts.len() == self.words.len() && fits
    }
}

impl Form {
    /// One model, the same all around the normal.
    #[must_use]
    pub fn one(kind: ModelKind) -> Self {
        Self { lobes: vec![LobeForm::new(kind)], turned: false }
    }

    /// The form of a model, all its words included.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let words = model.parameters().filter(|(parameter, _)| parameter.words().is_some());
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small index"
        )]
        let words = words.map(|(_, numbers)| numbers[0] as u8).collect();
        let turned = *model != model.isotropic();
        Self { lobes: vec![LobeForm { kind: model.kind().number(), words }], turned }
    }

    /// The models.
    #[must_use]
    pub fn lobes(&self) -> &[LobeForm] {
        &self.lobes
    }

    /// Whether it is one that could have been made here: what is read from elsewhere may not be.
    pub(super) fn is_sound(&self) -> bool {
        (1..=2).contains(&self.lobes.len()) && self.lobes.iter().all(LobeForm::is_sound)
    }

    /// The same with a second model.
    pub(super) fn with(&self, lobe: LobeForm) -> Self {
        Self { lobes: vec![self.lobes[0].clone(), lobe], turned: self.turned }
    }

    /// The same with highlights that may be drawn out; none where that says nothing.
    pub(super) fn turned(&self) -> Option<Self> {
        let can = |lobe: &LobeForm| {
            let names = lobe.known().parameters().iter().map(|parameter| parameter.name);
            names.into_iter().any(|name| TURNED.contains(&name) || TIED.iter().any(|t| t.0 == name))
        };
        let says = !self.turned && self.lobes.iter().any(can);
        says.then(|| Self { lobes: self.lobes.clone(), turned: true })
    }

    /// The same with another word; none where there is no other.
    pub(super) fn reworded(&self, stream: &mut Stream) -> Option<Self> {
        let places: Vec<(usize, usize)> = (0..self.lobes.len())
            .flat_map(|lobe| (0..self.lobes[lobe].words.len()).map(move |word| (lobe, word)))
            .collect();
        let count = u32::try_from(places.len()).ok().filter(|count| *count > 0)?;
        let (lobe, word) = places[stream.below(count) as usize];
        let kind = self.lobes[lobe].known();
        let words = kind.parameters().iter().filter_map(|p| p.words()).nth(word)?.len();
        let step = 1 + stream.below(u32::try_from(words).ok()?.max(2) - 1);
        let mut form = self.clone();
        let own = &mut form.lobes[lobe].words[word];
        *own = u8::try_from((u32::from(*own) + step) % u32::try_from(words).ok()?).ok()?;
        Some(form)
    }

    /// Whether highlights may be drawn out.
    pub(super) fn is_turned(&self) -> bool {
        self.turned
    }

    /// Whether a kind is in it.
    pub(super) fn has(&self, kind: ModelKind) -> bool {
        self.lobes.iter().any(|lobe| lobe.kind == kind.number())
    }

    /// The numbers that are free, lobe by lobe.
    pub(super) fn coordinates(&self) -> Vec<Coordinate> {
        let mut all = Vec::new();
        for (index, lobe) in self.lobes.iter().enumerate() {
            let kind = lobe.known();
            let place = |name: &str| {
                let before = kind.parameters().iter().take_while(|p| p.name != name);
                before.map(|p| p.count()).sum::<usize>()
            };
            let mut at = 0;
            for parameter in kind.parameters() {
                let is_tied = TIED.iter().any(|(name, _)| *name == parameter.name);
                let is_fixed = matches!(parameter.shape, Shape::Choice { .. })
                    || (!self.turned && (TURNED.contains(&parameter.name) || is_tied))
                    || (index > 0 && parameter.name == BASE);
                if !is_fixed {
                    let first = all.len();
                    all.extend(
                        (0..parameter.count()).map(|k| Coordinate::new(parameter, index, at + k)),
                    );
                    let tied = TIED.iter().find(|(_, to)| *to == parameter.name);
                    if let Some((name, _)) = tied.filter(|_| !self.turned) {
                        all[first].also = Some(place(name));
                    }
                }
                at += parameter.count();
            }
        }
        all
    }

    /// All numbers of each model with the free ones at their defaults.
    pub(super) fn numbers(&self) -> Vec<Vec<f64>> {
        let of = |(index, lobe): (usize, &LobeForm)| {
            let kind = lobe.known();
            let mut words = lobe.words.iter();
            let of_parameter = |parameter: &brood_brdf::Parameter| match parameter.shape {
                Shape::Choice { .. } => {
                    vec![f64::from(*words.next().expect("each choice has a word"))]
                }
                _ if index > 0 && parameter.name == BASE => vec![0.0; parameter.count()],
                _ => parameter.default(),
            };
            kind.parameters().iter().flat_map(of_parameter).collect()
        };
        self.lobes.iter().enumerate().map(of).collect()
    }

    /// The models of these coordinates.
    pub(super) fn models(&self, coordinates: &[Coordinate], x: &[f64]) -> Vec<Model> {
        let mut numbers = self.numbers();
        for (coordinate, x) in coordinates.iter().zip(x) {
            let value = coordinate.value(*x);
            let own = &mut numbers[coordinate.lobe];
            own[coordinate.at] = value;
            if let Some(also) = coordinate.also {
                own[also] = value;
            }
        }
        let model = |(lobe, numbers): (&LobeForm, Vec<f64>)| {
            Model::from_numbers(lobe.known(), &numbers).expect("values are within their ranges")
        };
        self.lobes.iter().zip(numbers).map(model).collect()
    }

    /// The coordinates of models of this form.
    pub(super) fn place(&self, models: &[Model]) -> Vec<f64> {
        let value = |c: &Coordinate| c.of(models[c.lobe].numbers()[c.at]);
        self.coordinates().iter().map(value).collect()
    }

    /// The genome of models, under the energy limit.
    pub(super) fn genome(models: Vec<Model>) -> Result<Genome, GenomeError> {
        Ok(Genome::of_models(models)?.with_limit(true))
    }
}

//! Form of a fit: one model or the sum of two, the values of its choice parameters, and which
//! parameters are free, that is fitted.

use brood_brdf::{Model, ModelKind, ParameterKind};
use brood_genome::{Genome, GenomeError, Stream};
use serde::{Deserialize, Serialize};

use super::coordinate::Coordinate;

/// One model of a form.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct LobeForm {
    /// [`ModelKind::number`].
    kind: u8,
    /// Index of the value of each choice parameter, in their order.
    choices: Vec<u8>,
}

/// Models whose sum is fitted.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Form {
    lobes: Vec<LobeForm>,
    /// True if highlights may be anisotropic, stretched along u or v.
    anisotropic: bool,
}

/// Parameters that stay 0 in isotropic forms.
const ANISOTROPY: [&str; 2] = ["stretch", "anisotropic"];
/// Parameters that equal another one in isotropic forms.
const TIED: [(&str, &str); 2] = [("alpha_y", "alpha_x"), ("exponent_v", "exponent_u")];
/// Parameter that is fixed at 0 in the second model: one diffuse part suffices.
const BASE: &str = "diffuse";

impl LobeForm {
    /// A model with the first value of every choice parameter.
    #[must_use]
    pub fn new(kind: ModelKind) -> Self {
        let choices = kind.parameters().iter().filter(|parameter| parameter.words().is_some());
        Self { kind: kind.number(), choices: choices.map(|_| 0).collect() }
    }

    /// Kind of the model; `None` if the number is unknown.
    #[must_use]
    pub fn kind(&self) -> Option<ModelKind> {
        ModelKind::from_number(self.kind)
    }

    fn known(&self) -> ModelKind {
        self.kind().expect("the form has been checked")
    }

    fn is_sound(&self) -> bool {
        let Some(kind) = self.kind() else { return false };
        let counts: Vec<usize> =
            kind.parameters().iter().filter_map(|p| p.words()).map(<[_]>::len).collect();
        let fits =
            counts.iter().zip(&self.choices).all(|(count, choice)| usize::from(*choice) < *count);
        counts.len() == self.choices.len() && fits
    }
}

impl Form {
    /// One isotropic model.
    #[must_use]
    pub fn one(kind: ModelKind) -> Self {
        Self { lobes: vec![LobeForm::new(kind)], anisotropic: false }
    }

    /// The form of a model, with the values of its choice parameters.
    #[must_use]
    pub fn of(model: &Model) -> Self {
        let choices = model.parameters().filter(|(parameter, _)| parameter.words().is_some());
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small index"
        )]
        let choices = choices.map(|(_, values)| values[0] as u8).collect();
        let anisotropic = *model != model.isotropic();
        Self { lobes: vec![LobeForm { kind: model.kind().number(), choices }], anisotropic }
    }

    /// Models of the sum.
    #[must_use]
    pub fn lobes(&self) -> &[LobeForm] {
        &self.lobes
    }

    /// True if the form is valid. A form decoded from a checkpoint may be invalid.
    pub(super) fn is_sound(&self) -> bool {
        (1..=2).contains(&self.lobes.len()) && self.lobes.iter().all(LobeForm::is_sound)
    }

    /// Copy with a second model.
    pub(super) fn with(&self, lobe: LobeForm) -> Self {
        Self { lobes: vec![self.lobes[0].clone(), lobe], anisotropic: self.anisotropic }
    }

    /// Anisotropic copy; `None` if this form is already anisotropic or its models cannot be.
    pub(super) fn to_anisotropic(&self) -> Option<Self> {
        let can = |lobe: &LobeForm| {
            let names = lobe.known().parameters().iter().map(|parameter| parameter.name);
            names
                .into_iter()
                .any(|name| ANISOTROPY.contains(&name) || TIED.iter().any(|t| t.0 == name))
        };
        let changes = !self.anisotropic && self.lobes.iter().any(can);
        changes.then(|| Self { lobes: self.lobes.clone(), anisotropic: true })
    }

    /// Copy with another value of a random choice parameter; `None` if there is no other value.
    pub(super) fn with_other_choice(&self, stream: &mut Stream) -> Option<Self> {
        let places: Vec<(usize, usize)> = (0..self.lobes.len())
            .flat_map(|lobe| (0..self.lobes[lobe].choices.len()).map(move |choice| (lobe, choice)))
            .collect();
        let count = u32::try_from(places.len()).ok().filter(|count| *count > 0)?;
        let (lobe, choice) = places[stream.below(count) as usize];
        let kind = self.lobes[lobe].known();
        let words = kind.parameters().iter().filter_map(|p| p.words()).nth(choice)?.len();
        let step = 1 + stream.below(u32::try_from(words).ok()?.max(2) - 1);
        let mut form = self.clone();
        let own = &mut form.lobes[lobe].choices[choice];
        *own = u8::try_from((u32::from(*own) + step) % u32::try_from(words).ok()?).ok()?;
        Some(form)
    }

    /// True if highlights may be anisotropic.
    pub(super) fn is_anisotropic(&self) -> bool {
        self.anisotropic
    }

    /// True if one of the models is of this kind.
    pub(super) fn has(&self, kind: ModelKind) -> bool {
        self.lobes.iter().any(|lobe| lobe.kind == kind.number())
    }

    /// Free parameters as coordinates, model by model.
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
                let is_fixed = matches!(parameter.kind, ParameterKind::Choice { .. })
                    || (!self.anisotropic && (ANISOTROPY.contains(&parameter.name) || is_tied))
                    || (index > 0 && parameter.name == BASE);
                if !is_fixed {
                    let first = all.len();
                    all.extend(
                        (0..parameter.count()).map(|k| Coordinate::new(parameter, index, at + k)),
                    );
                    let tied = TIED.iter().find(|(_, to)| *to == parameter.name);
                    if let Some((name, _)) = tied.filter(|_| !self.anisotropic) {
                        all[first].also = Some(place(name));
                    }
                }
                at += parameter.count();
            }
        }
        all
    }

    /// All parameter values of each model, free ones at their defaults.
    pub(super) fn defaults(&self) -> Vec<Vec<f64>> {
        let of = |(index, lobe): (usize, &LobeForm)| {
            let kind = lobe.known();
            let mut choices = lobe.choices.iter();
            let of_parameter = |parameter: &brood_brdf::Parameter| match parameter.kind {
                ParameterKind::Choice { .. } => {
                    vec![f64::from(*choices.next().expect("each choice parameter has a choice"))]
                }
                _ if index > 0 && parameter.name == BASE => vec![0.0; parameter.count()],
                _ => parameter.default(),
            };
            kind.parameters().iter().flat_map(of_parameter).collect()
        };
        self.lobes.iter().enumerate().map(of).collect()
    }

    /// Models with these coordinates' values at x.
    pub(super) fn models(&self, coordinates: &[Coordinate], x: &[f64]) -> Vec<Model> {
        let mut values = self.defaults();
        for (coordinate, x) in coordinates.iter().zip(x) {
            let value = coordinate.value(*x);
            let own = &mut values[coordinate.lobe];
            own[coordinate.at] = value;
            if let Some(also) = coordinate.also {
                own[also] = value;
            }
        }
        let model = |(lobe, values): (&LobeForm, Vec<f64>)| {
            Model::from_parameter_values(lobe.known(), &values)
                .expect("values are within their ranges")
        };
        self.lobes.iter().zip(values).map(model).collect()
    }

    /// Coordinates of models of this form.
    pub(super) fn place(&self, models: &[Model]) -> Vec<f64> {
        let value = |c: &Coordinate| c.of(models[c.lobe].parameter_values()[c.at]);
        self.coordinates().iter().map(value).collect()
    }

    /// Genome of models, under the energy limit.
    pub(super) fn genome(models: Vec<Model>) -> Result<Genome, GenomeError> {
        Ok(Genome::of_models(models)?.with_limit(true))
    }
}

//! What a model can be told: names, ranges, defaults and units of its parameters, and checked values for them.

/// How values of a parameter are spread: where equal steps look about equally large.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// By differences.
    Linear,
    /// By ratios; the range does not hold 0.
    Logarithmic,
}

/// What a parameter is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// One number.
    Scalar {
        /// The value unless another is given.
        default: f64,
    },
    /// One number each for red, green and blue, linear.
    Color {
        /// The values unless others are given.
        default: [f64; 3],
    },
    /// One of some words; its value is the number of the word.
    Choice {
        /// The words; the first is taken unless another is given.
        words: &'static [&'static str],
    },
}

/// A parameter of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// What texts call it.
    pub name: &'static str,
    /// What it is, and its symbol in the source.
    pub about: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it holds.
    pub shape: Shape,
    /// The least and the largest value; of each component.
    pub range: (f64, f64),
    /// How values are spread over the range.
    pub scale: Scale,
}

impl Parameter {
    /// A number from `range`, spread evenly.
    pub(super) const fn scalar(
        name: &'static str,
        about: &'static str,
        default: f64,
        range: (f64, f64),
    ) -> Self {
        Self {
            name,
            about,
            unit: "",
            shape: Shape::Scalar { default },
            range,
            scale: Scale::Linear,
        }
    }

    /// Three numbers from `range`, spread evenly.
    pub(super) const fn color(
        name: &'static str,
        about: &'static str,
        default: [f64; 3],
        range: (f64, f64),
    ) -> Self {
        Self { name, about, unit: "", shape: Shape::Color { default }, range, scale: Scale::Linear }
    }

    /// One of some words.
    pub(super) const fn choice(
        name: &'static str,
        about: &'static str,
        words: &'static [&'static str],
    ) -> Self {
        let shape = Shape::Choice { words };
        let most = words.len() as f64 - 1.0;
        Self { name, about, unit: "", shape, range: (0.0, most), scale: Scale::Linear }
    }

    /// The same, spread by ratios.
    pub(super) const fn logarithmic(mut self) -> Self {
        assert!(self.range.0 > 0.0, "ratios need a range above 0");
        self.scale = Scale::Logarithmic;
        self
    }

    /// The same with a unit.
    pub(super) const fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// How many numbers it holds.
    #[must_use]
    pub fn count(&self) -> usize {
        match self.shape {
            Shape::Scalar { .. } | Shape::Choice { .. } => 1,
            Shape::Color { .. } => 3,
        }
    }

    /// The words of a choice; none where it is a number or a colour.
    #[must_use]
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.shape {
            Shape::Choice { words } => Some(words),
            Shape::Scalar { .. } | Shape::Color { .. } => None,
        }
    }

    /// The word that its number stands for; none where it is no choice.
    #[must_use]
    pub fn word(&self, numbers: &[f64]) -> Option<&'static str> {
        let found = self.words()?.iter().zip(0_u32..).find(|(_, at)| f64::from(*at) >= numbers[0]);
        Some(found.expect("values are within their range").0)
    }

    /// Where a value lies in the range, by the parameter's scale: 0 at its least, 1 at its largest.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Logarithmic => libm::log(value / low) / libm::log(high / low),
        }
    }

    /// The value at a share of the range; shares beyond 0 and 1 stand for these.
    #[must_use]
    pub fn at_share(&self, share: f64) -> f64 {
        let (low, high) = self.range;
        let value = match self.scale {
            Scale::Linear => low + (high - low) * share,
            Scale::Logarithmic => low * libm::exp(libm::log(high / low) * share),
        };
        value.clamp(low, high)
    }

    /// Its default, as long as [`Self::count`].
    #[must_use]
    pub fn default(&self) -> Vec<f64> {
        match self.shape {
            Shape::Scalar { default } => vec![default],
            Shape::Color { default } => default.to_vec(),
            Shape::Choice { .. } => vec![0.0],
        }
    }
}

/// Values of all parameters of a model, in the order of the table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Values<'a> {
    pub(super) table: &'static [Parameter],
    pub(super) numbers: &'a [f64],
}

impl Values<'_> {
    fn find(&self, name: &str) -> (&'static Parameter, &[f64]) {
        let mut at = 0;
        for parameter in self.table {
            let count = parameter.count();
            if parameter.name == name {
                return (parameter, &self.numbers[at..at + count]);
            }
            at += count;
        }
        panic!("the table of the model has no parameter {name}")
    }

    /// # Panics
    /// Where the table has no such scalar: a model asks for its own.
    pub(super) fn scalar(&self, name: &str) -> f64 {
        self.find(name).1[0]
    }

    /// # Panics
    /// Where the table has no such colour.
    pub(super) fn color(&self, name: &str) -> glam::DVec3 {
        glam::DVec3::from_slice(self.find(name).1)
    }

    /// The word that was chosen.
    ///
    /// # Panics
    /// Where the table has no such choice.
    pub(super) fn choice(&self, name: &str) -> &'static str {
        let (parameter, numbers) = self.find(name);
        parameter.word(numbers).unwrap_or_else(|| panic!("{name} is no choice"))
    }
}

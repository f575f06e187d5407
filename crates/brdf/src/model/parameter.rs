//! Parameters of models and effects: names, ranges, defaults and units.

/// Spacing of a parameter's values: equal steps on the scale look about equally large.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterScale {
    /// Equal differences.
    Linear,
    /// Equal ratios; the range excludes 0.
    Logarithmic,
}

/// Kind of a parameter's values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterKind {
    /// One value.
    Scalar {
        /// Default value.
        default: f64,
    },
    /// Linear red, green and blue.
    Color {
        /// Default values.
        default: [f64; 3],
    },
    /// Red, green and blue of a display (sRGB), as 8-bit codes divided by 255.
    DisplayColor {
        /// Default codes.
        default: [u8; 3],
    },
    /// One word of a list; the value is the index of the word.
    Choice {
        /// The words; the first is the default.
        words: &'static [&'static str],
    },
}

/// A parameter of a model or an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name in texts.
    pub name: &'static str,
    /// Short description with its symbol in the source.
    pub about: &'static str,
    /// Unit; empty if it has none.
    pub unit: &'static str,
    /// Kind of its values.
    pub kind: ParameterKind,
    /// Least and largest value, for each component.
    pub range: (f64, f64),
    /// Spacing of values over the range.
    pub scale: ParameterScale,
}

impl Parameter {
    const fn new(
        name: &'static str,
        about: &'static str,
        kind: ParameterKind,
        range: (f64, f64),
    ) -> Self {
        Self { name, about, unit: "", kind, range, scale: ParameterScale::Linear }
    }

    /// One value in `range`, on a linear scale.
    #[must_use]
    pub const fn scalar(
        name: &'static str,
        about: &'static str,
        default: f64,
        range: (f64, f64),
    ) -> Self {
        Self::new(name, about, ParameterKind::Scalar { default }, range)
    }

    /// Three values in `range`, on a linear scale.
    #[must_use]
    pub const fn color(
        name: &'static str,
        about: &'static str,
        default: [f64; 3],
        range: (f64, f64),
    ) -> Self {
        Self::new(name, about, ParameterKind::Color { default }, range)
    }

    /// A colour of a display, on a linear scale.
    #[must_use]
    pub const fn display_color(name: &'static str, about: &'static str, default: [u8; 3]) -> Self {
        Self::new(name, about, ParameterKind::DisplayColor { default }, (0.0, 1.0))
    }

    /// A choice among words.
    #[must_use]
    pub const fn choice(
        name: &'static str,
        about: &'static str,
        words: &'static [&'static str],
    ) -> Self {
        let most = words.len() as f64 - 1.0;
        Self::new(name, about, ParameterKind::Choice { words }, (0.0, most))
    }

    /// Returns the parameter with a logarithmic scale.
    ///
    /// # Panics
    /// If the range includes 0.
    #[must_use]
    pub const fn logarithmic(mut self) -> Self {
        assert!(self.range.0 > 0.0, "a logarithmic scale needs a range above 0");
        self.scale = ParameterScale::Logarithmic;
        self
    }

    /// Returns the parameter with a unit.
    #[must_use]
    pub const fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// Number of values: 1, or 3 for a colour.
    #[must_use]
    pub fn count(&self) -> usize {
        match self.kind {
            ParameterKind::Scalar { .. } | ParameterKind::Choice { .. } => 1,
            ParameterKind::Color { .. } | ParameterKind::DisplayColor { .. } => 3,
        }
    }

    /// Words of a choice; `None` for a scalar or a colour.
    #[must_use]
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.kind {
            ParameterKind::Choice { words } => Some(words),
            ParameterKind::Scalar { .. }
            | ParameterKind::Color { .. }
            | ParameterKind::DisplayColor { .. } => None,
        }
    }

    /// True if its values are written as one word: a choice or a display colour.
    #[must_use]
    pub fn takes_word(&self) -> bool {
        matches!(self.kind, ParameterKind::Choice { .. } | ParameterKind::DisplayColor { .. })
    }

    /// Returns the values as text: numbers that read back to the same bits, a word, or a colour.
    ///
    /// # Panics
    /// If the values are not those of the parameter.
    #[must_use]
    pub fn text(&self, values: &[f64]) -> String {
        match (self.kind, values) {
            (ParameterKind::DisplayColor { .. }, values) => {
                let code = |value: &f64| format!("{:02x}", (value * 255.0).round() as u8);
                format!("#{}", values.iter().map(code).collect::<String>())
            }
            (ParameterKind::Choice { .. }, values) => {
                self.word(values).expect("the parameter is a choice").to_owned()
            }
            (ParameterKind::Scalar { .. } | ParameterKind::Color { .. }, values) => {
                values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
            }
        }
    }

    /// Word that the value of a choice stands for; `None` if the parameter is not a choice.
    #[must_use]
    pub fn word(&self, values: &[f64]) -> Option<&'static str> {
        let found = self.words()?.iter().zip(0_u32..).find(|(_, at)| f64::from(*at) >= values[0]);
        Some(found.expect("values are within their range").0)
    }

    /// Position of a value in the range on the parameter's scale: 0 at the least value, 1 at
    /// the largest.
    #[must_use]
    pub fn share(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            ParameterScale::Linear => (value - low) / (high - low),
            ParameterScale::Logarithmic => libm::log(value / low) / libm::log(high / low),
        }
    }

    /// Returns the value at a position in the range; the inverse of [`Self::share`]. Positions
    /// are clamped to [0, 1].
    #[must_use]
    pub fn at_share(&self, share: f64) -> f64 {
        let (low, high) = self.range;
        let value = match self.scale {
            ParameterScale::Linear => low + (high - low) * share,
            ParameterScale::Logarithmic => low * libm::exp(libm::log(high / low) * share),
        };
        value.clamp(low, high)
    }

    /// Default values, [`Self::count`] of them.
    #[must_use]
    pub fn default(&self) -> Vec<f64> {
        match self.kind {
            ParameterKind::Scalar { default } => vec![default],
            ParameterKind::Color { default } => default.to_vec(),
            ParameterKind::DisplayColor { default } => {
                default.iter().map(|code| f64::from(*code) / 255.0).collect()
            }
            ParameterKind::Choice { .. } => vec![0.0],
        }
    }
}

/// Diffuse albedo, under the same name in all tables.
pub(super) const ALBEDO: Parameter =
    Parameter::color("albedo", "share of light that is scattered back", [0.5; 3], (0.0, 1.0));

/// Width of the highlight: alpha of GGX, m of Beckmann.
pub(super) const ROUGHNESS: Parameter =
    Parameter::scalar("roughness", "slope of the facets, alpha or m", 0.2, (1e-4, 1.0))
        .logarithmic();

/// Refractive index of a dielectric coat.
pub(super) const IOR: Parameter =
    Parameter::scalar("ior", "refractive index of the coat", 1.5, (1.01, 3.0)).logarithmic();

/// Values of all parameters of a model, with their table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Values<'a> {
    pub(super) table: &'static [Parameter],
    pub(super) values: &'a [f64],
}

impl Values<'_> {
    fn find(&self, name: &str) -> (&'static Parameter, &[f64]) {
        let mut at = 0;
        for parameter in self.table {
            let count = parameter.count();
            if parameter.name == name {
                return (parameter, &self.values[at..at + count]);
            }
            at += count;
        }
        panic!("the table of the model has no parameter {name}")
    }

    /// Value of a scalar.
    ///
    /// # Panics
    /// If the table has no such parameter; models only name parameters of their own table.
    pub(super) fn scalar(&self, name: &str) -> f64 {
        self.find(name).1[0]
    }

    /// Linear red, green and blue of a colour.
    ///
    /// # Panics
    /// If the table has no such colour.
    pub(super) fn color(&self, name: &str) -> glam::DVec3 {
        glam::DVec3::from_slice(self.find(name).1)
    }

    /// The chosen word.
    ///
    /// # Panics
    /// If the table has no such choice.
    pub(super) fn choice(&self, name: &str) -> &'static str {
        let (parameter, values) = self.find(name);
        parameter.word(values).unwrap_or_else(|| panic!("{name} is no choice"))
    }
}

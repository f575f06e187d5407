//! Palettes: control colours from dark to bright, and the amounts of light between them.

use std::fmt;

/// Least number of colours of a palette.
pub const PALETTE_MIN: usize = 2;
/// Largest number of colours of a palette.
pub const PALETTE_MAX: usize = 8;

/// Colours of a light effect, and the edges between them.
///
/// # Invariants
/// There are 2 to 8 colours and one edge fewer. Edges ascend and are within [0, 1].
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    colors: Vec<[u8; 3]>,
    edges: Vec<f64>,
}

/// Error of [`Palette::new`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PaletteError {
    /// Too few or too many colours.
    #[error("a palette must have 2 to 8 colours, got {0}")]
    Colors(usize),
    /// The number of edges is not one less than that of colours.
    #[error("a palette of {colors} colours has {} edges, got {edges}", colors - 1)]
    Edges {
        /// Number of colours.
        colors: usize,
        /// Number of edges.
        edges: usize,
    },
    /// An edge is outside [0, 1] or not a number.
    #[error("edges must be between 0 and 1, got {0}")]
    Range(f64),
    /// An edge is below the one before it.
    #[error("edges must ascend, got {0} before {1}")]
    Order(f64, f64),
}

impl PaletteError {
    /// Name of the part that is not valid.
    #[must_use]
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::Colors(_) => Palette::COLORS,
            Self::Edges { .. } | Self::Range(_) | Self::Order(..) => Palette::EDGES,
        }
    }
}

impl Default for Palette {
    fn default() -> Self {
        let colors = vec![[0x2b, 0x1e, 0x46], [0xf2, 0xa6, 0x5a]];
        Self { edges: even_edges(colors.len()), colors }
    }
}

impl Palette {
    /// Name of the colours in texts.
    pub const COLORS: &'static str = "palette";
    /// Name of the edges in texts.
    pub const EDGES: &'static str = "edges";

    /// Creates a palette. Without edges they are even; without colours they are the default ones.
    ///
    /// # Errors
    /// Returns [`PaletteError`] if the number of colours or edges is wrong, or the edges do not
    /// ascend within [0, 1].
    pub fn new(
        colors: Option<Vec<[u8; 3]>>,
        edges: Option<Vec<f64>>,
    ) -> Result<Self, PaletteError> {
        let colors = colors.unwrap_or_else(|| Self::default().colors);
        if !(PALETTE_MIN..=PALETTE_MAX).contains(&colors.len()) {
            return Err(PaletteError::Colors(colors.len()));
        }
        let edges = edges.unwrap_or_else(|| even_edges(colors.len()));
        if edges.len() + 1 != colors.len() {
            return Err(PaletteError::Edges { colors: colors.len(), edges: edges.len() });
        }
        if let Some(edge) = edges.iter().find(|edge| !(0.0..=1.0).contains(*edge)) {
            return Err(PaletteError::Range(*edge));
        }
        if let Some(pair) = edges.windows(2).find(|pair| pair[0] > pair[1]) {
            return Err(PaletteError::Order(pair[0], pair[1]));
        }
        // Adding +0 turns -0 into 0, so that equal palettes have equal bits.
        Ok(Self { colors, edges: edges.into_iter().map(|edge| edge + 0.0).collect() })
    }

    /// Colours as 8-bit codes of a display, dark ones first.
    #[must_use]
    pub fn colors(&self) -> &[[u8; 3]] {
        &self.colors
    }

    /// Amount of light at the middle of each transition, one fewer than colours.
    #[must_use]
    pub fn edges(&self) -> &[f64] {
        &self.edges
    }
}

/// Returns the edges that divide [0, 1] into equal parts.
fn even_edges(colors: usize) -> Vec<f64> {
    (1..colors).map(|edge| edge as f64 / colors as f64).collect()
}

/// Writes a colour as `#2b1e46`.
pub(crate) fn hex(color: &[u8; 3]) -> String {
    let [red, green, blue] = color;
    format!("#{red:02x}{green:02x}{blue:02x}")
}

impl fmt::Display for Palette {
    /// Writes the lines of the colours and of the edges.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let colors: Vec<String> = self.colors.iter().map(hex).collect();
        let edges: Vec<String> = self.edges.iter().map(f64::to_string).collect();
        writeln!(f, "{} {}", Self::COLORS, colors.join(" "))?;
        writeln!(f, "{} {}", Self::EDGES, edges.join(" "))
    }
}

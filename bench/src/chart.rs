//! Charts and tables of results: SVG for people, CSV and JSON for programs.
//!
//! Owns axes, marks and text placement. Independent of what is measured and of files. Equal data
//! give equal bytes. Charts draw their own light background, so that they look alike on white and
//! on dark pages.

mod axis;
mod bars;
mod canvas;
mod plot;
mod quartiles;
mod table;

pub use axis::{Axis, number};
pub use bars::{Bar, BarChart, Group};
pub use canvas::escape;
pub use plot::{Plot, Point, Series};
pub use quartiles::Quartiles;
pub(crate) use table::cells;
pub use table::{Cell, ResultTable};

/// Chart of a result.
#[derive(Debug, Clone)]
pub enum Chart {
    /// Points and lines.
    Plot(Plot),
    /// Bars.
    Bars(BarChart),
}

impl From<Plot> for Chart {
    fn from(plot: Plot) -> Self {
        Self::Plot(plot)
    }
}

impl From<BarChart> for Chart {
    fn from(bars: BarChart) -> Self {
        Self::Bars(bars)
    }
}

impl Chart {
    /// Renders the chart as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        match self {
            Self::Plot(plot) => plot.svg(),
            Self::Bars(bars) => bars.svg(),
        }
    }
}

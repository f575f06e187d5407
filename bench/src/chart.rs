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
    /// Returns the first chart with the medians and quartiles of all, and `about` after its
    /// subtitle.
    ///
    /// # Panics
    /// Panics if the charts differ in kind or in what they show, or there is none.
    #[must_use]
    pub fn quartiles(charts: &[&Self], about: &str) -> Self {
        let (mut plots, mut bars) = (Vec::new(), Vec::new());
        for chart in charts {
            match chart {
                Self::Plot(plot) => plots.push(plot.clone()),
                Self::Bars(chart) => bars.push(chart.clone()),
            }
        }
        assert!(plots.is_empty() != bars.is_empty(), "charts must be of one kind");
        if bars.is_empty() {
            let plot = Plot::quartiles(&plots);
            return Plot { subtitle: plot.subtitle.clone() + about, ..plot }.into();
        }
        let chart = BarChart::quartiles(&bars);
        BarChart { subtitle: chart.subtitle.clone() + about, ..chart }.into()
    }

    /// Renders the chart as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        match self {
            Self::Plot(plot) => plot.svg(),
            Self::Bars(bars) => bars.svg(),
        }
    }
}

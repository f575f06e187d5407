//! Charts and tables: what a benchmark found, as SVG to look at and as CSV and JSON to compute with.
//!
//! Owns axes, marks and text placement. Refuses to know what is measured and where files go. The same data give the same
//! bytes. Charts bring their own light ground, so that they read alike on white and on dark pages.

mod axis;
mod bars;
mod canvas;
mod plot;
mod table;

pub use axis::{Axis, Scale, number};
pub use bars::{Bar, BarChart, Group};
pub use plot::{Plot, Point, Series};
pub use table::{Cell, Table};

//! Charts and tables of results: SVG for people, CSV and JSON for programs.
//!
//! Owns axes, marks and text placement. Independent of what is measured and of files. Equal data
//! give equal bytes. Charts draw their own light background, so that they look alike on white and
//! on dark pages.

mod axis;
mod bars;
mod canvas;
mod plot;
mod table;

pub use axis::{Axis, number};
pub use bars::{Bar, BarChart, Group};
pub use canvas::escape;
pub use plot::{Plot, Point, Series};
pub(crate) use table::cells;
pub use table::{Cell, ResultTable};

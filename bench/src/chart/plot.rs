//! Chart of points and lines over two axes, with labels at points and a ring around the default.

use super::axis::{Axis, Fitted};
use super::canvas::{
    Anchor, Area, Canvas, GRID, GRID_STRONG, INK, SOFT_INK, Text, colour, text_width,
};

// Lengths in pixels of SVG.
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 480.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 28.0;
const TOP: f64 = 92.0;
const BOTTOM: f64 = 62.0;

/// Chart of points and lines.
#[derive(Debug, Clone)]
pub struct Plot {
    /// Title in one line.
    pub title: String,
    /// Method of measurement in one line.
    pub subtitle: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Series in drawing order.
    pub series: Vec<Series>,
}

/// Points of one kind, joined by a line in their order, except detached ones.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points. Non-positive values are left out on a logarithmic axis, and the chart shows their
    /// number.
    pub points: Vec<Point>,
    /// True if each point has a dot; long curves have none.
    pub dots: bool,
}

/// One measurement.
#[derive(Debug, Clone, Default)]
pub struct Point {
    /// Value on the x axis.
    pub x: f64,
    /// Value on the y axis.
    pub y: f64,
    /// Text next to the point; may be empty.
    pub label: String,
    /// True if the point is the product's default.
    pub is_default: bool,
    /// True if no line joins the point to the others.
    pub is_detached: bool,
    /// Quartiles of x.
    pub x_spread: Option<[f64; 2]>,
    /// Quartiles of y.
    pub y_spread: Option<[f64; 2]>,
}

impl Point {
    /// Returns the values on the x axis: the point's and its quartiles.
    fn all_x(&self) -> impl Iterator<Item = f64> {
        [self.x].into_iter().chain(self.x_spread.into_iter().flatten())
    }

    /// Returns the values on the y axis: the point's and its quartiles.
    fn all_y(&self) -> impl Iterator<Item = f64> {
        [self.y].into_iter().chain(self.y_spread.into_iter().flatten())
    }
}

impl Series {
    /// Creates a series with a dot at each point.
    #[must_use]
    pub fn dotted(name: &str, points: impl Iterator<Item = Point>) -> Self {
        Self { name: name.to_owned(), points: points.collect(), dots: true }
    }

    /// Removes the labels and the marks of defaults from all series but the first.
    #[must_use]
    pub fn label_first<const N: usize>(mut series: [Self; N]) -> Vec<Self> {
        for point in series.iter_mut().skip(1).flat_map(|other| &mut other.points) {
            (point.label, point.is_default) = (String::new(), false);
        }
        series.into()
    }
}

impl Plot {
    /// Renders the chart as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let all = || self.series.iter().flat_map(|series| &series.points);
        let shown = |point: &&Point| self.x.scale.shows(point.x) && self.y.scale.shows(point.y);
        let x = Fitted::new(self.x.scale, all().filter(shown).flat_map(Point::all_x));
        let y = Fitted::new(self.y.scale, all().filter(shown).flat_map(Point::all_y));
        let hidden = all().count() - all().filter(shown).count();
        let frame = Area([LEFT, TOP, WIDTH - RIGHT, HEIGHT - BOTTOM]);
        let at = |point: &Point| {
            let Area([l, t, r, b]) = frame;
            [l + x.place(point.x) * (r - l), b - y.place(point.y) * (b - t)]
        };
        let mut canvas = Canvas::new(WIDTH, HEIGHT);
        heading(&mut canvas, &self.title, &self.subtitle);
        grid(&mut canvas, frame, &x, &y);
        self.axis_titles(&mut canvas, frame);
        self.legend(&mut canvas, hidden);
        let points = |series: &Series| -> Vec<Point> {
            series.points.iter().filter(shown).cloned().collect()
        };
        for (index, series) in self.series.iter().enumerate() {
            let area = |point: &Point| spread_area(point, frame, &x, &y);
            let points = points(series);
            if series.dots {
                for point in &points {
                    canvas.whiskers(at(point), area(point), colour(index));
                }
            } else {
                let spread = points.iter().filter(|point| point.y_spread.is_some());
                canvas.band(&spread.map(area).collect::<Vec<_>>(), colour(index));
            }
        }
        for (index, series) in self.series.iter().enumerate() {
            let joined = points(series).into_iter().filter(|point| !point.is_detached);
            let places: Vec<[f64; 2]> = joined.map(|point| at(&point)).collect();
            canvas.path(&places, colour(index));
        }
        for (index, series) in self.series.iter().enumerate() {
            for point in points(series) {
                if series.dots || point.is_default {
                    canvas.dot(at(&point), colour(index), point.is_default);
                }
            }
        }
        for (index, series) in self.series.iter().enumerate() {
            for point in points(series).iter().filter(|p| p.is_default || !p.label.is_empty()) {
                let label = match (point.is_default, point.label.as_str()) {
                    (false, label) => label.to_owned(),
                    (true, "") => "default".to_owned(),
                    (true, label) => format!("{label} (default)"),
                };
                canvas.label(at(point), &label, colour(index), frame);
            }
        }
        canvas.finish()
    }

    fn axis_titles(&self, canvas: &mut Canvas, Area([l, t, r, b]): Area) {
        let text =
            |x, y| Text { x, y, anchor: Anchor::Middle, size: 13.0, colour: INK, bold: false };
        canvas.text(text(0.5 * (l + r), b + 42.0), &self.x.title);
        canvas.text_upwards(text(24.0, 0.5 * (t + b)), &self.y.title);
    }

    fn legend(&self, canvas: &mut Canvas, hidden: usize) {
        let y = TOP - 16.0;
        let mut x = LEFT;
        let text = |x| Text { x, y, anchor: Anchor::Start, size: 12.0, colour: INK, bold: false };
        if self.series.len() > 1 {
            for (index, series) in self.series.iter().enumerate() {
                canvas.line([x, y - 4.0], [x + 18.0, y - 4.0], colour(index), 3.0);
                canvas.text(text(x + 23.0), &series.name);
                x += 45.0 + text_width(&series.name, 12.0);
            }
        }
        if hidden > 0 {
            let note = Text { colour: SOFT_INK, ..text(x) };
            canvas.text(note, &format!("{hidden} too small to show"));
        }
    }
}

/// Area between the quartiles of a point; quartiles that an axis cannot show are at its low end.
fn spread_area(point: &Point, Area([l, t, r, b]): Area, x: &Fitted, y: &Fitted) -> Area {
    let [left, right] = point.x_spread.unwrap_or([point.x; 2]);
    let [low, high] = point.y_spread.unwrap_or([point.y; 2]);
    let place = |axis: &Fitted, value| axis.place(value).max(0.0);
    Area([
        l + place(x, left) * (r - l),
        b - place(y, high) * (b - t),
        l + place(x, right) * (r - l),
        b - place(y, low) * (b - t),
    ])
}

/// Writes title and subtitle.
pub(super) fn heading(canvas: &mut Canvas, title: &str, subtitle: &str) {
    let text =
        |y, size, colour, bold| Text { x: 24.0, y, anchor: Anchor::Start, size, colour, bold };
    canvas.text(text(32.0, 17.0, INK, true), title);
    canvas.text(text(53.0, 12.0, SOFT_INK, false), subtitle);
}

fn grid(canvas: &mut Canvas, Area([l, t, r, b]): Area, x: &Fitted, y: &Fitted) {
    let text = |x, y, anchor| Text { x, y, anchor, size: 12.0, colour: SOFT_INK, bold: false };
    let shade = |label: &str| if label.is_empty() { GRID } else { GRID_STRONG };
    for tick in &x.ticks {
        let at = l + x.place(tick.value) * (r - l);
        canvas.line([at, t], [at, b], shade(&tick.label), 1.0);
        canvas.text(text(at, b + 19.0, Anchor::Middle), &tick.label);
    }
    for tick in &y.ticks {
        let at = b - y.place(tick.value) * (b - t);
        canvas.line([l, at], [r, at], shade(&tick.label), 1.0);
        canvas.text(text(l - 8.0, at + 4.0, Anchor::End), &tick.label);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        let axis = Axis::log;
        let point = |x, y, label: &str, is_default| Point {
            x,
            y,
            label: label.to_owned(),
            is_default,
            y_spread: Some([0.5 * y, 3.0 * y]),
            ..Point::default()
        };
        let points = vec![
            point(0.1, 1e-2, "1", false),
            point(0.4, 1e-3, "4", true),
            point(9.0, 0.0, "none", false),
        ];
        Plot {
            title: "Error".to_owned(),
            subtitle: "measured".to_owned(),
            x: axis("time, ms"),
            y: axis("RMSE"),
            series: vec![Series { name: "a".to_owned(), points, dots: true }],
        }
    }

    #[test]
    fn plot_marks_the_default_and_counts_hidden_points() {
        let svg = plot().svg();
        assert!(svg.contains(">4 (default)<") && svg.contains(r#"r="8""#), "{svg}");
        assert!(svg.contains("1 too small to show") && !svg.contains(">none<"), "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        // The axis goes on to the quartiles of both points: 5e-4 and 3e-2.
        assert!(svg.contains(">0.05<") && svg.contains(">5e-4<"), "{svg}");
        assert_eq!(svg, plot().svg());
    }

    #[test]
    fn plot_is_drawn_when_it_has_no_points() {
        let svg = Plot { series: Vec::new(), ..plot() }.svg();
        assert!(svg.ends_with("</svg>\n") && !svg.contains("NaN"), "{svg}");
    }
}

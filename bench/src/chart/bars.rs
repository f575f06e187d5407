//! Chart of horizontal bars in groups, each labelled with its value.

use super::axis::{Axis, Fitted, number};
use super::canvas::{
    Anchor, Area, Canvas, GRID, GRID_STRONG, INK, SOFT_INK, Text, colour, text_width,
};
use super::plot::heading;

// Lengths in pixels of SVG.
const WIDTH: f64 = 760.0;
const RIGHT: f64 = 150.0;
const TOP: f64 = 84.0;
const BOTTOM: f64 = 62.0;
const BAR: f64 = 17.0;
const GAP: f64 = 13.0;

/// Bar chart.
#[derive(Debug, Clone)]
pub struct BarChart {
    /// Title in one line.
    pub title: String,
    /// Method of measurement in one line.
    pub subtitle: String,
    /// Axis of the lengths. On a logarithmic axis bars start at 1, or lower if a value is below.
    pub axis: Axis,
    /// Groups from top to bottom.
    pub groups: Vec<Group>,
}

/// Bars with a common name.
#[derive(Debug, Clone)]
pub struct Group {
    /// Name to the left of the bars.
    pub name: String,
    /// Bars from top to bottom.
    pub bars: Vec<Bar>,
}

/// One bar.
#[derive(Debug, Clone, Default)]
pub struct Bar {
    /// Number of the series, which selects the colour.
    pub series: usize,
    /// Length of the bar; 0 if a logarithmic axis cannot show the value.
    pub value: f64,
    /// Text after the value next to the bar, from the unit on.
    pub suffix: String,
    /// Quartiles of the value.
    pub spread: Option<[f64; 2]>,
}

impl BarChart {
    /// Creates a chart.
    #[must_use]
    pub fn new(
        title: &str,
        subtitle: String,
        axis: Axis,
        groups: impl Iterator<Item = Group>,
    ) -> Self {
        Self { title: title.to_owned(), subtitle, axis, groups: groups.collect() }
    }

    /// Renders the chart as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let bars = || self.groups.iter().flat_map(|group| &group.bars);
        let ends = bars()
            .flat_map(|bar| [bar.value].into_iter().chain(bar.spread.map(|[_, third]| third)));
        let axis = Fitted::lengths(self.axis.scale, ends);
        let longest = self.groups.iter().map(|group| text_width(&group.name, 13.0));
        let left = 24.0 + longest.fold(60.0, f64::max) + 10.0;
        let height_of = |group: &Group| BAR * group.bars.len() as f64 + GAP;
        let bottom = TOP + self.groups.iter().map(height_of).sum::<f64>() + 4.0;
        let frame = Area([left, TOP, WIDTH - RIGHT, bottom]);
        let mut canvas = Canvas::new(WIDTH, bottom + BOTTOM);
        heading(&mut canvas, &self.title, &self.subtitle);
        self.grid(&mut canvas, frame, &axis);
        let mut top = TOP + 0.5 * GAP;
        for group in &self.groups {
            let middle = top + 0.5 * BAR * group.bars.len() as f64;
            let text =
                |x, y, anchor, colour| Text { x, y, anchor, size: 13.0, colour, bold: false };
            canvas.text(text(left - 10.0, middle + 4.5, Anchor::End, INK), &group.name);
            for bar in &group.bars {
                let place = |value: f64| {
                    let shown = self.axis.scale.shows(value);
                    let share = if shown { axis.place(value).max(0.0) } else { 0.0 };
                    left + share * (WIDTH - RIGHT - left)
                };
                let mut end = place(bar.value);
                canvas.rect(Area([left, top + 1.0, end, top + BAR - 1.0]), colour(bar.series));
                if let Some(spread) = bar.spread {
                    let [first, third] = spread.map(place);
                    let y = top + 0.5 * BAR;
                    canvas.line([first, y], [third, y], INK, 1.4);
                    for x in [first, third] {
                        canvas.line([x, y - 4.0], [x, y + 4.0], INK, 1.4);
                    }
                    end = end.max(third);
                }
                let label = Text { size: 12.0, ..text(end + 6.0, top + 12.5, Anchor::Start, INK) };
                canvas.text(label, &format!("{}{}", number(bar.value), bar.suffix));
                top += BAR;
            }
            top += GAP;
        }
        canvas.finish()
    }

    fn grid(&self, canvas: &mut Canvas, Area([l, t, r, b]): Area, axis: &Fitted) {
        let text =
            |x, y, size, colour| Text { x, y, anchor: Anchor::Middle, size, colour, bold: false };
        for tick in &axis.ticks {
            let at = l + axis.place(tick.value) * (r - l);
            let shade = if tick.label.is_empty() { GRID } else { GRID_STRONG };
            canvas.line([at, t], [at, b], shade, 1.0);
            canvas.text(text(at, b + 19.0, 12.0, SOFT_INK), &tick.label);
        }
        canvas.text(text(0.5 * (l + r), b + 42.0, 13.0, INK), &self.axis.title);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_values() {
        let bar = |value: f64| Bar { value, suffix: " x".to_owned(), ..Bar::default() };
        let group = |name: &str, value| Group { name: name.to_owned(), bars: vec![bar(value)] };
        let axis = Axis::linear("ratio");
        let groups = [group("a", 10.0), group("b", 5.0), group("c", 0.0)];
        let chart = BarChart::new("Worth", String::new(), axis, groups.into_iter());
        let svg = chart.svg();
        let width = |at: usize| -> f64 {
            let rect = svg.lines().filter(|l| l.contains("fill=\"#0067a5\"")).nth(at).unwrap();
            rect.split("width=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
        };
        assert!((width(0) - 2.0 * width(1)).abs() < 0.2 && width(2) == 0.0, "{svg}");
        assert!(svg.contains(">10 x<"), "{svg}");
    }
}

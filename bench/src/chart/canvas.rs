//! SVG elements with rounded coordinates, and placement of labels without overlap.

use std::fmt::Write;

/// Colours of background, frame, grid and text. The background is drawn, so that text stays
/// readable on dark pages.
pub(super) const GROUND: &str = "#fbfbf8";
pub(super) const BORDER: &str = "#c9c9c2";
pub(super) const GRID: &str = "#e3e3dc";
pub(super) const GRID_STRONG: &str = "#c4c4bc";
pub(super) const INK: &str = "#1d1d1b";
pub(super) const SOFT_INK: &str = "#55554f";
/// Series colours distinguishable with colour blindness (Okabe and Ito 2008), darkened for contrast
/// with white.
const SERIES: [&str; 7] =
    ["#0067a5", "#c24f00", "#00805c", "#a8487f", "#8a6d00", "#2b8fc4", "#4a4a46"];

/// Colour of a series by its number.
pub(super) fn colour(series: usize) -> &'static str {
    SERIES[series % SERIES.len()]
}

/// Alignment of text relative to its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// Position and style of a line of text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Text<'a> {
    pub x: f64,
    /// Baseline.
    pub y: f64,
    pub anchor: Anchor,
    pub size: f64,
    pub colour: &'a str,
    pub bold: bool,
}

/// Upright rectangle: left, top, right, bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area(pub [f64; 4]);

impl Area {
    fn overlaps(&self, other: &Self) -> bool {
        let [l, t, r, b] = self.0;
        let [ol, ot, or, ob] = other.0;
        l < or && ol < r && t < ob && ot < b
    }

    fn contains(&self, other: &Self) -> bool {
        let [l, t, r, b] = self.0;
        let [ol, ot, or, ob] = other.0;
        l <= ol && or <= r && t <= ot && ob <= b
    }
}

/// SVG document under construction.
pub(super) struct Canvas {
    body: String,
    width: f64,
    height: f64,
    /// Areas that labels must not overlap.
    taken: Vec<Area>,
}

impl Canvas {
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { body: String::new(), width, height, taken: Vec::new() }
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: &str, width: f64) {
        self.put(format_args!(
            r#"<line x1="{:.1}" y1="{:.1}" x2="{:.1}" y2="{:.1}" stroke="{colour}" stroke-width="{width}"/>"#,
            from[0], from[1], to[0], to[1]
        ));
    }

    pub(super) fn path(&mut self, points: &[[f64; 2]], colour: &str) {
        let places: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        self.put(format_args!(
            r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="1.8" stroke-linejoin="round"/>"#,
            places.join(" ")
        ));
    }

    /// Draws lines from the sides of an area through a point.
    pub(super) fn whiskers(&mut self, [x, y]: [f64; 2], area: Area, colour: &str) {
        let Area([l, t, r, b]) = area;
        self.line([l, y], [r, y], colour, 1.4);
        self.line([x, t], [x, b], colour, 1.4);
        self.reserve(area);
    }

    /// Fills the band between the upper and the lower sides of areas along x.
    pub(super) fn band(&mut self, areas: &[Area], colour: &str) {
        if areas.is_empty() {
            return;
        }
        let upper = areas.iter().map(|Area([l, t, r, _])| (0.5 * (l + r), *t));
        let lower = areas.iter().rev().map(|Area([l, _, r, b])| (0.5 * (l + r), *b));
        let places: Vec<String> =
            upper.chain(lower).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        self.put(format_args!(
            r#"<polygon points="{}" fill="{colour}" fill-opacity="0.2"/>"#,
            places.join(" ")
        ));
    }

    /// Draws a dot, with a ring if `is_default`.
    pub(super) fn dot(&mut self, [x, y]: [f64; 2], colour: &str, is_default: bool) {
        if is_default {
            self.put(format_args!(
                r#"<circle cx="{x:.1}" cy="{y:.1}" r="8" fill="none" stroke="{colour}" stroke-width="1.6"/>"#
            ));
        }
        self.put(format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="4" fill="{colour}"/>"#));
        self.reserve(Area([x - 8.0, y - 8.0, x + 8.0, y + 8.0]));
    }

    pub(super) fn rect(&mut self, Area([l, t, r, b]): Area, colour: &str) {
        self.put(format_args!(
            r#"<rect x="{l:.1}" y="{t:.1}" width="{:.1}" height="{:.1}" fill="{colour}"/>"#,
            (r - l).max(0.0),
            (b - t).max(0.0)
        ));
    }

    pub(super) fn text(&mut self, place: Text<'_>, text: &str) {
        self.write_text(place, text, "");
    }

    /// Writes text rotated to read upwards.
    pub(super) fn text_upwards(&mut self, place: Text<'_>, text: &str) {
        let turn = format!(r#" transform="rotate(-90 {:.1} {:.1})""#, place.x, place.y);
        self.write_text(place, text, &turn);
    }

    /// Reserves an area that labels must not overlap.
    pub(super) fn reserve(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// Writes a label next to a point where it overlaps nothing, or to the right if no place is
    /// free.
    pub(super) fn label(&mut self, [x, y]: [f64; 2], text: &str, colour: &str, within: Area) {
        const SIZE: f64 = 12.0;
        let width = text_width(text, SIZE);
        let places = [
            (Anchor::Start, [x + 10.0, y - 4.0]),
            (Anchor::Start, [x + 10.0, y + 13.0]),
            (Anchor::Middle, [x, y - 11.0]),
            (Anchor::Middle, [x, y + 20.0]),
            (Anchor::End, [x - 10.0, y - 4.0]),
            (Anchor::End, [x - 10.0, y + 13.0]),
            (Anchor::Start, [x + 10.0, y - 18.0]),
            (Anchor::Start, [x + 10.0, y + 27.0]),
            (Anchor::End, [x - 10.0, y - 18.0]),
            (Anchor::End, [x - 10.0, y + 27.0]),
        ];
        let area = |(anchor, [x, y]): &(Anchor, [f64; 2])| {
            let left = match anchor {
                Anchor::Start => *x,
                Anchor::Middle => x - 0.5 * width,
                Anchor::End => x - width,
            };
            Area([left, y - SIZE, left + width, y + 0.3 * SIZE])
        };
        let is_free =
            |area: &Area| within.contains(area) && !self.taken.iter().any(|t| t.overlaps(area));
        let place = places.iter().find(|place| is_free(&area(place))).unwrap_or(&places[0]);
        self.taken.push(area(place));
        let (anchor, [x, y]) = *place;
        let place = Text { x, y, anchor, size: SIZE, colour, bold: false };
        // A halo in the background colour separates the letters from lines behind them.
        let halo = format!(r#" stroke="{GROUND}" stroke-width="3" paint-order="stroke""#);
        self.write_text(place, text, &halo);
    }

    pub(super) fn finish(self) -> String {
        let Self { body, width, height, .. } = self;
        format!(
            concat!(
                r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w} {h}" width="{w}" height="{h}" "#,
                r#"font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif">"#,
                "\n",
                r#"<rect x="0.5" y="0.5" width="{iw}" height="{ih}" rx="8" fill="{ground}" stroke="{border}"/>"#,
                "\n{body}</svg>\n"
            ),
            w = width,
            h = height,
            iw = width - 1.0,
            ih = height - 1.0,
            ground = GROUND,
            border = BORDER,
            body = body
        )
    }

    fn write_text(&mut self, place: Text<'_>, text: &str, more: &str) {
        let Text { x, y, anchor, size, colour, bold } = place;
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if bold { r#" font-weight="bold""# } else { "" };
        self.put(format_args!(
            r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}" fill="{colour}"{weight}{more}>{}</text>"#,
            escape(text)
        ));
    }

    fn put(&mut self, element: std::fmt::Arguments<'_>) {
        writeln!(self.body, "{element}").expect("writing to a string cannot fail");
    }
}

/// Approximate width of a drawn text; fonts differ, so labels keep some distance.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    0.56 * size * text.chars().count() as f64
}

/// Escapes text for the content and the attributes of XML and HTML.
#[must_use]
pub fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn label_moves_when_its_place_is_taken() {
        let within = Area([0.0, 0.0, 200.0, 100.0]);
        let mut canvas = Canvas::new(200.0, 100.0);
        canvas.label([50.0, 50.0], "first", INK, within);
        canvas.label([50.0, 50.0], "second", INK, within);
        canvas.label([190.0, 50.0], "at the edge", INK, within);
        let svg = canvas.finish();
        let at = |text: &str| svg.lines().find(|line| line.contains(text)).unwrap().to_owned();
        assert!(at(">first<").contains(r#"y="46.0""#), "{svg}");
        assert!(at(">second<").contains(r#"y="63.0""#), "{svg}");
        assert!(!at(">at the edge<").contains("start"), "{svg}");
    }

    #[test]
    fn text_is_escaped() {
        let mut canvas = Canvas::new(10.0, 10.0);
        let place =
            Text { x: 0.0, y: 0.0, anchor: Anchor::Start, size: 9.0, colour: INK, bold: false };
        canvas.text(place, "a < b & c");
        assert!(canvas.finish().contains("a &lt; b &amp; c"));
    }
}

//! Axes: mapping of values to positions, and placement of the gridlines.

use std::borrow::Cow;

/// Mapping of values to lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences have equal lengths.
    Linear,
    /// Equal ratios have equal lengths; only positive values are drawn.
    Log,
}

/// Axis of a chart.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Quantity, with its unit.
    pub title: Cow<'static, str>,
    /// Mapping of values to lengths.
    pub scale: Scale,
}

impl Axis {
    /// Creates an axis with equal distances between equal differences.
    #[must_use]
    pub fn linear(title: impl Into<Cow<'static, str>>) -> Self {
        Self { title: title.into(), scale: Scale::Linear }
    }

    /// Creates an axis with equal distances between equal ratios.
    #[must_use]
    pub fn log(title: impl Into<Cow<'static, str>>) -> Self {
        Self { title: title.into(), scale: Scale::Log }
    }
}

/// A gridline.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    /// Empty for a line without a label.
    pub label: String,
}

/// Axis with its range and ticks.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    scale: Scale,
    low: f64,
    high: f64,
    pub ticks: Vec<Tick>,
}

/// Decades up to which 1, 2 and 5 are all labelled; above, only powers of ten.
const ALL_NUMBERED_DECADES: i32 = 3;
/// Decades above which gridlines are drawn at powers of ten only.
const FINE_DECADES: i32 = 9;

impl Scale {
    /// True if the value can be drawn on an axis of this scale.
    #[must_use]
    pub fn shows(self, value: f64) -> bool {
        value.is_finite() && (self == Self::Linear || value > 0.0)
    }
}

impl Fitted {
    /// Axis from the tick at or below the smallest value to the tick at or above the largest.
    pub(super) fn new(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|value| scale.shows(*value)) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            // No values: draws an empty frame.
            (low, high) = (1.0, 10.0);
        }
        match scale {
            // Extended, so that no point is drawn on the frame.
            Scale::Log => Self::log(low / 1.12, high * 1.12),
            Scale::Linear => Self::linear(low, high),
        }
    }

    /// Axis of bar lengths: starts at 0, or on a logarithmic scale at 1 unless a value is below.
    pub(super) fn lengths(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|value| scale.shows(*value))
            .fold((1.0, 2.0), |(low, high): (f64, f64), v| (low.min(v), high.max(v)));
        match scale {
            Scale::Log => Self::log(low, high),
            Scale::Linear => Self::linear(0.0, high),
        }
    }

    /// Axis with gridlines at 1, 2 and 5 times powers of ten.
    fn log(low: f64, high: f64) -> Self {
        let decades = libm::floor(libm::log10(low)) as i32..=libm::ceil(libm::log10(high)) as i32;
        let lines: Vec<(i32, f64)> =
            decades.flat_map(|decade| [1.0, 2.0, 5.0].map(|step| (decade, step))).collect();
        let value = |(decade, step): &(i32, f64)| power_of_ten(*decade) * step;
        let first = lines.iter().rposition(|line| value(line) <= low).unwrap_or(0);
        let last = lines.iter().position(|line| value(line) >= high).unwrap_or(lines.len() - 1);
        let lines = &lines[first..=last];
        let (low, high) = (value(&lines[0]), value(&lines[lines.len() - 1]));
        let span = libm::ceil(libm::log10(high / low)) as i32;
        let ticks = lines
            .iter()
            .filter(|(_, step)| span <= FINE_DECADES || *step <= 1.0)
            .map(|line| {
                let numbered = span <= ALL_NUMBERED_DECADES || line.1 <= 1.0;
                let value = value(line);
                Tick { value, label: if numbered { number(value) } else { String::new() } }
            })
            .collect();
        Self { scale: Scale::Log, low, high, ticks }
    }

    /// Axis with about six gridlines at multiples of 1, 2 or 5 times a power of ten.
    fn linear(low: f64, high: f64) -> Self {
        // Linear axes include zero.
        let (low, high) = (low.min(0.0), if high > low { high } else { low + 1.0 });
        let rough = (high - low) / 6.0;
        let decade = power_of_ten(libm::floor(libm::log10(rough)) as i32);
        let step = [1.0, 2.0, 5.0, 10.0].map(|s| s * decade).into_iter().find(|s| *s >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) = (libm::floor(low / step) as i32, libm::ceil(high / step) as i32);
        let ticks: Vec<Tick> = (first..=last)
            .map(|k| Tick { value: f64::from(k) * step, label: number(f64::from(k) * step) })
            .collect();
        Self {
            scale: Scale::Linear,
            low: f64::from(first) * step,
            high: f64::from(last) * step,
            ticks,
        }
    }

    /// Position of a value along the axis: 0 at the low end, 1 at the high end.
    pub(super) fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => libm::log10(value / self.low) / libm::log10(self.high / self.low),
        }
    }
}

/// 10^exponent, correctly rounded.
fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().expect("a decimal exponent is a number")
}

/// Formats a number with three significant digits, without exponent from 1e-3 to 1e6.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.2e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", trim(digits));
    }
    let digits_before = libm::floor(libm::log10(size)) as i32;
    let places = usize::try_from((2 - digits_before).max(0)).unwrap_or(0);
    let text = format!("{value:.places$}");
    if text.contains('.') { trim(&text).to_owned() } else { text }
}

/// Removes trailing zeros of a fraction.
fn trim(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Fitted) -> Vec<&str> {
        axis.ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn number_is_short_and_keeps_three_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (0.5, "0.5"),
            (0.001, "0.001"),
            (0.000_25, "2.5e-4"),
            (12.345, "12.3"),
            (1234.0, "1234"),
            (2.5e9, "2.5e9"),
            (-0.2, "-0.2"),
            (100.0, "100"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn log_axis_has_1_2_5_ticks_around_its_values() {
        let axis = Fitted::new(Scale::Log, [0.3, 40.0].into_iter());
        assert_eq!(labels(&axis), ["0.2", "0.5", "1", "2", "5", "10", "20", "50"]);
        let middle = axis.place(libm::sqrt(0.2 * 50.0));
        assert!((middle - 0.5).abs() < 1e-12 && axis.place(0.2).abs() < 1e-12, "{middle}");
        let wide = Fitted::new(Scale::Log, [1e-7, 1.0, -1.0, f64::NAN].into_iter());
        let numbered: Vec<&str> = labels(&wide).into_iter().filter(|l| !l.is_empty()).collect();
        assert!(numbered.contains(&"1e-7") && numbered.contains(&"1") && numbered.len() < 11);
    }

    #[test]
    fn lengths_start_at_1_on_a_log_axis_unless_a_value_is_below() {
        assert_eq!(labels(&Fitted::lengths(Scale::Log, [3.0, 8.0].into_iter()))[0], "1");
        assert_eq!(labels(&Fitted::lengths(Scale::Log, [0.7, 8.0].into_iter()))[0], "0.5");
        assert_eq!(labels(&Fitted::lengths(Scale::Linear, [3.0].into_iter()))[0], "0");
    }

    #[test]
    fn linear_axis_starts_at_zero_and_ends_past_its_values() {
        let axis = Fitted::new(Scale::Linear, [3.0, 97.0].into_iter());
        assert_eq!(labels(&axis), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(axis.place(50.0), 0.5);
        assert_eq!(Fitted::new(Scale::Linear, std::iter::empty()).place(0.0), 0.0);
    }
}

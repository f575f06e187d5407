//! Median and quartiles of charts and tables that several seeds gave.

use super::bars::{Bar, BarChart, Group};
use super::plot::{Plot, Point, Series};
use super::table::{Cell, ResultTable};
use crate::measure::quantile;

/// Median, first and third quartile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quartiles {
    /// Middle value.
    pub median: f64,
    /// Value that a quarter of the values is at or below.
    pub first: f64,
    /// Value that three quarters of the values are at or below.
    pub third: f64,
}

impl Quartiles {
    /// Returns the quartiles by rank; NaN for no values.
    #[must_use]
    pub fn of(values: &[f64]) -> Self {
        let [first, median, third] = [0.25, 0.5, 0.75].map(|share| quantile(values, share));
        Self { median, first, third }
    }

    /// First and third quartile; `None` if they are equal.
    #[must_use]
    pub fn spread(self) -> Option<[f64; 2]> {
        (self.first < self.third).then_some([self.first, self.third])
    }
}

impl Plot {
    /// Returns the first plot with every point at the medians, and with its quartiles.
    ///
    /// # Panics
    /// Panics if the plots differ in the number of series or points, or there is none.
    #[must_use]
    pub fn quartiles(plots: &[Self]) -> Self {
        let first = plots.first().expect("there is a plot");
        let series = |(index, first): (usize, &Series)| {
            let all: Vec<&Series> = plots.iter().map(|plot| &plot.series[index]).collect();
            let same = all.iter().all(|series| series.points.len() == first.points.len());
            assert!(same, "the series {} must have the same points for each seed", first.name);
            let point = |(at, first): (usize, &Point)| {
                let of = |value: fn(&Point) -> f64| {
                    let values: Vec<f64> =
                        all.iter().map(|series| value(&series.points[at])).collect();
                    Quartiles::of(&values)
                };
                let (x, y) = (of(|point| point.x), of(|point| point.y));
                Point {
                    x: x.median,
                    y: y.median,
                    x_spread: x.spread(),
                    y_spread: y.spread(),
                    ..first.clone()
                }
            };
            Series { points: first.points.iter().enumerate().map(point).collect(), ..first.clone() }
        };
        Self { series: first.series.iter().enumerate().map(series).collect(), ..first.clone() }
    }
}

impl BarChart {
    /// Returns the first chart with every bar as long as the median, and with its quartiles.
    ///
    /// # Panics
    /// Panics if the charts differ in their bars, or there is none.
    #[must_use]
    pub fn quartiles(charts: &[Self]) -> Self {
        let first = charts.first().expect("there is a chart");
        let group = |(index, first): (usize, &Group)| {
            let bar = |(at, first): (usize, &Bar)| {
                let values: Vec<f64> =
                    charts.iter().map(|chart| chart.groups[index].bars[at].value).collect();
                let value = Quartiles::of(&values);
                Bar { value: value.median, spread: value.spread(), ..first.clone() }
            };
            Group { bars: first.bars.iter().enumerate().map(bar).collect(), ..first.clone() }
        };
        Self { groups: first.groups.iter().enumerate().map(group).collect(), ..first.clone() }
    }
}

impl ResultTable {
    /// Returns the first table with every number that differs as its median and quartiles.
    ///
    /// # Panics
    /// Panics if the tables differ in their columns, the number of rows or a text, or there is
    /// none.
    #[must_use]
    pub fn quartiles(tables: &[Self]) -> Self {
        let first = tables.first().expect("there is a table");
        let rows = first.rows.iter().enumerate().map(|(index, row)| {
            let cell = |(column, of_first): (usize, &Cell)| {
                let all: Vec<&Cell> =
                    tables.iter().map(|table| &table.rows[index][column]).collect();
                if all.iter().all(|cell| *cell == of_first) {
                    return of_first.clone();
                }
                let name = first.columns[column];
                let value = |cell: &&Cell| {
                    cell.value()
                        .unwrap_or_else(|| panic!("{name} must be a number to have quartiles"))
                };
                let values = all.iter().filter(|cell| ***cell != Cell::Missing).map(value);
                Cell::Quartiles(Quartiles::of(&values.collect::<Vec<_>>()))
            };
            row.iter().enumerate().map(cell).collect()
        });
        for table in tables {
            assert_eq!(table.columns, first.columns, "tables must have the same columns");
            assert_eq!(table.rows.len(), first.rows.len(), "tables must have the same rows");
        }
        Self { columns: first.columns.clone(), rows: rows.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, cells};
    use super::*;

    #[test]
    fn table_has_the_quartiles_of_numbers_that_differ() {
        let table = |seed: u32, error: f64| -> ResultTable {
            [cells! { mode: "one", count: 7u32, seed: seed, error: error }].into_iter().collect()
        };
        let tables: Vec<ResultTable> =
            (1u32..=4).map(|seed| table(seed, f64::from(seed) / 8.0)).collect();
        let merged = ResultTable::quartiles(&tables);
        assert_eq!(
            merged.csv(),
            "mode,count,seed,seed_q1,seed_q3,error,error_q1,error_q3\none,7,2,1,3,0.25,0.125,0.375\n"
        );
        assert!(merged.text().contains("0.25 (0.125 to 0.375)"), "{}", merged.text());
        let json = serde_json::to_value(&merged).unwrap();
        assert_eq!(json[0]["error_q3"], 0.375);
    }

    #[test]
    fn plot_and_bars_have_medians_and_spread() {
        let plot = |y: f64| Plot {
            title: String::new(),
            subtitle: String::new(),
            x: Axis::log("x"),
            y: Axis::log("y"),
            series: vec![Series::dotted(
                "a",
                [Point { x: 3.0, y, ..Point::default() }].into_iter(),
            )],
        };
        let merged = Plot::quartiles(&[1.0, 2.0, 4.0, 8.0].map(plot));
        let point = &merged.series[0].points[0];
        assert_eq!((point.x, point.y), (3.0, 2.0));
        assert_eq!((point.x_spread, point.y_spread), (None, Some([1.0, 4.0])));
        let bars = |value: f64| BarChart {
            title: String::new(),
            subtitle: String::new(),
            axis: Axis::log("x"),
            groups: vec![Group {
                name: String::new(),
                bars: vec![Bar { value, ..Bar::default() }],
            }],
        };
        let merged = BarChart::quartiles(&[1.0, 2.0, 4.0, 8.0].map(bars));
        assert_eq!(merged.groups[0].bars[0].spread, Some([1.0, 4.0]));
    }
}

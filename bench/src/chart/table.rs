//! Table of measurements, as text, CSV and JSON.

use std::fmt::Write;

use serde::ser::{Serialize, SerializeMap, SerializeSeq, Serializer};

use super::axis::number;
use super::quartiles::Quartiles;

/// Rows with named columns.
#[derive(Debug, Clone, Default)]
pub struct ResultTable {
    pub(super) columns: Vec<&'static str>,
    pub(super) rows: Vec<Vec<Cell>>,
}

/// Value of a row in a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A word or a sentence.
    Text(String),
    /// A whole number.
    Count(u64),
    /// A measurement: full precision in JSON and CSV, three digits in text.
    Number(f64),
    /// Median and quartiles of measurements: three columns in JSON and CSV, of which two end in
    /// `_q1` and `_q3`; one in text.
    Quartiles(Quartiles),
    /// No value: null in JSON, empty in CSV.
    Missing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        if value.is_finite() { Self::Number(value) } else { Self::Missing }
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl Cell {
    /// Returns `yes`, or an empty text.
    #[must_use]
    pub fn yes_if(is_true: bool) -> Self {
        if is_true { "yes" } else { "" }.into()
    }

    /// Number in the cell; `None` for a text, quartiles or no value.
    pub(super) fn value(&self) -> Option<f64> {
        match self {
            Self::Count(count) => Some(*count as f64),
            Self::Number(value) => Some(*value),
            Self::Text(_) | Self::Quartiles(_) | Self::Missing => None,
        }
    }

    /// Cells of a column with quartiles: median, first and third quartile. They are equal if the
    /// value did not differ.
    fn parts(&self) -> [Self; 3] {
        match self {
            Self::Quartiles(Quartiles { median, first, third }) => {
                [*median, *first, *third].map(Self::from)
            }
            other => [other.clone(), other.clone(), other.clone()],
        }
    }

    /// Cell as CSV, quoted if it contains a comma, a quote or a line break.
    fn csv(&self) -> String {
        match self {
            Self::Text(text) if text.contains([',', '"', '\n']) => {
                format!("\"{}\"", text.replace('"', "\"\""))
            }
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(value) => value.to_string(),
            Self::Quartiles(quartiles) => quartiles.median.to_string(),
            Self::Missing => String::new(),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number(value) => number(*value),
            Self::Quartiles(Quartiles { median, first, third }) => {
                format!("{} ({} to {})", number(*median), number(*first), number(*third))
            }
            Self::Missing => "-".to_owned(),
        }
    }
}

/// Row of a table: each column with its value.
macro_rules! cells {
    ($($column:ident: $value:expr),* $(,)?) => {
        [$((stringify!($column), $crate::chart::Cell::from($value))),*]
    };
}
pub(crate) use cells;

impl<R: IntoIterator<Item = (&'static str, Cell)>> FromIterator<R> for ResultTable {
    fn from_iter<I: IntoIterator<Item = R>>(rows: I) -> Self {
        let mut table = Self::default();
        rows.into_iter().for_each(|row| table.push(row));
        table
    }
}

impl ResultTable {
    /// Adds the rows of another table with a column `name` in front, which holds `value`.
    pub fn append(&mut self, name: &'static str, value: impl Into<Cell>, other: &Self) {
        let value = value.into();
        for row in &other.rows {
            let cells = other.columns.iter().copied().zip(row.iter().cloned());
            self.push([(name, value.clone())].into_iter().chain(cells));
        }
    }

    /// Adds a row of columns with their cells. The first row defines the columns.
    ///
    /// # Panics
    /// Panics if `row` has other columns than the first row.
    pub fn push(&mut self, row: impl IntoIterator<Item = (&'static str, Cell)>) {
        let (columns, row): (Vec<_>, Vec<_>) = row.into_iter().unzip();
        if self.rows.is_empty() {
            self.columns = columns;
        } else {
            assert_eq!(columns, self.columns, "rows must have the same columns");
        }
        self.rows.push(row);
    }

    /// The table with three columns for each column that has quartiles: names, and cells of a row.
    fn expanded(&self) -> (Vec<String>, Vec<Vec<Cell>>) {
        let is_spread =
            |column: usize| self.rows.iter().any(|row| matches!(row[column], Cell::Quartiles(_)));
        let spread: Vec<bool> = (0..self.columns.len()).map(is_spread).collect();
        let names = |(name, spread): (&&str, &bool)| match spread {
            true => vec![(*name).to_owned(), format!("{name}_q1"), format!("{name}_q3")],
            false => vec![(*name).to_owned()],
        };
        let cells = |(cell, spread): (&Cell, &bool)| match spread {
            true => cell.parts().to_vec(),
            false => vec![cell.clone()],
        };
        let rows = self.rows.iter().map(|row| row.iter().zip(&spread).flat_map(cells).collect());
        (self.columns.iter().zip(&spread).flat_map(names).collect(), rows.collect())
    }

    /// Returns comma-separated values with a header.
    #[must_use]
    pub fn csv(&self) -> String {
        let (columns, rows) = self.expanded();
        let mut text = columns.join(",") + "\n";
        for row in &rows {
            let cells: Vec<String> = row.iter().map(Cell::csv).collect();
            text += &cells.join(",");
            text.push('\n');
        }
        text
    }

    /// Returns aligned columns for a terminal: text to the left, numbers to the right.
    #[must_use]
    pub fn text(&self) -> String {
        let printed: Vec<Vec<String>> =
            self.rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
        let width = |column: usize| {
            let cells = printed.iter().map(|row| row[column].chars().count());
            cells.chain([self.columns[column].len()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let is_text =
            |column: usize| self.rows.iter().any(|row| matches!(row[column], Cell::Text(_)));
        let mut text = String::new();
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            let mut out = String::new();
            for (column, cell) in cells.enumerate() {
                let width = widths[column];
                let result = if is_text(column) {
                    write!(out, "{cell:<width$}  ")
                } else {
                    write!(out, "{cell:>width$}  ")
                };
                result.expect("writing to a string cannot fail");
            }
            text += out.trim_end();
            text.push('\n');
        };
        line(&mut self.columns.iter().copied());
        for row in &printed {
            line(&mut row.iter().map(String::as_str));
        }
        text
    }
}

/// Serializes as a list of objects with their keys in column order.
impl Serialize for ResultTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (columns, rows) = self.expanded();
        let mut list = serializer.serialize_seq(Some(rows.len()))?;
        for row in &rows {
            list.serialize_element(&Row { columns: &columns, row })?;
        }
        list.end()
    }
}

struct Row<'a> {
    columns: &'a [String],
    row: &'a [Cell],
}

impl Serialize for Row<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.row.len()))?;
        for (column, cell) in self.columns.iter().zip(self.row) {
            map.serialize_entry(column, cell)?;
        }
        map.end()
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) => serializer.serialize_str(text),
            Self::Count(count) => serializer.serialize_u64(*count),
            Self::Number(value) => serializer.serialize_f64(*value),
            Self::Quartiles(quartiles) => serializer.serialize_f64(quartiles.median),
            Self::Missing => serializer.serialize_none(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> ResultTable {
        let mut table = ResultTable::default();
        let mut row = |mode: &str, count: u32, rmse: f64| {
            table.push(cells! { mode: mode, count: count, rmse: rmse });
        };
        row("a, \"b\"", 3, 0.012_345);
        row("c", 12, f64::NAN);
        table
    }

    #[test]
    fn table_is_the_same_in_csv_json_and_print() {
        assert_eq!(table().csv(), "mode,count,rmse\n\"a, \"\"b\"\"\",3,0.012345\nc,12,\n");
        let json = serde_json::to_string(&table()).unwrap();
        let expected = r#"[{"mode":"a, \"b\"","count":3,"rmse":0.012345},{"mode":"c","count":12,"rmse":null}]"#;
        assert_eq!(json, expected);
        let text = table().text();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "mode    count    rmse");
        assert_eq!(lines[1], "a, \"b\"      3  0.0123");
        assert_eq!(lines[2], "c          12       -");
    }
}

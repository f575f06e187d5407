//! Tables of direction pairs as CSV, with the columns wix, wiy, wiz, wox, woy, woz and others in
//! any order.

use glam::DVec3;

use super::sample::{MeasuredSamples, SampleError};
use crate::{DirectionError, DirectionPair};

/// Most columns of a table.
const COLUMNS: usize = 1024;
const DIRECTIONS: [&str; 6] = ["wix", "wiy", "wiz", "wox", "woy", "woz"];

/// Error of [`pairs_from_csv`] and [`MeasuredSamples::from_csv`]. Rows count from 1 after the
/// header.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CsvError {
    /// There are too many columns.
    #[error("the header must have at most {COLUMNS} columns")]
    Columns,
    /// A column is missing or appears twice.
    #[error("the header must have the column {0} once")]
    Column(&'static str),
    /// A field is missing or not a finite number.
    #[error("row {0}: {1} is not a finite number")]
    Number(usize, &'static str),
    /// A vector is not a direction.
    #[error("row {0}: {1}: {2}")]
    Direction(usize, &'static str, DirectionError),
    /// The rows are no valid samples.
    #[error(transparent)]
    Samples(#[from] SampleError),
}

impl MeasuredSamples {
    /// Reads a table with the columns r, g and b, one row per sample.
    ///
    /// # Errors
    /// Returns [`CsvError`] with the row and the column that are wrong.
    pub fn from_csv(bytes: &[u8]) -> Result<Self, CsvError> {
        let text = String::from_utf8_lossy(bytes);
        let rows = pairs_from_csv(&text, [("r", true), ("g", true), ("b", true)])?;
        Ok(Self::new(rows.into_iter().map(|(pair, rgb)| (pair, DVec3::from(rgb))).collect())?)
    }
}

/// Reads a table of direction pairs: a header, then one row per pair. Returns the pairs with the
/// values in the other given columns; a column that is not required reads as 0 where the table
/// lacks it. Ignores other columns, empty lines and lines that begin with `#`.
///
/// # Errors
/// Returns [`CsvError`] with the row and the column that are wrong.
pub fn pairs_from_csv<const N: usize>(
    text: &str,
    others: [(&'static str, bool); N],
) -> Result<Vec<(DirectionPair, [f64; N])>, CsvError> {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text.lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'));
    let header = lines.next().unwrap_or_default().split(',').map(field);
    let header: Vec<&str> = header.take(COLUMNS + 1).collect();
    if header.len() > COLUMNS {
        return Err(CsvError::Columns);
    }
    let mut directions = [(0, ""); 6];
    for (column, name) in directions.iter_mut().zip(DIRECTIONS) {
        *column = (find(&header, name)?.ok_or(CsvError::Column(name))?, name);
    }
    let mut columns = [None; N];
    for (column, (name, is_required)) in columns.iter_mut().zip(others) {
        *column = find(&header, name)?.map(|place| (place, name));
        if is_required && column.is_none() {
            return Err(CsvError::Column(name));
        }
    }
    let row = |(line, number): (&str, usize)| {
        let fields: Vec<&str> = line.split(',').take(header.len()).map(field).collect();
        let read = |(place, name): (usize, &'static str)| {
            let value = fields.get(place).and_then(|text| text.parse::<f64>().ok());
            value.filter(|value| value.is_finite()).ok_or(CsvError::Number(number, name))
        };
        let mut values = [0.0; 6];
        for (value, column) in values.iter_mut().zip(directions) {
            *value = read(column)?;
        }
        let mut other_values = [0.0; N];
        for (value, column) in other_values.iter_mut().zip(columns) {
            *value = column.map_or(Ok(0.0), read)?;
        }
        let [wix, wiy, wiz, wox, woy, woz] = values;
        let (wi, wo) = (DVec3::new(wix, wiy, wiz), DVec3::new(wox, woy, woz));
        let refused = |name| move |error| CsvError::Direction(number, name, error);
        // Checks each direction paired with itself first, so that the error names the right
        // one.
        DirectionPair::new(wi, wi).map_err(refused("wi"))?;
        Ok((DirectionPair::new(wi, wo).map_err(refused("wo"))?, other_values))
    };
    lines.zip(1..).map(row).collect()
}

/// Index of a column, if there is one; names may have underscores, as in `wi_x`.
fn find(header: &[&str], name: &'static str) -> Result<Option<usize>, CsvError> {
    let same = |column: &str| column.chars().filter(|c| *c != '_').eq(name.chars());
    let mut found = header.iter().enumerate().filter(|(_, column)| same(column));
    match (found.next(), found.next()) {
        (first, None) => Ok(first.map(|(place, _)| place)),
        _ => Err(CsvError::Column(name)),
    }
}

fn field(text: &str) -> &str {
    let text = text.trim();
    text.strip_prefix('"').and_then(|text| text.strip_suffix('"')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn table_of_too_many_columns_is_refused() {
        let header = |more: usize| format!("wix,wiy,wiz,wox,woy,woz{}", ",".repeat(more));
        let rows = |text: &str| pairs_from_csv::<0>(text, []);
        let row = "0,0,1,0,0,1";
        let text = format!("{}\n{row}{}\n", header(0), ",".repeat(5000));
        assert_eq!(rows(&text).unwrap().len(), 1, "what follows the last column is ignored");
        assert!(rows(&header(COLUMNS - 6)).unwrap().is_empty());
        assert_eq!(rows(&header(1 << 20)), Err(CsvError::Columns));
    }

    const HEADER: &str = "wix,wiy,wiz,wox,woy,woz,r,g,b\n";

    #[test]
    fn columns_are_found_by_name_and_others_ignored() {
        let text = "# from a goniometer\nid,b,g,r,wo_z,wo_y,wo_x,\"wiz\",wiy,wix\n\
                    7,3,2,-1,1,0,0,0.8,0,0.6\n\n8,3,2,1,-1,0,0,0.8,0,0.6\n";
        let samples = MeasuredSamples::from_csv(text.as_bytes()).unwrap();
        assert_eq!((samples.rows().len(), samples.skipped()), (1, 1));
        let (pair, rgb) = samples.rows()[0];
        assert!((pair.wi() - DVec3::new(0.6, 0.0, 0.8)).length() < 1e-15);
        assert_eq!((pair.wo(), rgb), (DVec3::Z, DVec3::new(-1.0, 2.0, 3.0)));
    }

    #[test]
    fn bad_tables_are_rejected_with_the_row_and_the_column() {
        let refused =
            |text: &str| MeasuredSamples::from_csv(text.as_bytes()).unwrap_err().to_string();
        let row = |row: &str| refused(&format!("{HEADER}0,0,1,0,0,1,1,1,1\n{row}\n"));
        assert_eq!(refused(""), "the header must have the column wix once");
        assert_eq!(
            refused("wix,wiy,wiz,wox,woy,woz,r,g\n"),
            "the header must have the column b once"
        );
        assert_eq!(refused("wix,wi_x"), "the header must have the column wix once");
        assert_eq!(row("0,0,1,0,0,1,1,1"), "row 2: b is not a finite number");
        assert_eq!(row("0,0,1,0,0,1,1,inf,1"), "row 2: g is not a finite number");
        assert_eq!(row("0,0,1,0,0,x,1,1,1"), "row 2: woz is not a finite number");
        assert!(
            row("0,0,1,0,0,1.0011,1,1,1").starts_with("row 2: wo: the length of the direction")
        );
        assert!(row("0,0.1,1,0,0,1,1,1,1").starts_with("row 2: wi: the length of the direction"));
        assert!(refused(HEADER).starts_with("no sample has both directions above"));
        assert!(refused(&format!("{HEADER}0,0,-1,0,0,1,1,1,1")).contains("(1 skipped)"));
    }

    #[test]
    fn columns_that_are_not_required_read_as_zero() {
        let others = [("u", false), ("v", false)];
        let text = "v,wix,wiy,wiz,wox,woy,woz\n0.25,0.6,0,0.8,0,0,1\n";
        let rows = pairs_from_csv(text, others).unwrap();
        assert_eq!((rows.len(), rows[0].1), (1, [0.0, 0.25]));
        assert_eq!(rows[0].0.wo(), DVec3::Z);
        let head = "wix,wiy,wiz,wox,woy,woz";
        assert_eq!(pairs_from_csv(head, others), Ok(Vec::new()));
        let twice = format!("{head},u,u\n");
        assert_eq!(pairs_from_csv(&twice, others), Err(CsvError::Column("u")));
    }

    #[test]
    fn truncated_tables_are_read_or_rejected() {
        let text = format!("{HEADER}0,0,1,0.6,0,0.8,1,1,1\n0.6,0,0.8,0,0,1,0.25,0.5,1e-3\n");
        for length in 0..text.len() {
            if let Ok(samples) = MeasuredSamples::from_csv(&text.as_bytes()[..length]) {
                assert!((1..=2).contains(&samples.rows().len()));
            }
        }
    }

    proptest! {
        #[test]
                fn any_bytes_are_read_or_rejected(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = MeasuredSamples::from_csv(&bytes);
            let _ = MeasuredSamples::from_csv(&[HEADER.as_bytes(), &bytes].concat());
        }
    }
}

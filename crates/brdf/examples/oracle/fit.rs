//! ABC and SGD with the published fits of MERL materials, against values of another program.

use std::collections::HashMap;
use std::fs::{read_dir, read_to_string};
use std::path::Path;

use brood_brdf::{Model, ModelKind};

use crate::{Failure, pairs};

/// Smallest divisor of relative errors.
const FLOOR: f64 = 1e-12;
const CLOSE: f64 = 1e-6;
const CLOSE_SHARE: f64 = 0.999;
const WORST: f64 = 5e-6;

/// Compares both models. Returns true if they agree.
pub fn check(data: &Path) -> Result<bool, Failure> {
    let abc = compare(data, "abc", "abc_low2012_microfacet.csv", ModelKind::Abc, &ABC_COLUMNS)?;
    let sgd = compare(data, "sgd", "sgd_bagher2012.csv", ModelKind::Sgd, &SGD_COLUMNS)?;
    Ok(abc && sgd)
}

/// Parameters of a model and their columns; colours have columns with `_r`, `_g` and `_b` appended.
const ABC_COLUMNS: [(&str, &str); 5] =
    [("diffuse", "kD"), ("a", "A"), ("b", "B"), ("c", "C"), ("ior", "ior")];
const SGD_COLUMNS: [(&str, &str); 11] = [
    ("rho_d", "rhoD"),
    ("rho_s", "rhoS"),
    ("alpha", "alpha"),
    ("p", "p"),
    ("f0", "F0"),
    ("f1", "F1"),
    ("k_normal", "K"),
    ("lambda", "lambda"),
    ("c", "c"),
    ("k", "k"),
    ("theta0", "theta0"),
];

fn compare(
    data: &Path,
    name: &str,
    table: &str,
    kind: ModelKind,
    columns: &[(&str, &str)],
) -> Result<bool, Failure> {
    let rows = table_rows(&data.join("tables").join(table))?;
    // Checks that the parameter ranges include every published fit.
    for (material, row) in &rows {
        model(kind, columns, row).map_err(|error| format!("{table}, {material}: {error}"))?;
    }
    let prefix = format!("merl_{name}_");
    let (mut values, mut close, mut worst, mut undefined) = (0_u64, 0_u64, 0.0_f64, 0_u64);
    let mut files = 0;
    for entry in read_dir(data.join("oracle"))? {
        let path = entry?.path();
        let file = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
        let Some(material) = file.strip_prefix(&prefix) else { continue };
        let row = rows.get(material).ok_or_else(|| format!("no {material} in {table}"))?;
        let brdf = model(kind, columns, row)?.brdf();
        files += 1;
        for (pair, wanted) in pairs(&path)? {
            let found = brdf.f(&pair);
            for (found, wanted) in found.to_array().into_iter().zip(wanted) {
                if !wanted.is_finite() {
                    undefined += 1;
                    continue;
                }
                let error = (found - wanted).abs() / wanted.abs().max(FLOOR);
                values += 1;
                close += u64::from(error <= CLOSE);
                worst = worst.max(error);
            }
        }
    }
    let share = close as f64 / values as f64;
    println!(
        "{name}: {} fits read, {files} materials compared, {values} values, {:.3} % within {CLOSE:.0e}, worst {worst:.1e}, {undefined} not finite in the source",
        rows.len(),
        100.0 * share
    );
    Ok(files > 0 && share >= CLOSE_SHARE && worst <= WORST)
}

fn model(
    kind: ModelKind,
    columns: &[(&str, &str)],
    row: &HashMap<String, f64>,
) -> Result<Model, Failure> {
    let mut model = Model::new(kind);
    for (parameter, column) in columns {
        let names = if row.contains_key(*column) {
            vec![(*column).to_owned()]
        } else {
            ["r", "g", "b"].map(|channel| format!("{column}_{channel}")).to_vec()
        };
        let values: Result<Vec<f64>, String> = names
            .iter()
            .map(|name| row.get(name).copied().ok_or_else(|| format!("no column {name}")))
            .collect();
        model = model.with(parameter, &values?)?;
    }
    Ok(model)
}

/// Numbers of a table by material and column; skips other cells.
fn table_rows(path: &Path) -> Result<HashMap<String, HashMap<String, f64>>, Failure> {
    let text = read_to_string(path)?;
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().ok_or("an empty table")?.split(',').collect();
    let rows = lines.filter(|line| !line.is_empty()).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers = head
            .iter()
            .zip(&cells)
            .filter_map(|(name, cell)| Some(((*name).to_owned(), cell.parse::<f64>().ok()?)));
        (cells[0].to_owned(), numbers.collect())
    });
    Ok(rows.collect())
}

//! Published fits of the same materials, read from tables of their parameters.

use std::collections::HashMap;
use std::path::Path;

use anyhow::{Context, Result};
use brood_brdf::{Model, ModelKind};
use brood_target::{Samples, metric};

use crate::output;

/// Model, table of its fits, and table column of each parameter; colours use the suffixes `_r`,
/// `_g` and `_b`.
struct Source {
    name: &'static str,
    kind: ModelKind,
    table: &'static str,
    columns: &'static [(&'static str, &'static str)],
    /// Parameters that are a choice of words, with the chosen word.
    choices: &'static [(&'static str, &'static str)],
}

const SOURCES: [Source; 3] = [
    Source {
        name: "sgd",
        kind: ModelKind::Sgd,
        table: "sgd_bagher2012.csv",
        columns: &[
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
        ],
        choices: &[],
    },
    Source {
        name: "abc",
        kind: ModelKind::Abc,
        table: "abc_low2012_microfacet.csv",
        columns: &[("diffuse", "kD"), ("a", "A"), ("b", "B"), ("c", "C"), ("ior", "ior")],
        choices: &[],
    },
    Source {
        name: "ward",
        kind: ModelKind::Ward,
        table: "ngan_ward.csv",
        columns: &[
            ("diffuse", "diffuse_albedo"),
            ("specular", "spec_albedo"),
            ("alpha_x", "spec_roughness"),
            ("alpha_y", "spec_roughness"),
        ],
        choices: &[("form", "ward")],
    },
];

/// Published models, by source and material.
pub struct Published(Vec<HashMap<String, Model>>);

impl Published {
    /// Reads the tables in `folder`.
    pub fn read(folder: &Path) -> Result<Self> {
        let models = |source: &Source| {
            let path = folder.join(source.table);
            let text = String::from_utf8(output::read_file(&path, 1 << 20)?);
            let text = text.with_context(|| format!("{} is not UTF-8 text", path.display()))?;
            models(source, &text).with_context(|| path.display().to_string())
        };
        Ok(Self(SOURCES.iter().map(models).collect::<Result<_>>()?))
    }

    /// Returns a source's published fit of a material.
    pub fn model(&self, source: &str, material: &str) -> Option<&Model> {
        let index = SOURCES.iter().position(|known| known.name == source)?;
        self.0[index].get(material)
    }

    /// E_log of each source's published fit of a material; `None` for a source without one.
    pub fn e_log(
        &self,
        material: &str,
        held: &Samples,
    ) -> Result<Vec<(&'static str, Option<f64>)>> {
        let e_log = |(source, models): (&Source, &HashMap<String, Model>)| {
            let model = models.get(material)?;
            let found = Samples::of(&*model.brdf(), held.pairs().to_vec());
            Some((source.name, metric::e_log(&held.weighted(), &found.weighted())))
        };
        let all = SOURCES.iter().zip(&self.0);
        Ok(all.map(|both| (both.0.name, e_log(both).map(|(_, e_log)| e_log))).collect())
    }
}

/// Reads the models of a table, by material.
fn models(source: &Source, text: &str) -> Result<HashMap<String, Model>> {
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().context("the table is empty")?.split(',').collect();
    let mut models = HashMap::new();
    for line in lines {
        let cells: HashMap<&str, &str> = head.iter().copied().zip(line.split(',')).collect();
        let name = *cells.get("material").context("the table needs a column material")?;
        let mut model = Model::new(source.kind);
        for (parameter, column) in source.columns {
            let number = |column: &str| -> Result<f64> {
                let cell =
                    cells.get(column).with_context(|| format!("{name} has no column {column}"))?;
                cell.parse()
                    .with_context(|| format!("{column} of {name} must be a number, got {cell}"))
            };
            let numbers = match cells.contains_key(column) {
                true => vec![number(column)?],
                false => ["r", "g", "b"]
                    .iter()
                    .map(|channel| number(&format!("{column}_{channel}")))
                    .collect::<Result<_>>()?,
            };
            model = model.with(parameter, &numbers)?;
        }
        for (parameter, choice) in source.choices {
            model = model.with_text(parameter, choice)?;
        }
        models.insert(name.to_owned(), model);
    }
    Ok(models)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_becomes_models_and_bad_cells_are_named() {
        let head = "material,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C,ior\n";
        let found =
            models(&SOURCES[1], &format!("{head}red,0.1,0.2,0.3,4,5,6,7,1.5,1.4\n")).unwrap();
        assert_eq!(found["red"].get("diffuse"), Some(&[0.1, 0.2, 0.3][..]));
        assert_eq!(found["red"].get("ior"), Some(&[1.4][..]));
        let error = models(&SOURCES[1], &format!("{head}red,0.1,0.2,x,4,5,6,7,1.5,1.4\n"));
        assert_eq!(error.unwrap_err().to_string(), "kD_b of red must be a number, got x");
        assert!(models(&SOURCES[1], "material,kD\nred,1\n").is_err());
    }
}

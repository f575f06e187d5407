//! Front of a search: `front.csv` and one genome file for each row.

use std::path::Path;

use anyhow::Result;
use brood_bench::chart::{Cell, ResultTable};
use brood_bench::output;
use brood_genome::Genome;

/// Writes front.csv, and each genome as front/NN.brood with its row of columns.
pub fn write<'a, const COLUMNS: usize>(
    folder: &Path,
    front: impl Iterator<Item = (&'a Genome, [(&'static str, Cell); COLUMNS])>,
) -> Result<()> {
    let genomes = folder.join("front");
    output::make_dir(&genomes)?;
    let mut table = ResultTable::default();
    for (index, (genome, columns)) in front.enumerate() {
        let name = format!("{index:02}.brood");
        output::write_file(&genomes.join(&name), genome.to_string().as_bytes())?;
        table.push([("genome", format!("front/{name}").into())].into_iter().chain(columns));
    }
    output::write_file(&folder.join("front.csv"), table.csv().as_bytes())
}

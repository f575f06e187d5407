//! Sampling of directions to the light, and its density, on arrays.

use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::value_error;
use crate::evaluate::fill;
use crate::material::NativeMaterial;
use crate::rows::{BadRow, Numbers, PairRows, Rows, direction};
use crate::threads;

/// Samples of a block.
const BLOCK: usize = 1024;

/// Density of `wi` per solid angle, as `sample` draws it.
#[pyfunction]
#[pyo3(signature = (material, wi, wo, threads))]
pub(crate) fn pdf<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    wi: Rows<'py>,
    wo: Rows<'py>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let material = material.get();
    material.check_brdf()?;
    let rows = PairRows { wi: wi.numbers()?, wo: wo.numbers()?, uv: None };
    let array = PyArray1::<f64>::zeros(py, [rows.count()], false);
    {
        let mut writable = array.readwrite();
        let out = writable.as_slice_mut().map_err(value_error)?;
        threads::run(py, threads, || {
            let table = material.table(&material.brdf());
            let blocks = out.par_chunks_mut(BLOCK).enumerate();
            let done: Vec<Result<(), BadRow>> = blocks
                .map(|(block, out)| {
                    for (index, out) in out.iter_mut().enumerate() {
                        *out = table.pdf(&rows.pair(block * BLOCK + index)?);
                    }
                    Ok(())
                })
                .collect();
            done.into_iter().collect::<Result<(), BadRow>>()
        })??;
    }
    Ok(array)
}

/// Directions to the light drawn for directions to the eye, from three random numbers each.
#[pyfunction]
#[pyo3(signature = (material, wo, random, threads))]
pub(crate) fn sample<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    wo: Rows<'py>,
    random: Rows<'py>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let material = material.get();
    material.check_brdf()?;
    let (wo, random) = (wo.numbers()?, random.numbers()?);
    let count = if wo.rows::<3>() == 0 { 0 } else { random.rows::<3>() };
    let array = PyArray2::<f64>::zeros(py, [count, 3], false);
    {
        let mut writable = array.readwrite();
        let out = writable.as_slice_mut().map_err(value_error)?;
        threads::run(py, threads, || {
            let table = material.table(&material.brdf());
            fill(out, BLOCK, |start, out| {
                for (index, out) in out.chunks_exact_mut(3).enumerate() {
                    let eye = direction("wo", &wo, start + index)?;
                    let random = unit_cube(&random, start + index)?;
                    let light = match eye.z > 0.0 {
                        true => table.sample(eye, random),
                        // Nothing is reflected: the density is 0.
                        false => DVec3::Z,
                    };
                    out.copy_from_slice(&light.to_array());
                }
                Ok(())
            })
        })??;
    }
    Ok(array)
}

/// Share of the samples that the table chooses, and the relative variance of one sample with
/// the table and by the cosine alone.
#[pyfunction]
pub(crate) fn sampling_quality(
    py: Python<'_>,
    material: &Bound<'_, NativeMaterial>,
) -> PyResult<(f64, f64, f64)> {
    let material = material.get();
    material.check_brdf()?;
    Ok(py.detach(|| {
        let table = material.table(&material.brdf());
        let (with_table, by_cosine) = table.variances();
        (table.share(), with_table, by_cosine)
    }))
}

fn unit_cube(random: &Numbers<'_>, index: usize) -> Result<[f64; 3], BadRow> {
    let numbers = random.row::<3>(index);
    if numbers.iter().all(|number| (0.0..1.0).contains(number)) {
        return Ok(numbers);
    }
    let [a, b, c] = numbers;
    let reason = format!("random numbers must be at least 0 and below 1, got ({a}, {b}, {c})");
    Err(BadRow { argument: "random", row: index, reason })
}

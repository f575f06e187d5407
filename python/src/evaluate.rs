//! Evaluation of f and of the albedo on arrays.
//!
//! Samples are evaluated in blocks whose directions, inputs and values stay in the cache of a core.

use brood_brdf::DirectionPair;
use brood_eval::{
    CanonicalEvaluator, Evaluator, Incidence, ReferenceEvaluator, TurnedPair, channel_albedos_at,
};
use brood_program::Program;
use brood_scene::SampleSet;
use glam::{DVec2, DVec3};
use numpy::{Element, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::error::value_error;
use crate::material::NativeMaterial;
use crate::rows::{BadRow, Numbers, PairRows, Rows, direction};
use crate::threads;

/// Samples of a block.
const BLOCK: usize = 4096;
/// Directions of a block of albedos, each of which takes thousands of samples.
const ALBEDO_BLOCK: usize = 1;
/// Full turn in radians.
const TURN: f64 = std::f64::consts::TAU;

/// Number type of results.
trait Real: Element + Copy + Send + Sync + Default {
    /// Returns f of each sample, without the cosines.
    fn reflectance(program: &Program, set: &SampleSet) -> Vec<[Self; 3]>;
    /// Returns the value times a factor.
    fn times(self, factor: f64) -> Self;
}

impl Real for f32 {
    fn reflectance(program: &Program, set: &SampleSet) -> Vec<[Self; 3]> {
        let mut f = Vec::new();
        CanonicalEvaluator::default()
            .eval(&[program], set, &mut f)
            .expect("the CPU evaluates every BRDF");
        let (red, rest) = f.split_at(set.len());
        let (green, blue) = rest.split_at(set.len());
        let rows = red.iter().zip(green).zip(blue);
        rows.map(|((red, green), blue)| [*red, *green, *blue]).collect()
    }

    fn times(self, factor: f64) -> Self {
        // As `brood eval` rounds.
        self * factor as Self
    }
}

impl Real for f64 {
    fn reflectance(program: &Program, set: &SampleSet) -> Vec<[Self; 3]> {
        ReferenceEvaluator::reflectance(program, set)
    }

    fn times(self, factor: f64) -> Self {
        self * factor
    }
}

/// Computes f of samples from `start` on, as many as `out` has rows; 0 if a direction is not above
/// the surface.
fn block<T: Real>(
    program: &Program,
    rows: &PairRows<'_>,
    start: usize,
    out: &mut [T],
) -> Result<(), BadRow> {
    let samples = start..start + out.len() / 3;
    let mut pairs = Vec::with_capacity(samples.len());
    for index in samples.clone() {
        pairs.push(rows.pair(index)?);
    }
    let uvs: Vec<DVec2> = match rows.uv {
        Some(_) => samples.map(|index| rows.uv(index)).collect::<Result<_, _>>()?,
        None => Vec::new(),
    };
    let mut factors = Vec::new();
    let (shown, turned);
    if let Some(bumps) = program.bumps() {
        let slopes = |uv: DVec2| bumps.slopes(uv.x, uv.y);
        let is_one_place = rows.uv.is_none_or(|uv| uv.rows::<2>() == 1);
        let shared = is_one_place.then(|| slopes(uvs.first().copied().unwrap_or(DVec2::ZERO)));
        let turn = |(index, pair): (usize, &DirectionPair)| {
            let turned = TurnedPair::at_slopes(*pair, shared.unwrap_or_else(|| slopes(uvs[index])));
            (turned.pair, turned.factor)
        };
        (turned, factors) = pairs.iter().enumerate().map(turn).unzip::<_, _, Vec<_>, Vec<_>>();
        shown = &turned;
    } else {
        shown = &pairs;
    }
    let f = T::reflectance(program, &SampleSet::from_pairs(shown, &uvs));
    // Bumps may turn a surface towards a direction that is below it.
    for ((index, (out, f)), pair) in out.chunks_exact_mut(3).zip(f).enumerate().zip(&pairs) {
        if pair.cos_i() > 0.0 && pair.cos_o() > 0.0 {
            out.copy_from_slice(&f);
            if let Some(factor) = factors.get(index) {
                out.iter_mut().for_each(|value| *value = value.times(*factor));
            }
        }
    }
    Ok(())
}

/// Computes f of all samples into an array of zeros; an error names the first bad row.
pub(crate) fn fill<T: Send>(
    out: &mut [T],
    rows_per_block: usize,
    work: impl Fn(usize, &mut [T]) -> Result<(), BadRow> + Sync,
) -> Result<(), BadRow> {
    let blocks = out.par_chunks_mut(3 * rows_per_block).enumerate();
    let done: Vec<Result<(), BadRow>> =
        blocks.map(|(block, out)| work(block * rows_per_block, out)).collect();
    done.into_iter().collect()
}

fn evaluate<'py, T: Real>(
    py: Python<'py>,
    material: &NativeMaterial,
    rows: PairRows<'_>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let array = PyArray2::<T>::zeros(py, [rows.count(), 3], false);
    {
        let mut writable = array.readwrite();
        let out = writable.as_slice_mut().map_err(value_error)?;
        threads::run(py, threads, || {
            let program = material.brdf();
            fill(out, BLOCK, |start, out| block(&program, &rows, start, out))
        })??;
    }
    Ok(array)
}

/// f in f32, or of the reference in f64.
#[pyfunction]
#[pyo3(signature = (material, wi, wo, uv, precise, threads))]
pub(crate) fn eval<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    wi: Rows<'py>,
    wo: Rows<'py>,
    uv: Option<Rows<'py>>,
    precise: bool,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let material = material.get();
    material.check_brdf()?;
    let uv = uv.as_ref().map(Rows::numbers).transpose()?;
    let rows = PairRows { wi: wi.numbers()?, wo: wo.numbers()?, uv };
    Ok(match precise {
        true => evaluate::<f64>(py, material, rows, threads)?.into_any(),
        false => evaluate::<f32>(py, material, rows, threads)?.into_any(),
    })
}

/// Directional albedo of each channel, by a quadrature of that order.
#[pyfunction]
#[pyo3(signature = (material, wi, uv, order, threads))]
pub(crate) fn albedo<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    wi: Rows<'py>,
    uv: Option<Rows<'py>>,
    order: usize,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let material = material.get();
    material.check_brdf()?;
    let uv = uv.as_ref().map(Rows::numbers).transpose()?;
    // The light comes from wi; the direction to the eye is integrated over.
    let eye = [0.0, 0.0, 1.0];
    let rows = PairRows { wi: wi.numbers()?, wo: Numbers::Double(&eye), uv };
    let array = PyArray2::<f64>::zeros(py, [rows.count(), 3], false);
    {
        let mut writable = array.readwrite();
        let out = writable.as_slice_mut().map_err(value_error)?;
        threads::run(py, threads, || {
            let program = material.brdf();
            fill(out, ALBEDO_BLOCK, |row, out| {
                let (wi, uv) = (direction("wi", &rows.wi, row)?, rows.uv(row)?);
                if let Some(place) = incidence(wi, uv) {
                    out.copy_from_slice(&channel_albedos_at(&program, &place, order));
                }
                Ok(())
            })
        })??;
    }
    Ok(array)
}

/// Place of an incident direction; `None` if it is not above the surface.
fn incidence(wi: DVec3, uv: DVec2) -> Option<Incidence> {
    let theta_deg = libm::atan2(wi.truncate().length(), wi.z).to_degrees();
    let turn = (libm::atan2(wi.y, wi.x) / TURN).rem_euclid(1.0);
    (wi.z > 0.0).then(|| Incidence::at(theta_deg, turn, uv))
}

/// Name of the SIMD instruction set in use.
#[pyfunction]
pub(crate) fn simd_level() -> &'static str {
    CanonicalEvaluator::default().level().name()
}

//! Opening the GPU, or saying in a sentence why there is none. The only module that knows the feature `gpu`.

use std::sync::Arc;

use brood_eval::Evaluator;

/// A GPU that answered and was probed.
pub(crate) struct Gpu {
    pub(crate) evaluator: Arc<dyn Evaluator>,
    pub(crate) adapter: String,
    pub(crate) is_software: bool,
    pub(crate) is_exact: bool,
    pub(crate) detail: String,
    /// How its code is written and laid out.
    pub(crate) how: String,
}

#[cfg(feature = "gpu")]
pub(crate) fn open(allow_software: bool) -> Result<Gpu, String> {
    use brood_gpu::{GpuEvaluator, GpuOptions};

    let options = GpuOptions { allow_software, ..GpuOptions::default() };
    let evaluator = GpuEvaluator::new(&options).map_err(|e| e.to_string())?;
    let adapter = evaluator.adapter();
    Ok(Gpu {
        adapter: format!("{} ({})", adapter.name, adapter.backend),
        is_software: adapter.is_software,
        is_exact: adapter.exact,
        detail: adapter.detail.clone(),
        how: format!("{}, {}", adapter.guard.name(), adapter.shape.name()),
        evaluator: Arc::new(evaluator),
    })
}

#[cfg(not(feature = "gpu"))]
pub(crate) fn open(_allow_software: bool) -> Result<Gpu, String> {
    Err("this build has no GPU support".to_owned())
}

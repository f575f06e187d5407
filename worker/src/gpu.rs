//! Opening of the GPU. This is the only module that depends on the feature `gpu`.

use std::sync::Arc;

use brood_eval::Evaluator;

/// Open GPU with the result of its exactness check.
pub(crate) struct Gpu {
    pub(crate) evaluator: Arc<dyn Evaluator>,
    pub(crate) adapter: String,
    pub(crate) is_software: bool,
    pub(crate) is_exact: bool,
    pub(crate) detail: String,
    /// Code generation and work-group layout, for the report.
    pub(crate) configuration: String,
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
        configuration: format!("{}, {}", adapter.guard.name(), adapter.shape.name()),
        evaluator: Arc::new(evaluator),
    })
}

#[cfg(not(feature = "gpu"))]
pub(crate) fn open(_allow_software: bool) -> Result<Gpu, String> {
    Err("this build has no GPU support".to_owned())
}

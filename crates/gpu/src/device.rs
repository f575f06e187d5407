//! An open device: errors are caught in scopes, waits are bounded, loss is detected. Independent of
//! programs and samples.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::Duration;

use crate::adapter::find;
use crate::float_controls::keeps_subnormals;
use crate::{GpuError, GpuOptions};

/// Largest buffer; the shader counts elements in 32 bits.
const MAX_BUFFER_BYTES: u64 = 1 << 30;
/// Factor of the timeout for the first submission of a pipeline.
const FIRST_USE: u32 = 4;

/// A device with its queue, and the instance that keeps both alive.
#[derive(Debug)]
pub(crate) struct Device {
    pub api: wgpu::Device,
    pub queue: wgpu::Queue,
    pub info: wgpu::AdapterInfo,
    /// Largest number of bytes of one buffer: the smaller limit of device and options.
    pub buffer_bytes: u64,
    /// True if a marked shader may request that subnormal numbers are kept.
    pub keeps_subnormals: bool,
    /// Largest number of bytes of workgroup memory.
    pub workgroup_bytes: u32,
    /// Time after which a submission makes the device count as lost.
    timeout: Duration,
    /// Reason of the loss, set by a callback of the API.
    lost: Arc<Mutex<Option<String>>>,
    _instance: wgpu::Instance,
}

impl Device {
    /// Opens the best adapter that the options allow; if it provides no device, the next one.
    pub(crate) fn open(options: &GpuOptions) -> Result<Self, GpuError> {
        let (instance, adapters) = find(options);
        let mut failure = GpuError::NoAdapter;
        for adapter in adapters {
            match Self::request(&instance, &adapter, options) {
                Ok(device) => return Ok(device),
                Err(error) => {
                    tracing::warn!(%error, adapter = adapter.get_info().name, "skipped a graphics adapter");
                    failure = error;
                }
            }
        }
        Err(failure)
    }

    /// Opens a device with the buffer limits of the adapter and the optional features that it has.
    fn request(
        instance: &wgpu::Instance,
        adapter: &wgpu::Adapter,
        options: &GpuOptions,
    ) -> Result<Self, GpuError> {
        let offered = adapter.limits();
        let bound = offered.max_buffer_size.min(offered.max_storage_buffer_binding_size);
        let optional = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::PASSTHROUGH_SHADERS;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("brood"),
            required_features: adapter.features() & optional,
            required_limits: wgpu::Limits {
                max_buffer_size: offered.max_buffer_size,
                max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
                max_compute_workgroup_storage_size: offered.max_compute_workgroup_storage_size,
                ..wgpu::Limits::downlevel_defaults()
            },
            ..wgpu::DeviceDescriptor::default()
        };
        let (api, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::NoDevice(error.to_string()))?;
        let lost = Arc::new(Mutex::new(None));
        let note = Arc::clone(&lost);
        api.set_device_lost_callback(move |reason, message| {
            let text = format!("{reason:?}: {message}");
            *note.lock().unwrap_or_else(PoisonError::into_inner) = Some(text);
        });
        // Without a handler an error outside of every scope would be a panic.
        api.on_uncaptured_error(Arc::new(|error| {
            tracing::error!(%error, "error of the graphics API outside of every scope");
        }));
        Ok(Self {
            api,
            queue,
            info: adapter.get_info(),
            keeps_subnormals: keeps_subnormals(adapter),
            buffer_bytes: options.buffer_bytes.min(bound).min(MAX_BUFFER_BYTES),
            workgroup_bytes: offered.max_compute_workgroup_storage_size,
            timeout: options.timeout,
            lost,
            _instance: instance.clone(),
        })
    }

    /// Creates a buffer of at least that many bytes; the caller provides the error scope.
    pub(crate) fn buffer(
        &self,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        self.api.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.next_multiple_of(16),
            usage,
            mapped_at_creation: false,
        })
    }

    /// Runs `work` in error scopes and returns the error that the API reported, if any.
    pub(crate) fn scoped<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let validation = self.api.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.api.push_error_scope(wgpu::ErrorFilter::Internal);
        let memory = self.api.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let result = work();
        let memory = pollster::block_on(memory.pop());
        let internal = pollster::block_on(internal.pop());
        let validation = pollster::block_on(validation.pop());
        if let Some(error) = memory {
            return Err(GpuError::OutOfMemory(error.to_string()));
        }
        match internal.or(validation) {
            // A lost device rejects everything. The loss is the reason that matters; a poll reports
            // it.
            Some(error) => {
                let _ = catch_unwind(AssertUnwindSafe(|| self.api.poll(wgpu::PollType::Poll)));
                Err(self.loss().unwrap_or(GpuError::Rejected(error.to_string())))
            }
            None => self.loss().map_or(Ok(result), Err),
        }
    }

    /// Waits for a submission, at most as long as the options allow.
    pub(crate) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), GpuError> {
        self.wait_for(submission, self.timeout)
    }

    /// Waits for the first submission of a pipeline, before which the driver may have to compile
    /// it.
    pub(crate) fn wait_for_first_use(
        &self,
        submission: wgpu::SubmissionIndex,
    ) -> Result<(), GpuError> {
        self.wait_for(submission, self.timeout * FIRST_USE)
    }

    fn wait_for(
        &self,
        submission: wgpu::SubmissionIndex,
        timeout: Duration,
    ) -> Result<(), GpuError> {
        let poll =
            wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(timeout) };
        // The API panics if the driver reports the loss during a wait.
        let polled = catch_unwind(AssertUnwindSafe(|| self.api.poll(poll)));
        match polled {
            Ok(Ok(_)) => self.loss().map_or(Ok(()), Err),
            Ok(Err(wgpu::PollError::Timeout)) => {
                let timeout_ms = u64::try_from(timeout.as_millis()).unwrap_or(u64::MAX);
                Err(GpuError::Timeout { timeout_ms })
            }
            // A submission fails without an error in its scope only if the device is lost.
            Ok(Err(error @ wgpu::PollError::WrongSubmissionIndex(..))) => {
                Err(self.loss().unwrap_or(GpuError::Lost(error.to_string())))
            }
            Err(_) => Err(self
                .loss()
                .unwrap_or(GpuError::Lost("the device was lost during a wait".to_owned()))),
        }
    }

    /// Maps the first `bytes` of a buffer once `submission` is finished, and passes them to `read`.
    pub(crate) fn read(
        &self,
        buffer: &wgpu::Buffer,
        bytes: u64,
        submission: wgpu::SubmissionIndex,
        read: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        let (sender, receiver) = mpsc::channel();
        let map = || {
            buffer.map_async(wgpu::MapMode::Read, ..bytes, move |result| {
                // The receiver is dropped if the wait below has failed, which is reported there.
                let _ = sender.send(result);
            });
        };
        self.scoped(map)?;
        self.wait(submission)?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.loss().unwrap_or(GpuError::Lost(error.to_string()))),
            Err(_) => {
                return Err(GpuError::Lost(
                    "a buffer was not mapped when its submission had finished".to_owned(),
                ));
            }
        }
        let view = buffer
            .get_mapped_range(..bytes)
            .map_err(|error| self.loss().unwrap_or(GpuError::Lost(error.to_string())))?;
        read(&view);
        drop(view);
        buffer.unmap();
        Ok(())
    }

    /// True if the device is lost.
    pub(crate) fn is_lost(&self) -> bool {
        self.loss().is_some()
    }

    /// Returns the error of a lost device.
    fn loss(&self) -> Option<GpuError> {
        let lost = self.lost.lock().unwrap_or_else(PoisonError::into_inner);
        lost.clone().map(GpuError::Lost)
    }
}

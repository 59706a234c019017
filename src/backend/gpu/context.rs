//! Context: the adapters of this machine and an open device.

use super::compiled::CompiledKernels;
use super::faults::{Faults, Point};
use crate::backend::guarded;
use crate::error::{Error, Result};
use crate::plan::map_layout::DeviceLimits;
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// An open device with its queue, the kernels that it has compiled, and the first error that nobody caught. A clone is the
/// same device: what renders on one after another compiles the same kernels once.
#[derive(Clone)]
pub struct Context {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// What the driver says of itself.
    pub info: wgpu::AdapterInfo,
    /// What it allows.
    pub limits: wgpu::Limits,
    /// Where it was opened.
    pub(super) adapter: wgpu::Adapter,
    /// What it has compiled.
    pub(super) compiled: Arc<CompiledKernels>,
    /// What tests make it do wrong.
    #[doc(hidden)]
    pub faults: Arc<Faults>,
    failure: Arc<Mutex<Option<Failure>>>,
}

/// The first thing that went wrong: in one line, and what to do.
struct Failure {
    what: String,
    remedy: &'static str,
}

/// What to do about a device that fails …
const OTHER_DEVICE: &str = "try --device cpu";
/// … or has not the memory.
const LESS_MEMORY: &str = "allow the device less (--memory) or use --device cpu";

/// Adapters that can run the kernels: Vulkan, Metal and DX12.
pub fn adapters() -> Vec<wgpu::Adapter> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    descriptor.flags = wgpu::InstanceFlags::empty();
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters: Vec<wgpu::Adapter> =
        pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|a| rank(a.get_info().device_type));
    adapters
}

/// Real GPUs first, software devices last.
fn rank(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

impl Context {
    /// Open the best adapter, or the best one whose name contains `name` (any case).
    ///
    /// # Errors
    /// [`Error::Device`] where there is none or it does not open.
    pub fn open(name: Option<&str>) -> Result<Self> {
        let all = adapters();
        let wanted = |a: &&wgpu::Adapter| {
            name.is_none_or(|n| a.get_info().name.to_lowercase().contains(&n.to_lowercase()))
        };
        let Some(adapter) = all.iter().find(wanted) else {
            let names: Vec<String> = all.iter().map(|a| a.get_info().name).collect();
            return Err(match name {
                Some(n) => Error::device(
                    format!("no device is called {n:?}"),
                    format!("choose one of: {}", [&names[..], &["cpu".into()]].concat().join(", ")),
                ),
                None => Error::device(
                    "no Vulkan, Metal or DX12 device was found",
                    "install a driver (on Debian: apt-get install mesa-vulkan-drivers libvulkan1) or use --device cpu",
                ),
            });
        };
        Self::from_adapter(adapter)
    }

    /// Open an adapter with the limits that it offers.
    ///
    /// # Errors
    /// [`Error::Device`] where it does not open or offers less than the kernels need.
    pub fn from_adapter(adapter: &wgpu::Adapter) -> Result<Self> {
        let info = adapter.get_info();
        let limits = adapter.limits();
        if limits.max_storage_buffers_per_shader_stage < STORAGE_BUFFERS {
            return Err(Error::device(
                format!(
                    "{} offers {} storage buffers a kernel, {STORAGE_BUFFERS} are needed",
                    info.name, limits.max_storage_buffers_per_shader_stage
                ),
                "use --device cpu",
            ));
        }
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("joton"),
            required_features: adapter.features()
                & (wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::SUBGROUP),
            required_limits: limits.clone(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        }))
        .map_err(|e| Error::device(format!("{} does not open: {e}", info.name), "use --device cpu"))?;
        let failure = Arc::new(Mutex::new(None));
        let keep = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            let is_memory = matches!(e, wgpu::Error::OutOfMemory { .. });
            let remedy = if is_memory { LESS_MEMORY } else { OTHER_DEVICE };
            if let Ok(mut first) = keep.lock() {
                first.get_or_insert_with(|| Failure { what: e.to_string(), remedy });
            }
        }));
        // a lost device is no error to wgpu: calls do nothing from then on, or fail by what is missing
        let keep = Arc::clone(&failure);
        device.set_device_lost_callback(move |_, words| {
            if let Ok(mut first) = keep.lock() {
                let why = if words.is_empty() { words } else { format!(": {words}") };
                *first = Some(Failure { what: format!("the device is lost{why}"), remedy: OTHER_DEVICE });
            }
        });
        let adapter = adapter.clone();
        let (compiled, faults) = Default::default();
        Ok(Self { device, queue, info, limits, adapter, compiled, faults, failure })
    }

    /// True for a device that runs on the host's processor (lavapipe, SwiftShader).
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// What sizes follow from.
    pub fn machine(&self) -> DeviceLimits {
        DeviceLimits {
            is_software: self.is_software(),
            storage_binding: self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size),
            uniform_binding: self.limits.max_uniform_buffer_binding_size,
            storage_buffers: self.limits.max_storage_buffers_per_shader_stage,
        }
    }

    /// True where kernels may use subgroup operations.
    pub fn has_subgroups(&self) -> bool {
        self.device.features().contains(wgpu::Features::SUBGROUP)
    }

    /// The first error since the last call, if any.
    ///
    /// # Errors
    /// [`Error::Device`] with the driver's or wgpu's words.
    pub fn check(&self) -> Result<()> {
        match self.failure.lock().ok().and_then(|mut f| f.take()) {
            Some(Failure { what, remedy }) => {
                let what = what.split_whitespace().collect::<Vec<_>>().join(" ");
                Err(Error::device(format!("{}: {what}", self.info.name), remedy))
            }
            None => Ok(()),
        }
    }

    /// Wait until everything submitted is done.
    ///
    /// # Errors
    /// [`Error::Device`] where the device was lost.
    pub fn wait(&self) -> Result<()> {
        self.wait_until(None)
    }

    /// Wait until a submission is done, and all before it; without one, until everything is.
    ///
    /// # Errors
    /// [`Error::Device`] where the device was lost.
    fn wait_until(&self, submission: Option<wgpu::SubmissionIndex>) -> Result<()> {
        let stopped = |what: &dyn std::fmt::Display| {
            Error::device(format!("{} stopped answering: {what}", self.info.name), OTHER_DEVICE)
        };
        // wgpu panics where it learns while it waits that the device is lost
        let poll = |submission_index| {
            guarded(|| self.device.poll(wgpu::PollType::Wait { submission_index, timeout: None }))
        };
        let is_one = submission.is_some();
        let polled = poll(submission);
        if is_one && !matches!(polled, Ok(Ok(_))) {
            // a lost device knows no submissions, and says so to who waits for all
            poll(None).ok();
        }
        self.check()?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(e)) => Err(stopped(&e)),
            Err(words) => Err(stopped(&words)),
        }
    }

    /// Contents of buffers, through one staging buffer that is kept from call to call.
    ///
    /// # Errors
    /// [`Error::Device`] where the copy fails.
    pub fn read(
        &self,
        staging: &mut Option<wgpu::Buffer>,
        sources: &[&wgpu::Buffer],
    ) -> Result<Vec<Vec<u8>>> {
        let whole: Vec<_> = sources.iter().map(|b| (*b, 0..b.size())).collect();
        self.read_parts(staging, &whole)
    }

    /// Likewise of these bytes of each.
    ///
    /// # Errors
    /// [`Error::Device`] where the copy fails.
    pub fn read_parts(
        &self,
        staging: &mut Option<wgpu::Buffer>,
        sources: &[(&wgpu::Buffer, Range<u64>)],
    ) -> Result<Vec<Vec<u8>>> {
        let mut out = Vec::with_capacity(sources.len());
        self.look_at(staging, sources, |_, bytes| out.push(bytes.to_vec()))?;
        Ok(out)
    }

    /// Likewise, and show `see` the number and the bytes of each source, without a copy.
    ///
    /// # Errors
    /// [`Error::Device`] where the copy fails.
    pub fn look_at(
        &self,
        staging: &mut Option<wgpu::Buffer>,
        sources: &[(&wgpu::Buffer, Range<u64>)],
        mut see: impl FnMut(usize, &[u8]),
    ) -> Result<()> {
        let mut encoder = self.encoder();
        let copy = self.copy_out(staging.take(), sources, &mut encoder)?;
        let submission = self.submit(encoder);
        *staging = Some(self.see_copy(copy, submission, &mut see)?);
        Ok(())
    }

    /// A recorder of commands.
    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Hand commands to the queue. No other place does.
    pub(super) fn submit(&self, commands: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        if self.faults.strike(Point::Submission) {
            self.device.destroy();
        }
        let submission = self.queue.submit([commands.finish()]);
        if self.faults.strike(Point::Running) {
            self.device.destroy();
        }
        submission
    }

    /// Make a buffer. No other place does.
    ///
    /// # Errors
    /// [`Error::Device`] where there is no memory for it.
    pub(super) fn buffer(
        &self,
        name: &'static str,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
        let buffer = self.device.create_buffer(&descriptor);
        let failed = pollster::block_on(scope.pop()).is_some();
        if failed || self.faults.strike(Point::Buffer) {
            let what = format!("{}: no memory is left for the buffer {name} of {size} bytes", self.info.name);
            return Err(Error::device(what, LESS_MEMORY));
        }
        Ok(buffer)
    }

    /// Record a copy of these bytes of each source, into this staging buffer where it is large enough.
    ///
    /// # Errors
    /// [`Error::Device`] where there is no memory for a larger one.
    pub(super) fn copy_out(
        &self,
        staging: Option<wgpu::Buffer>,
        sources: &[(&wgpu::Buffer, Range<u64>)],
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Copy> {
        let sizes: Vec<u64> = sources.iter().map(|(_, bytes)| bytes.end - bytes.start).collect();
        let total = sizes.iter().sum();
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = match staging.filter(|s| s.size() >= total) {
            Some(staging) => staging,
            None => self.buffer("staging", total, usage)?,
        };
        let mut at = 0;
        for ((source, bytes), size) in sources.iter().zip(&sizes) {
            encoder.copy_buffer_to_buffer(source, bytes.start, &staging, at, *size);
            at += size;
        }
        Ok(Copy { staging, sizes })
    }

    /// Wait for a copy that was handed over, and show `see` the number and the bytes of each source. The staging buffer is free then.
    ///
    /// # Errors
    /// [`Error::Device`] where the copy fails.
    pub(super) fn see_copy(
        &self,
        Copy { staging, sizes }: Copy,
        submission: wgpu::SubmissionIndex,
        see: &mut dyn FnMut(usize, &[u8]),
    ) -> Result<wgpu::Buffer> {
        let total: u64 = sizes.iter().sum();
        let (sender, receiver) = futures_intrusive::channel::shared::oneshot_channel();
        staging.map_async(wgpu::MapMode::Read, ..total, move |result| {
            sender.send(result).ok();
        });
        self.wait_until(Some(submission))?;
        let failed = |what: String| Error::device(format!("{}: {what}", self.info.name), OTHER_DEVICE);
        match pollster::block_on(receiver.receive()) {
            Some(Ok(())) => {}
            Some(Err(e)) => return Err(failed(format!("reading back failed: {e}"))),
            None => return Err(failed("reading back was dropped".into())),
        }
        if self.faults.strike(Point::Reading) {
            self.device.destroy();
        }
        {
            let mapped =
                staging.get_mapped_range(..total).map_err(|e| failed(format!("mapping failed: {e}")))?;
            let mut at = 0;
            for (i, size) in sizes.iter().enumerate() {
                see(i, &mapped[at..at + *size as usize]);
                at += *size as usize;
            }
        }
        staging.unmap();
        Ok(staging)
    }
}

/// A copy to the host: where it goes, and bytes of each source.
pub(super) struct Copy {
    pub(super) staging: wgpu::Buffer,
    sizes: Vec<u64>,
}

/// Storage buffers in the kernel that has most of them: WebGPU's default.
const STORAGE_BUFFERS: u32 = 8;

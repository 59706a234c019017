//! Compiled: what a device has compiled, kept as long as it is open. The next backend on it has its kernels at once.

use super::shaders::Variant;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A kernel as the device has it.
pub(super) struct Compiled {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) layouts: Vec<wgpu::BindGroupLayout>,
    pub(super) bindings: Vec<Binding>,
    /// Names of the overrides that the text declares.
    pub(super) overrides: Vec<String>,
}

/// One binding of a kernel.
#[derive(Debug)]
pub(super) struct Binding {
    pub(super) group: u32,
    pub(super) binding: u32,
    pub(super) name: String,
    /// Size of a uniform's struct.
    pub(super) uniform_size: Option<u64>,
}

/// A text: a file and what it is linked with; and the entry point in it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Text {
    pub(super) path: String,
    pub(super) entry: String,
    pub(super) variant: Variant,
}

/// Values of overrides, by their bits.
type Values = Vec<(String, u64)>;

/// The kernels of a device, by text and by the values of the overrides that the text declares.
#[derive(Default)]
pub(super) struct CompiledKernels {
    by_text: Mutex<HashMap<Text, HashMap<Values, Arc<Compiled>>>>,
}

impl CompiledKernels {
    /// What was compiled of `text` with these values for its overrides.
    pub(super) fn get(&self, text: &Text, overrides: &[(&str, f64)]) -> Option<Arc<Compiled>> {
        let by_text = self.by_text.lock().unwrap_or_else(PoisonError::into_inner);
        let variants = by_text.get(text)?;
        let declared = &variants.values().next()?.overrides;
        variants.get(&values(declared, overrides)).cloned()
    }

    /// Keep what was compiled.
    pub(super) fn keep(&self, text: Text, overrides: &[(&str, f64)], compiled: &Arc<Compiled>) {
        let values = values(&compiled.overrides, overrides);
        let mut by_text = self.by_text.lock().unwrap_or_else(PoisonError::into_inner);
        by_text.entry(text).or_default().insert(values, Arc::clone(compiled));
    }
}

/// The values of the declared overrides, in the order in which the text declares them; where one is named twice the last counts.
fn values(declared: &[String], overrides: &[(&str, f64)]) -> Values {
    let value = |name: &String| overrides.iter().rev().find(|(n, _)| n == name).map(|(_, v)| v.to_bits());
    declared.iter().filter_map(|name| Some((name.clone(), value(name)?))).collect()
}

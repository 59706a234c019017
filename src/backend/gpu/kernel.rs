//! Kernels: WGSL to pipeline. The bindings are read off the module, so that a name in WGSL is all that ties a buffer
//! to a kernel.

use super::compiled::{Binding, Compiled, Text};
use super::context::Context;
use super::device_buffers::{self, Buffers};
use super::faults::Point;
use super::shaders::{self, Variant};
use crate::error::{Error, Result};
use crate::plan::buffers::RING_BYTES;
use std::sync::Arc;

/// A compiled kernel.
pub struct Kernel {
    label: String,
    recipe: Recipe,
    compiled: Arc<Compiled>,
}

/// What a kernel is compiled from.
#[derive(Debug, Clone)]
pub(super) struct Recipe {
    /// Name of the file.
    path: String,
    entry: String,
    overrides: Vec<(String, f64)>,
}

impl Recipe {
    /// Compile it.
    ///
    /// # Errors
    /// [`Error::Device`] where it does not compile.
    pub(super) fn cook(&self, context: &Context) -> Result<Kernel> {
        let overrides: Vec<(&str, f64)> = self.overrides.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        Kernel::new(context, &self.path, &self.entry, &overrides)
    }
}

/// Uniforms that differ from dispatch to dispatch, bound with an offset into the ring …
const IN_RING: [&str; 4] = ["pass_info", "map_info", "scan_info", "sort_info"];
/// … or into their own buffer.
const TILES: &str = "tiles";

/// True for what is bound with an offset.
fn is_dynamic(name: &str) -> bool {
    IN_RING.contains(&name) || name == TILES
}

/// A kernel with its buffers, ready to be dispatched.
pub struct BoundKernel {
    label: String,
    pipeline: wgpu::ComputePipeline,
    groups: Vec<wgpu::BindGroup>,
    /// Names of the dynamic uniforms in each group, in the order of their bindings.
    dynamic: Vec<Vec<String>>,
}

/// Says among the overrides that the scene lies in uniform buffers; it chooses the text, not a value in it.
pub(super) const SMALL_SCENE: &str = "SMALL_SCENE";

/// Says among the overrides that the heap lies in parts, and how large these are.
pub(super) const HEAP_PART: &str = "HEAP_PART";

/// Workgroup size of every kernel.
const WORKGROUP: u32 = 64;
/// Workgroups in one dimension of a dispatch.
const GROUPS_MAX: u32 = 65_535;

impl Kernel {
    /// Compile `entry` of a shader file with values for its overrides (those it does not declare are left out), or take what
    /// this device has compiled of it. The scene is read from uniform buffers where one of them is `SMALL_SCENE`, not 0.
    ///
    /// # Errors
    /// [`Error::Device`] where the shader does not compile.
    pub fn new(context: &Context, path: &str, entry: &str, overrides: &[(&str, f64)]) -> Result<Self> {
        let small_scene = overrides.iter().any(|(name, value)| *name == SMALL_SCENE && *value != 0.0);
        let split_heap = overrides.iter().any(|(name, _)| *name == HEAP_PART);
        // what the features leave out is not even read by the driver
        let is_without =
            |feature: &str| overrides.iter().any(|(name, value)| *name == feature && *value == 0.0);
        let variant = Variant {
            subgroups: context.has_subgroups(),
            small_scene,
            split_heap,
            no_facets: is_without("HAS_FACETS"),
            no_media: is_without("HAS_MEDIA"),
            no_layers: is_without("HAS_LAYERS"),
            no_facet_textures: is_without("HAS_FACET_TEXTURES"),
            no_anisotropy: is_without("HAS_ANISOTROPY"),
            no_relief: is_without("HAS_RELIEF"),
            no_glow: is_without("HAS_GLOW"),
            no_textures: is_without("HAS_TEXTURES") && is_without("HAS_CUTOUTS"),
            no_followed_light: is_without("HAS_FOLLOWED_LIGHT"),
        };
        let text = Text { path: path.into(), entry: entry.into(), variant };
        let compiled = match context.compiled.get(&text, overrides) {
            Some(compiled) => compiled,
            None => {
                let source = shaders::link(path, variant)?;
                let compiled = Arc::new(compile(context, path, &source, entry, overrides)?);
                context.compiled.keep(text, overrides, &compiled);
                compiled
            }
        };
        Ok(Self::of(path, entry, overrides, compiled))
    }

    /// Like [`Kernel::new`] for a linked text.
    ///
    /// # Errors
    /// [`Error::Device`] where the shader does not compile.
    pub fn from_source(
        context: &Context,
        label: &str,
        source: &str,
        entry: &str,
        overrides: &[(&str, f64)],
    ) -> Result<Self> {
        let compiled = Arc::new(compile(context, label, source, entry, overrides)?);
        Ok(Self::of(label, entry, overrides, compiled))
    }

    fn of(path: &str, entry: &str, overrides: &[(&str, f64)], compiled: Arc<Compiled>) -> Self {
        let recipe = Recipe {
            path: path.into(),
            entry: entry.into(),
            overrides: overrides.iter().map(|(n, v)| (n.to_string(), *v)).collect(),
        };
        Self { label: label_of(path, entry), recipe, compiled }
    }

    /// What it was compiled from.
    pub(super) fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// Bind buffers by name; `renamed` gives for a name in the kernel the name of the buffer to use.
    ///
    /// # Errors
    /// [`Error::Device`] where a buffer is missing.
    pub fn bind(
        &self,
        context: &Context,
        buffers: &Buffers,
        renamed: &[(&str, &'static str)],
    ) -> Result<BoundKernel> {
        let buffer_of = |b: &Binding| {
            let name = if IN_RING.contains(&b.name.as_str()) {
                "ring"
            } else {
                renamed.iter().find(|(from, _)| *from == b.name).map_or(b.name.as_str(), |(_, to)| to)
            };
            buffers.get(name).ok_or_else(|| {
                Error::device(format!("no buffer is called {name}"), "report this as a bug of joton")
            })
        };
        let mut groups = Vec::new();
        let mut dynamic = Vec::new();
        for (group, layout) in self.compiled.layouts.iter().enumerate() {
            let here = || self.compiled.bindings.iter().filter(move |b| b.group == group as u32);
            let mut entries = Vec::new();
            for b in here() {
                let buffer = buffer_of(b)?;
                entries.push(wgpu::BindGroupEntry {
                    binding: b.binding,
                    resource: match b.uniform_size {
                        Some(size) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                            buffer,
                            offset: 0,
                            size: std::num::NonZeroU64::new(size),
                        }),
                        None => buffer.as_entire_binding(),
                    },
                });
            }
            groups.push(context.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout,
                entries: &entries,
            }));
            dynamic.push(here().filter(|b| is_dynamic(&b.name)).map(|b| b.name.clone()).collect());
        }
        context.check()?;
        Ok(BoundKernel {
            label: self.label.clone(),
            pipeline: self.compiled.pipeline.clone(),
            groups,
            dynamic,
        })
    }

    /// Bind buffers of its own, as small as they can be, with zeros in them; and the buffer of the ring.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails.
    pub(super) fn bind_nothing(&self, context: &Context) -> Result<(BoundKernel, wgpu::Buffer)> {
        let mut buffers = Buffers::new();
        let ring = device_buffers::uniform(context, "ring", RING_BYTES)?;
        buffers.insert("ring", ring.clone());
        // names of buffers live as long as the program: each binding gets one of these
        let names: Vec<(&str, &'static str)> =
            self.compiled.bindings.iter().zip(NOTHING).map(|(b, name)| (b.name.as_str(), name)).collect();
        for (b, (_, name)) in self.compiled.bindings.iter().zip(&names) {
            let buffer = match b.uniform_size {
                Some(size) => device_buffers::uniform(context, name, size)?,
                None => device_buffers::storage(context, name, NOTHING_BYTES)?,
            };
            buffers.insert(name, buffer);
        }
        Ok((self.bind(context, &buffers, &names)?, ring))
    }
}

/// Compile `entry` of a text.
///
/// # Errors
/// [`Error::Device`] where it does not compile.
fn compile(
    context: &Context,
    label: &str,
    source: &str,
    entry: &str,
    overrides: &[(&str, f64)],
) -> Result<Compiled> {
    let failed = |what: String| Error::device(format!("{label}: {what}"), "report this as a bug of joton");
    let module = naga::front::wgsl::parse_str(source)
        .map_err(|e| failed(e.emit_to_string_with_path(source, label)))?;
    let bindings = reflect(&module);
    let constants: Vec<(&str, f64)> = overrides
        .iter()
        .copied()
        .filter(|(name, _)| module.overrides.iter().any(|(_, o)| o.name.as_deref() == Some(name)))
        .collect();
    let groups = bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
    let layouts: Vec<wgpu::BindGroupLayout> = (0..groups)
        .map(|group| {
            let entries: Vec<wgpu::BindGroupLayoutEntry> =
                bindings.iter().filter(|b| b.group == group).map(|b| layout_entry(b, &module)).collect();
            context.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries: &entries,
            })
        })
        .collect();
    let layout_refs: Vec<Option<&wgpu::BindGroupLayout>> = layouts.iter().map(Some).collect();
    let pipeline_layout = context.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &layout_refs,
        immediate_size: 0,
    });
    let shader = context.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let found = if context.faults.strike(Point::Kernel) { "missing" } else { entry };
    let pipeline = context.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: Some(&pipeline_layout),
        module: &shader,
        entry_point: Some(found),
        cache: None,
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &constants,
            zero_initialize_workgroup_memory: false,
        },
    });
    context.check()?;
    let overrides = module.overrides.iter().filter_map(|(_, o)| o.name.clone()).collect();
    Ok(Compiled { pipeline, layouts, bindings, overrides })
}

/// Names of the buffers of a kernel that is run on nothing: as many as a kernel can bind.
const NOTHING: [&str; 24] = [
    "0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13", "14", "15", "16", "17", "18",
    "19", "20", "21", "22", "23",
];
/// Bytes of each: room for an element.
const NOTHING_BYTES: u64 = 4096;

/// "scan reduce" for passes/scan.wgsl's entry reduce, "eye" for the only entry of passes/eye.wgsl.
fn label_of(path: &str, entry: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    let stem = name.trim_end_matches(".wgsl");
    if entry == "main" { stem.to_string() } else { format!("{stem} {entry}") }
}

/// What a pipeline asks of the buffer of a binding.
fn layout_entry(binding: &Binding, module: &naga::Module) -> wgpu::BindGroupLayoutEntry {
    let variable = module
        .global_variables
        .iter()
        .find(|(_, v)| v.name.as_deref() == Some(binding.name.as_str()))
        .map(|(_, v)| v.space);
    let read_only = matches!(variable, Some(naga::AddressSpace::Storage { access }) if !access.contains(naga::StorageAccess::STORE));
    wgpu::BindGroupLayoutEntry {
        binding: binding.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: if binding.uniform_size.is_some() {
                wgpu::BufferBindingType::Uniform
            } else {
                wgpu::BufferBindingType::Storage { read_only }
            },
            has_dynamic_offset: is_dynamic(&binding.name),
            min_binding_size: None,
        },
        count: None,
    }
}

/// The buffer bindings of a module, by group and binding.
fn reflect(module: &naga::Module) -> Vec<Binding> {
    let mut layouter = naga::proc::Layouter::default();
    // a type that cannot be laid out is reported by the compiler proper
    layouter.update(module.to_ctx()).ok();
    let mut bindings: Vec<Binding> = module
        .global_variables
        .iter()
        .filter_map(|(_, v)| {
            let at = v.binding.as_ref()?;
            let uniform = matches!(v.space, naga::AddressSpace::Uniform);
            Some(Binding {
                group: at.group,
                binding: at.binding,
                name: v.name.clone().unwrap_or_default(),
                uniform_size: uniform.then(|| u64::from(layouter[v.ty].size)),
            })
        })
        .collect();
    bindings.sort_by_key(|b| (b.group, b.binding));
    bindings
}

/// Offsets into the ring, by the names of the dynamic uniforms.
pub(super) type Offsets<'a> = &'a [(&'a str, u32)];

impl BoundKernel {
    /// Name of the kernel: file and entry point.
    pub(super) fn label(&self) -> &str {
        &self.label
    }

    /// Workgroups, folded into two dimensions, that hold at least `invocations`.
    pub(super) fn groups_for(&self, invocations: u32) -> [u32; 2] {
        let groups = invocations.div_ceil(WORKGROUP);
        let x = groups.min(GROUPS_MAX);
        [x, groups.div_ceil(x)]
    }

    /// Record a dispatch of `x` × `y` workgroups.
    pub(super) fn dispatch_groups(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        offsets: Offsets<'_>,
        [x, y]: [u32; 2],
    ) {
        pass.set_pipeline(&self.pipeline);
        for (i, group) in self.groups.iter().enumerate() {
            let at: Vec<u32> = self.dynamic[i]
                .iter()
                .map(|name| offsets.iter().find(|(n, _)| n == name).map_or(0, |(_, at)| *at))
                .collect();
            pass.set_bind_group(i as u32, group, &at);
        }
        pass.dispatch_workgroups(x, y, 1);
    }
}

//! Pipelines: the kernels that a plan needs, compiled, and bound to their buffers.

use super::context::Context;
use super::device_buffers::Buffers;
use super::kernel::{BoundKernel, HEAP_PART, Kernel, Offsets, SMALL_SCENE};
use super::map::{Map, MapKernels};
use super::recorder::Recorder;
use super::scene_buffers;
use crate::error::Result;
use crate::estimators::maps::MapKind;
use crate::film::Layer;
use crate::packed::PackedScene;
use crate::packed::constants::{STEP_BUDGET, STEP_BUDGET_HARDWARE};
use crate::packed::layout::PassInfo;
use crate::plan::buffers::{heap_layout, heap_part, is_split};
use crate::plan::map_layout::MapLayouts;
use crate::plan::{CAUSTIC_FOOTPRINTS, Part, Plan};

/// The compiled kernels.
pub(super) struct Kernels {
    eye: Kernel,
    glint: Option<[Kernel; 3]>,
    direct: Option<Kernel>,
    indirect: Option<Kernel>,
    trace: [Option<Kernel>; 2],
    gather: [Option<Kernel>; 2],
    kernel_correction: Option<Kernel>,
    clip_planes: Option<Kernel>,
    caustic_disc: Option<Kernel>,
    caustic_count: Option<Kernel>,
    caustic_radius: Option<Kernel>,
    map: Option<MapKernels>,
}

impl Kernels {
    /// Compile what the plan needs.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where a kernel does not compile.
    pub(super) fn new(context: &Context, scene: &PackedScene, plan: &Plan) -> Result<Self> {
        let flag = |on: bool| if on { 1.0 } else { 0.0 };
        let mut features = vec![
            (SMALL_SCENE, flag(scene_buffers::is_small(context, scene))),
            (
                "CAMERA_STEPS",
                f64::from(if context.is_software() { STEP_BUDGET } else { STEP_BUDGET_HARDWARE }),
            ),
        ];
        features.extend(plan.features.named().map(|(name, on)| (name, flag(on))));
        if is_split(heap_layout(scene, plan).bytes(), &context.machine()) {
            features.push((HEAP_PART, f64::from(heap_part(&context.machine()))));
        }
        let compile = |path: &str| Kernel::new(context, path, "main", &features);
        let with = |path: &str, caustic: bool| {
            let guide = if caustic { &plan.guides.caustic } else { &plan.guides.diffuse };
            let has_warps = !guide.warps().is_empty() || plan.settings.keeps(Part::Warps);
            let mut overrides = features.to_vec();
            overrides.extend([
                ("CAUSTIC", flag(caustic)),
                ("HAS_WARPS", flag(has_warps)),
                ("HAS_VISIBLE_CELLS", flag(plan.visible_cells.is_some())),
            ]);
            Kernel::new(context, path, "main", &overrides)
        };
        let [caustic, diffuse] = MapKind::ALL.map(|kind| plan.has_map(kind));
        let indirect = || {
            let mut overrides = features.to_vec();
            overrides.extend([
                ("HAS_CAUSTIC_MAP", flag(caustic)),
                ("RADIUS_FOOTPRINTS", f64::from(CAUSTIC_FOOTPRINTS[1])),
            ]);
            Kernel::new(context, "passes/indirect.wgsl", "main", &overrides)
        };
        let optional = |on: bool, k: &dyn Fn() -> Result<Kernel>| on.then(k).transpose();
        let pilot = [
            ("RADIUS_FOOTPRINTS", f64::from(CAUSTIC_FOOTPRINTS[1])),
            ("RADIUS_FOOTPRINTS_MIN", f64::from(CAUSTIC_FOOTPRINTS[0])),
            ("WANTED", f64::from(plan.caustic_wanted)),
        ];
        Ok(Self {
            eye: compile("passes/eye.wgsl")?,
            glint: if plan.traces(Layer::Emission) {
                Some([
                    compile("passes/glint.wgsl")?,
                    compile("passes/glint_sum.wgsl")?,
                    compile("passes/glint_mark.wgsl")?,
                ])
            } else {
                None
            },
            direct: optional(plan.traces(Layer::Direct), &|| compile("passes/direct.wgsl"))?,
            indirect: optional(plan.has_indirect_paths(), &indirect)?,
            trace: [
                optional(caustic, &|| with("passes/trace.wgsl", true))?,
                optional(diffuse, &|| with("passes/trace.wgsl", false))?,
            ],
            gather: [
                optional(caustic, &|| with("passes/gather.wgsl", true))?,
                optional(diffuse, &|| with("passes/gather.wgsl", false))?,
            ],
            kernel_correction: optional(diffuse, &|| {
                let overrides = [("SPECULAR_BODIES", flag(plan.has_specular_bodies()))];
                Kernel::new(context, "passes/kernel_correction.wgsl", "main", &overrides)
            })?,
            clip_planes: optional(diffuse, &|| compile("passes/clip_planes.wgsl"))?,
            caustic_disc: optional(caustic, &|| {
                let mut overrides = features.to_vec();
                overrides.push(("RADIUS_FOOTPRINTS", f64::from(CAUSTIC_FOOTPRINTS[1])));
                Kernel::new(context, "passes/caustic_disc.wgsl", "main", &overrides)
            })?,
            caustic_count: optional(caustic, &|| {
                Kernel::new(context, "passes/caustic_count.wgsl", "main", &pilot)
            })?,
            caustic_radius: optional(caustic, &|| {
                Kernel::new(context, "passes/caustic_radius.wgsl", "main", &pilot)
            })?,
            map: (caustic || diffuse).then(|| MapKernels::new(context)).transpose()?,
        })
    }

    /// All of them, in the order in which they are first dispatched.
    pub(super) fn in_order_of_use(&self) -> Vec<&Kernel> {
        let [caustic, diffuse] = &self.trace;
        let mut all: Vec<&Kernel> =
            caustic.iter().chain(self.map.iter().flat_map(MapKernels::in_order_of_use)).collect();
        all.extend(diffuse);
        all.extend(self.glint.iter().flatten());
        all.push(&self.eye);
        all.extend(&self.caustic_count);
        all.extend(&self.caustic_radius);
        all.extend(&self.caustic_disc);
        all.extend(&self.kernel_correction);
        all.extend(&self.clip_planes);
        all.extend(&self.direct);
        all.extend(self.gather.iter().flatten());
        all.extend(&self.indirect);
        all
    }
}
/// Names of a sorted map in the kernels, and of the buffers.
const SORTED: [(&str, &str); 2] = [("sorted_jotons", "sorted_jotons"), ("bucket_starts", "bucket_starts")];
const SORTED_APART: [(&str, &str); 2] =
    [("sorted_jotons", "sorted_jotons_caustic"), ("bucket_starts", "bucket_starts_caustic")];

/// Names of the list of lights that shadow rays pick from in the kernels, and of the buffers.
const SHADOW_RAYS: [(&str, &str); 2] = [("emitters", "emitters_direct"), ("scene_info", "scene_info_direct")];

/// The trees that look for emission.
pub(super) struct Glint {
    pub(super) trees: BoundKernel,
    pub(super) pilot: BoundKernel,
    /// Adds what a pixel's trees saw.
    pub(super) sum: BoundKernel,
    pub(super) mark: BoundKernel,
}

/// The kernels with their buffers.
pub(super) struct PassGraph {
    pub(super) eye: BoundKernel,
    pub(super) glint: Option<Glint>,
    pub(super) direct: Option<BoundKernel>,
    pub(super) indirect: Option<BoundKernel>,
    pub(super) kernel_correction: Option<BoundKernel>,
    pub(super) clip_planes: Option<BoundKernel>,
    pub(super) caustic_disc: Option<BoundKernel>,
    pub(super) maps: Vec<(Map, BoundKernel)>,
    pub(super) pilot: Option<[BoundKernel; 2]>,
}

impl PassGraph {
    /// Bind every kernel of a pass and of the pilot; `apart` where both sorted maps are kept.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where a buffer is missing.
    pub(super) fn new(
        context: &Context,
        kernels: &Kernels,
        shapes: &MapLayouts,
        apart: bool,
        buffers: &Buffers,
    ) -> Result<Self> {
        // where both maps are kept, the caustic one has a place of its own
        let sorted = |kind| if apart && kind == MapKind::Caustic { SORTED_APART } else { SORTED };
        let mut maps = Vec::new();
        for (kind, film, clips) in
            [(MapKind::Caustic, "film_caustic", "walls"), (MapKind::Diffuse, "film_diffuse", "clips")]
        {
            let i = kind as usize;
            if let (Some(shape), Some(trace), Some(gather), Some(map)) =
                (shapes.of(kind), &kernels.trace[i], &kernels.gather[i], &kernels.map)
            {
                let sorted = sorted(kind);
                let names = [&sorted[..], &[("film", film), ("clips", clips)]].concat();
                let gather = gather.bind(context, buffers, &names)?;
                maps.push((Map::new(context, kind, shape, trace, map, &sorted, buffers)?, gather));
            }
        }
        let optional = |k: &Option<Kernel>, names: &[(&str, &'static str)]| {
            k.as_ref().map(|k| k.bind(context, buffers, names)).transpose()
        };
        let pilot = match (&kernels.caustic_count, &kernels.caustic_radius) {
            (Some(count), Some(radius)) => Some([
                count.bind(context, buffers, &sorted(MapKind::Caustic))?,
                radius.bind(context, buffers, &[("fits", "radii")])?,
            ]),
            _ => None,
        };
        let seen = |by: &'static str| [&[("seen", by)], &SHADOW_RAYS[..]].concat();
        Ok(Self {
            eye: kernels.eye.bind(context, buffers, &SHADOW_RAYS)?,
            glint: match &kernels.glint {
                Some([glint, sum, mark]) => Some(Glint {
                    trees: glint.bind(context, buffers, &seen("fits"))?,
                    pilot: glint.bind(context, buffers, &seen("radii"))?,
                    sum: sum.bind(context, buffers, &[("seen", "fits")])?,
                    mark: mark.bind(context, buffers, &[])?,
                }),
                None => None,
            },
            direct: optional(&kernels.direct, &SHADOW_RAYS)?,
            indirect: optional(&kernels.indirect, &[&sorted(MapKind::Caustic)[..], &SHADOW_RAYS].concat())?,
            kernel_correction: optional(&kernels.kernel_correction, &[])?,
            clip_planes: optional(&kernels.clip_planes, &[])?,
            caustic_disc: optional(&kernels.caustic_disc, &sorted(MapKind::Caustic))?,
            maps,
            pilot,
        })
    }

    /// Record the gather points, and the emission that is met on the way to them.
    pub(super) fn record_eye(&self, recorder: &mut Recorder<'_>, pass_info: u32, tiles: u32) {
        recorder.dispatch_tiles(&self.eye, &[("pass_info", pass_info)], tiles);
    }

    /// Record the trees that look for emission.
    pub(super) fn record_glints(&self, recorder: &mut Recorder<'_>, glints: impl Iterator<Item = PassInfo>) {
        if let Some(Glint { trees, sum, .. }) = &self.glint {
            for info in glints {
                let at = [("pass_info", recorder.ring.push(&info))];
                recorder.dispatch(trees, &at, info.glint_count);
                recorder.dispatch(sum, &at, info.glint_count);
            }
        }
    }

    /// Record direct light at the gather points.
    pub(super) fn record_direct(&self, recorder: &mut Recorder<'_>, pass_info: u32, tiles: u32) {
        if let Some(direct) = &self.direct {
            recorder.dispatch_tiles(direct, &[("pass_info", pass_info)], tiles);
        }
    }

    /// Record the paths that go on from the gather points; where there is a caustic map, it is sorted, and `map_info` is its
    /// uniform.
    pub(super) fn record_indirect(
        &self,
        recorder: &mut Recorder<'_>,
        at: Offsets<'_>,
        tiles: u32,
        buffers: &Buffers,
    ) {
        if let Some(indirect) = &self.indirect {
            recorder.dispatch_queue(indirect, at, tiles, &buffers["queue"]);
        }
    }

    /// Record what a sorted map is for.
    pub(super) fn record_gather(
        &self,
        recorder: &mut Recorder<'_>,
        kind: MapKind,
        gather: &BoundKernel,
        at: Offsets<'_>,
        tiles: u32,
    ) {
        let measure = if kind == MapKind::Caustic { &self.caustic_disc } else { &self.kernel_correction };
        if let Some(measure) = measure {
            recorder.dispatch_tiles(measure, at, tiles);
        }
        recorder.dispatch_tiles(gather, at, tiles);
    }
}

//! Harness: single kernels on plain arrays, for the tests of kernels and of the functions that they share.

use super::context::Context;
use super::device_buffers;
use super::device_buffers::Buffers;
use super::kernel::Kernel;
use super::map::{Map, MapKernels};
use super::recorder::Recorder;
use super::ring::Ring;
use super::scene_buffers;
use super::tiles::{BINDING_BYTES, TILES_PER_DISPATCH, Tiles};
use crate::error::Result;
use crate::estimators::maps::MapKind;
use crate::film::tile_schedule::TileSchedule;
use crate::packed::PackedScene;
use crate::packed::heap::{HeapCounts, HeapLayout, SECTIONS};
use crate::packed::layout::MapInfo;
use crate::plan::Plan;
use crate::plan::buffers::{Buffer, RING_BYTES, area_points_most, area_points_wanted, map_buffers};
use crate::plan::map_layout::MapLayout;
use bytemuck::Pod;
use std::collections::HashMap;

pub use crate::packed::heap::{encode_direction, pack_normals};
pub use scene_buffers::is_small;

/// How much of a kernel is run.
#[derive(Debug, Clone, Copy)]
pub enum Work {
    /// At least this many invocations, in workgroups of 64, folded as in a render.
    Invocations(u32),
    /// The tiles of an image, one in each workgroup.
    Tiles([u32; 2]),
    /// Exactly these workgroups.
    Groups([u32; 2]),
}

/// Buffers of a few dispatches, by the names that kernels use.
pub struct Harness<'a> {
    context: &'a Context,
    buffers: Buffers,
    /// Bytes that were asked for; buffers are rounded up.
    sizes: HashMap<&'static str, usize>,
    /// Sections of the scene heap, as bytes.
    heap: HashMap<&'static str, Vec<u8>>,
    ring: Ring,
}

impl<'a> Harness<'a> {
    /// No buffers yet.
    pub fn new(context: &'a Context) -> Self {
        let mut buffers = Buffers::new();
        buffers.insert("ring", made(device_buffers::uniform(context, "ring", RING_BYTES)));
        Self::with_buffers(context, buffers)
    }

    /// Tiles are listed in their order, as many as a dispatch sees.
    fn with_buffers(context: &'a Context, mut buffers: Buffers) -> Self {
        let tiles: Vec<u32> = (0..TILES_PER_DISPATCH).collect();
        let buffer = made(device_buffers::uniform(context, "tiles", u64::from(BINDING_BYTES)));
        context.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&tiles));
        buffers.insert("tiles", buffer);
        Self { context, buffers, sizes: HashMap::new(), heap: HashMap::new(), ring: Ring::new(context) }
    }

    /// With the buffers of a scene and its plan.
    ///
    /// # Errors
    /// [`crate::Error::Capacity`] where it does not fit.
    pub fn with_scene(context: &'a Context, scene: &PackedScene, plan: &Plan) -> Result<Self> {
        let mut buffers = scene_buffers::upload(context, scene, plan)?;
        let warps = buffers["warps_caustic"].clone();
        buffers.insert("warps", warps);
        let mut harness = Self::with_buffers(context, buffers);
        harness.scene("nodes", scene.bvh.nodes());
        harness.scene("triangles", &scene.triangles);
        let normals: Vec<_> = scene.shading_normals.iter().map(|n| pack_normals(*n)).collect();
        harness.scene("normals", &normals);
        harness.scene("materials", &scene.materials);
        harness.scene("emitters", &scene.emitters);
        harness.scene("uvs", &scene.textures.uvs);
        harness.scene("textures", &scene.textures.records);
        harness.scene("texels", &scene.textures.texels);
        harness.scene("media", &scene.media.words());
        Ok(harness)
    }

    /// Create (or replace) a section of the scene heap: nodes, triangles, normals, materials, emitters, uvs, textures, texels or media.
    pub fn scene<T: Pod>(&mut self, section: &'static str, content: &[T]) {
        self.heap.insert(section, bytemuck::cast_slice(content).to_vec());
        let bytes_of = |name: &str| self.heap.get(name).map_or(&[][..], |bytes: &Vec<u8>| &bytes[..]);
        let counts = HeapCounts::of_bytes(|name| bytes_of(name).len());
        let heap = SECTIONS.map(|(name, _)| bytes_of(name)).concat();
        self.storage("heap", &heap);
        self.uniform("scene_info", &HeapLayout::new(&counts).info(0));
    }

    /// List the tiles of an image, those that rest least first.
    pub fn set_tile_schedule(&mut self, schedule: &TileSchedule) {
        let (_, words) = Tiles::new(schedule.clone());
        self.context.queue.write_buffer(&self.buffers["tiles"], 0, bytemuck::cast_slice(&words));
    }

    /// Create (or replace) a storage buffer.
    pub fn storage<T: Pod>(&mut self, name: &'static str, content: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        let buffer = made(device_buffers::storage(self.context, name, bytes.len() as u64));
        self.context.queue.write_buffer(&buffer, 0, bytes);
        self.buffers.insert(name, buffer);
        self.sizes.insert(name, bytes.len());
    }

    /// Create (or replace) a uniform buffer that is bound as a whole.
    pub fn uniform<T: Pod>(&mut self, name: &'static str, content: &T) {
        let bytes = bytemuck::bytes_of(content);
        let buffer = made(device_buffers::uniform(self.context, name, bytes.len() as u64));
        self.context.queue.write_buffer(&buffer, 0, bytes);
        self.buffers.insert(name, buffer);
    }

    /// Run a kernel. `renamed` maps names in the kernel to buffers; `per_pass` holds the uniforms that differ from
    /// dispatch to dispatch (pass_info, map_info, scan_info, sort_info).
    ///
    /// # Errors
    /// [`crate::Error::Device`] where a buffer is missing or the device fails.
    pub fn run(
        &mut self,
        kernel: &Kernel,
        renamed: &[(&str, &'static str)],
        per_pass: &[(&str, &[u8])],
        work: Work,
    ) -> Result<()> {
        let step = kernel.bind(self.context, &self.buffers, renamed)?;
        let mut recorder = Recorder::new(self.context, &mut self.ring, None);
        let at: Vec<(&str, u32)> =
            per_pass.iter().map(|(name, bytes)| (*name, recorder.ring.push_bytes(bytes))).collect();
        match work {
            Work::Invocations(n) => recorder.dispatch(&step, &at, n),
            Work::Tiles(size) => {
                recorder.dispatch_tiles(&step, &at, TileSchedule::none(size).exponents().len() as u32)
            }
            Work::Groups(groups) => recorder.dispatch_groups(&step, &at, groups),
        }
        recorder.submit(self.context, &self.buffers["ring"]);
        self.context.wait()
    }

    /// Sort the jotons of `lanes` (buffers `lanes` and `jotons` are there) by the host code that a render uses, without
    /// tracing. Creates and fills lane_starts, bucket_starts, sorted_jotons and the buffers between.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails.
    pub fn sort_map(&mut self, info: &MapInfo) -> Result<()> {
        let shape = MapLayout {
            emitted: info.emitted,
            lanes: info.lanes,
            lane_capacity: info.lane_capacity,
            dispatches: 0,
        };
        for Buffer { name, bytes, .. } in map_buffers(&[shape], &self.context.machine()) {
            if !self.buffers.contains_key(name) {
                // a pattern that is neither zero nor a valid index shows what was never written
                self.storage(name, &vec![PATTERN; bytes.div_ceil(4) as usize]);
            }
        }
        self.storage("status", &[0u32; crate::packed::layout::status::SLOTS as usize]);
        let nothing = Kernel::from_source(
            self.context,
            "nothing",
            "@compute @workgroup_size(64) fn main() {}",
            "main",
            &[],
        )?;
        let kernels = MapKernels::new(self.context)?;
        let names = [("sorted_jotons", "sorted_jotons"), ("bucket_starts", "bucket_starts")];
        let map = Map::new(self.context, MapKind::Diffuse, shape, &nothing, &kernels, &names, &self.buffers)?;
        let mut recorder = Recorder::new(self.context, &mut self.ring, None);
        map.record(&mut recorder, 0, info);
        recorder.submit(self.context, &self.buffers["ring"]);
        self.context.wait()
    }

    /// Contents of a storage buffer.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the copy fails.
    pub fn read<T: Pod>(&self, name: &str) -> Result<Vec<T>> {
        let mut bytes = self.context.read(&mut None, &[&self.buffers[name]])?.remove(0);
        bytes.truncate(self.sizes.get(name).copied().unwrap_or(bytes.len()));
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}

/// A buffer of a test.
///
/// # Panics
/// Where there is no memory for it.
fn made(buffer: Result<wgpu::Buffer>) -> wgpu::Buffer {
    buffer.unwrap_or_else(|e| panic!("{e}"))
}

/// What outputs hold before a kernel writes them.
pub const PATTERN: u32 = 0xdead_beef;

/// The uniform of a path filter.
pub fn path_filter(paths: &crate::film::paths::LightPaths) -> crate::packed::layout::PathFilter {
    super::scene_buffers::path_filter(paths)
}

impl Harness<'_> {
    /// Scatter area points on a scene's diffuse surfaces for discs of this radius; fills the buffers area_points and
    /// area_starts and says in `info` how they are cut.
    pub fn area_points(&mut self, scene: &PackedScene, radius: f64, seed: u32, info: &mut MapInfo) {
        let count = area_points_wanted(scene, radius, area_points_most(None));
        let grid = super::area_samples::build(scene, radius, count, seed);
        self.storage("area_points", &grid.points);
        self.storage("area_starts", &grid.starts);
        info.area_each = grid.each;
        info.area_cells_per_unit = grid.cells_per_unit;
        info.area_row_mask = grid.row_mask;
        info.area_columns = grid.columns;
    }
}

//! The shared functions of the kernels, run over samples.

use crate::common::{Row, Snippet, map_info, pass_info};
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::Harness;
use joton::packed::{Guide, PackedMaterial, PackedScene};
use joton::plan::{Guides, Plan, Settings};
use std::sync::Arc;

const IMPORTS: &[&str] = &[
    "scene/features.wgsl",
    "scene/scene.wgsl",
    "shading/bsdf.wgsl",
    "lights/emit.wgsl",
    "camera/camera.wgsl",
];
const DECLARATIONS: &str = "override CAUSTIC: bool = false;
    @group(1) @binding(0) var<uniform> map_info: MapInfo;
    @group(1) @binding(1) var<uniform> targets: array<Target, 16>;\n";

/// A scene on the device, for snippets that use the functions of the shaders.
pub struct Device<'a> {
    context: &'a Context,
    harness: Harness<'a>,
    pass: joton::packed::layout::PassInfo,
}

impl<'a> Device<'a> {
    /// Upload a scene.
    pub fn new(context: &'a Context, scene: &PackedScene, seed: u32) -> Self {
        Self::guided(context, scene, seed, &Guide::default())
    }

    /// Upload a scene whose caustic jotons a guide steers.
    pub fn guided(context: &'a Context, scene: &PackedScene, seed: u32, guide: &Guide) -> Self {
        let mut plan = Plan::new(scene, Settings::default());
        plan.guides = Arc::new(Guides { caustic: guide.clone(), ..Guides::default() });
        let mut harness = Harness::with_scene(context, scene, &plan).unwrap_or_else(|e| panic!("{e}"));
        harness.scene("emitters", guide.emitters(&scene.emitters));
        let mut pass = pass_info();
        pass.camera = scene.camera_info();
        pass.set_image(scene.size);
        pass.emitters = scene.emitters.len() as u32;
        pass.targets = scene.targets.len() as u32;
        pass.seed = seed;
        Self { context, harness, pass }
    }

    /// Put other materials in place of the scene's.
    pub fn materials(&mut self, materials: &[PackedMaterial]) {
        self.harness.scene("materials", materials);
    }

    /// Run a snippet over inputs; `emitted` jotons a pass, of the caustic map or the diffuse one.
    pub fn run<const O: usize>(
        &mut self,
        code: &str,
        (caustic, emitted): (bool, u32),
        inputs: &[[Row; 1]],
    ) -> Vec<[Row; O]> {
        let overrides: &[(&str, f64)] = &[("CAUSTIC", f64::from(u8::from(caustic)))];
        let snippet = Snippet { imports: IMPORTS, declarations: DECLARATIONS, code, overrides };
        let mut map = map_info();
        map.emitted = emitted;
        let per_pass: [(&str, &[u8]); 2] =
            [("pass_info", bytemuck::bytes_of(&self.pass)), ("map_info", bytemuck::bytes_of(&map))];
        snippet.run_in(self.context, &mut self.harness, &per_pass, inputs)
    }
}

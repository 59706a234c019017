//! What the tests of the device side share: one open device, snippets of WGSL run over arrays, small scenes.
#![allow(dead_code, reason = "each test binary uses a part")]

pub mod renders;
pub mod scenes;
pub mod twins;
pub mod world;

use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::backend::gpu::{Context, Kernel, Variant, link_source};
use joton::packed::layout::{MapInfo, PassInfo, PathFilter};
use std::io::Write;
use std::sync::OnceLock;

/// Set to 1 to let tests that need a device pass without one.
const OPT_OUT: &str = "JOTON_TEST_NO_GPU";

/// The device, opened once; none only where the environment says that there shall be none.
///
/// # Panics
/// Where there is no device: a suite that skips silently proves nothing.
pub fn device() -> Option<&'static Context> {
    static DEVICE: OnceLock<Option<Context>> = OnceLock::new();
    let found = DEVICE.get_or_init(|| {
        if std::env::var(OPT_OUT).is_ok_and(|v| v == "1") {
            return None;
        }
        match Context::open(None) {
            Ok(context) => Some(context),
            Err(e) => panic!(
                "the tests of the device side need a Vulkan, Metal or DX12 device: {e}\n\
                 on Debian: apt-get install mesa-vulkan-drivers libvulkan1; to leave them out: {OPT_OUT}=1"
            ),
        }
    });
    if found.is_none() {
        let thread = std::thread::current();
        // past the capture of a test's output: what is left out must be seen
        writeln!(std::io::stderr(), "skipped: {} ({OPT_OUT}=1)", thread.name().unwrap_or("a test")).ok();
    }
    found.as_ref()
}

/// The device, or return from a test that was opted out of.
#[macro_export]
macro_rules! device_or_return {
    () => {
        match $crate::common::device() {
            Some(context) => context,
            None => return,
        }
    };
}

/// Compile a kernel of joton.
pub fn kernel(context: &Context, path: &str, entry: &str, overrides: &[(&str, f64)]) -> Kernel {
    Kernel::new(context, path, entry, overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// A few words: one invocation's input or output, four to a row.
pub type Row = [u32; 4];

/// Bits of four numbers.
pub fn row(v: [f32; 4]) -> Row {
    v.map(f32::to_bits)
}

/// Bits of a vector and a number.
pub fn row3(v: impl Into<[f32; 3]>, w: f32) -> Row {
    let [x, y, z] = v.into();
    row([x, y, z, w])
}

/// Four numbers from their bits.
pub fn floats(r: Row) -> [f32; 4] {
    r.map(f32::from_bits)
}

/// The vector in the first three words.
pub fn vec3(r: Row) -> glam::Vec3 {
    glam::Vec3::from_slice(&floats(r)[..3])
}

/// The vector in the first three words, in f64.
pub fn dvec3(r: Row) -> glam::DVec3 {
    vec3(r).as_dvec3()
}

/// A piece of WGSL that is run once for each input. Its code sees `in_u(k)`, `in_f(k)` (row k of the input) and
/// `out_u(k, v)`, `out_f(k, v)`; `number` is the invocation.
pub struct Snippet<'a> {
    /// Files under shaders/ that it uses.
    pub imports: &'a [&'a str],
    /// Declarations at module level.
    pub declarations: &'a str,
    /// Statements.
    pub code: &'a str,
    /// Values of overrides.
    pub overrides: &'a [(&'a str, f64)],
}

impl Snippet<'_> {
    /// A snippet without declarations of its own.
    pub fn new<'a>(imports: &'a [&'a str], code: &'a str) -> Snippet<'a> {
        Snippet { imports, declarations: "", code, overrides: &[] }
    }

    /// Run it without other buffers.
    pub fn run<const I: usize, const O: usize>(
        &self,
        context: &Context,
        inputs: &[[Row; I]],
    ) -> Vec<[Row; O]> {
        self.run_in(context, &mut Harness::new(context), &[], inputs)
    }

    /// Run it over inputs beside the buffers of a harness.
    pub fn run_in<const I: usize, const O: usize>(
        &self,
        context: &Context,
        harness: &mut Harness<'_>,
        per_pass: &[(&str, &[u8])],
        inputs: &[[Row; I]],
    ) -> Vec<[Row; O]> {
        let imports: String = self.imports.iter().map(|i| format!("// import: {i}\n")).collect();
        let text = format!(
            "{imports}// import: dispatch/index.wgsl\n\
             @group(3) @binding(0) var<storage, read> snippet_in: array<vec4<u32>>;\n\
             @group(3) @binding(1) var<storage, read_write> snippet_out: array<vec4<u32>>;\n\
             var<private> number: u32;\n\
             fn in_u(k: u32) -> vec4<u32> {{ return snippet_in[number * {I}u + k]; }}\n\
             fn in_f(k: u32) -> vec4<f32> {{ return bitcast<vec4<f32>>(in_u(k)); }}\n\
             fn out_u(k: u32, v: vec4<u32>) {{ snippet_out[number * {O}u + k] = v; }}\n\
             fn out_f(k: u32, v: vec4<f32>) {{ out_u(k, bitcast<vec4<u32>>(v)); }}\n\
             {}\n\
             @compute @workgroup_size(64)\n\
             fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{\n\
             number = linear_index(id, groups);\n\
             if number >= {}u {{ return; }}\n\
             {}\n}}\n",
            self.declarations,
            inputs.len(),
            self.code,
        );
        let linked = link_source(&text, Variant::default()).unwrap_or_else(|e| panic!("{e}"));
        let kernel = Kernel::from_source(context, "snippet", &linked, "main", self.overrides)
            .unwrap_or_else(|e| panic!("{e}"));
        harness.storage("snippet_in", inputs.as_flattened());
        harness.storage("snippet_out", &vec![PATTERN; inputs.len() * O * 4]);
        harness
            .run(&kernel, &[], per_pass, Work::Invocations(inputs.len() as u32))
            .unwrap_or_else(|e| panic!("{e}"));
        let out: Vec<Row> = harness.read("snippet_out").unwrap_or_else(|e| panic!("{e}"));
        let out: Vec<[Row; O]> = out.chunks_exact(O).map(|c| std::array::from_fn(|k| c[k])).collect();
        assert_eq!(out.len(), inputs.len(), "one output for each input");
        assert!(
            out.iter().flatten().flatten().any(|&w| w != PATTERN) || out.is_empty(),
            "the snippet wrote nothing"
        );
        out
    }
}

/// Numbers in [0, 1) for test inputs, by address.
pub fn random(stream: u32, number: usize) -> [f32; 4] {
    joton::sampling::rng::random4(0x7e57, stream, number as u32, 0)
}

/// A direction uniform on the sphere.
pub fn random_direction(stream: u32, number: usize) -> glam::Vec3 {
    let [a, b, ..] = random(stream, number);
    let (z, phi) = (1.0 - 2.0 * f64::from(a), std::f64::consts::TAU * f64::from(b));
    let r = (1.0 - z * z).max(0.0).sqrt();
    glam::DVec3::new(r * phi.cos(), r * phi.sin(), z).normalize().as_vec3()
}

/// A uniform of zeros but for what a test sets.
pub fn pass_info() -> PassInfo {
    // the bands are red, green and blue
    let [red, green, blue] = [glam::Vec4::X, glam::Vec4::Y, glam::Vec4::Z];
    let [texel_red, texel_green, texel_blue] = [red, green, blue];
    let bands =
        PassInfo { red, green, blue, texel_red, texel_green, texel_blue, ..bytemuck::Zeroable::zeroed() };
    PassInfo { light_candidates: 1, ..bands }
}

/// A uniform of zeros but for what a test sets.
pub fn map_info() -> MapInfo {
    bytemuck::Zeroable::zeroed()
}

/// The table of an expression, as the device gets it.
pub fn path_filter(expression: &str) -> PathFilter {
    joton::backend::gpu::harness::path_filter(
        &joton::film::paths::LightPaths::parse(expression).unwrap_or_else(|e| panic!("{e}")),
    )
}

/// A normal as jotons keep it: signed 8 bits a component.
pub fn normal24(n: glam::Vec3) -> u32 {
    let [x, y, z] = n.to_array().map(|c| u32::from((c * 127.0).round() as i8 as u8));
    x | y << 8 | z << 16
}

/// The frame of sampling/sampling.wgsl (Duff et al. 2017): x and y of z = n.
pub fn frame(n: glam::Vec3) -> [glam::Vec3; 2] {
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    [glam::Vec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x), glam::Vec3::new(b, s + n.y * n.y * a, -n.y)]
}

//! Structs that Rust and WGSL share: held against naga's offsets, and read back on the device.

mod common;

use common::{Row, Snippet};
use joton::packed::CameraInfo;
use joton::packed::gpu_struct::GpuStruct;
use joton::packed::layout;
use naga::proc::Layouter;

/// A struct as one side sees it.
#[derive(Debug, Clone, PartialEq)]
struct Shape {
    name: String,
    /// Name and offset of each field.
    fields: Vec<(String, usize)>,
    /// Bytes of one in an array.
    size: usize,
}

fn on_the_host<T: GpuStruct>() -> Shape {
    let fields = T::offsets().into_iter().map(|(name, at)| (name.to_string(), at)).collect();
    Shape { name: T::NAME.to_string(), fields, size: size_of::<T>() }
}

/// What naga makes of a struct; none where it is not declared.
fn on_the_device(wgsl: &str, name: &str) -> Option<Shape> {
    let module = naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|e| panic!("{}", e.emit_to_string(wgsl)));
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).expect("every type has a layout");
    let (handle, ty) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name))?;
    let naga::TypeInner::Struct { members, span } = &ty.inner else { return None };
    let fields = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect();
    assert_eq!(layouter[handle].to_stride(), *span, "an array of {name} has no gaps");
    Some(Shape { name: name.to_string(), fields, size: *span as usize })
}

/// Every struct of layout and pack, once.
macro_rules! for_every_struct {
    ($f:ident) => {
        $f!(
            joton::packed::CameraInfo,
            layout::PassInfo,
            layout::MapInfo,
            layout::GatherPoint,
            layout::Joton,
            layout::PathState,
            layout::LaneTally,
            layout::ScanInfo,
            layout::SortInfo,
            layout::AreaPoint,
            layout::Fit,
            layout::Clip,
            layout::PathFilter,
            joton::packed::PackedTriangle,
            joton::packed::PackedMaterial,
            joton::packed::PackedEmitter,
            joton::packed::PackedTexture,
            joton::packed::Target,
            joton::packed::SceneInfo,
        )
    };
}

#[test]
fn rust_and_naga_agree_on_every_offset() {
    let wgsl = joton::packed::wgsl::declarations();
    let mut compared = Vec::new();
    macro_rules! compare {
        ($($ty:ty,)*) => {
            $(
                let host = on_the_host::<$ty>();
                assert_eq!(on_the_device(&wgsl, &host.name).as_ref(), Some(&host));
                compared.push(host.name);
            )*
        };
    }
    for_every_struct!(compare);
    // a struct that is added to the declarations must be added here
    let declared: Vec<&str> =
        wgsl.lines().filter_map(|l| l.strip_prefix("struct ")?.strip_suffix(" {")).collect();
    assert_eq!(declared, compared);
}

/// The comparison sees a field at another offset, another name, another order and another size.
#[test]
fn a_wrong_struct_is_found() {
    let host = on_the_host::<layout::Joton>();
    let right = "struct Joton { position: vec3<f32>, normal_state: u32, flux: vec3<f32>, wi: u32, }";
    assert_eq!(on_the_device(right, "Joton").as_ref(), Some(&host));
    for wrong in [
        "struct Joton { normal_state: u32, position: vec3<f32>, flux: vec3<f32>, wi: u32, }",
        "struct Joton { position: vec3<f32>, normal_state: u32, flux: vec3<f32>, wo: u32, }",
        "struct Joton { position: vec3<f32>, flux: vec3<f32>, normal_state: u32, wi: u32, }",
        "struct Joton { position: vec3<f32>, normal_state: u32, flux: vec3<f32>, }",
        "struct Joton { position: vec3<f32>, normal_state: u32, flux: vec4<f32>, wi: u32, }",
    ] {
        assert_ne!(on_the_device(wrong, "Joton").as_ref(), Some(&host), "{wrong}");
    }
    assert_eq!(on_the_device(right, "Photon"), None);
}

/// Words of a field: WGSL that writes its words to out_u, its number of words.
fn field_words(ty: &str, field: &str) -> (String, usize) {
    let bits = |v: &str| format!("bitcast<u32>({v})");
    match ty {
        "f32" => (format!("put({});", bits(field)), 1),
        "u32" => (format!("put({field});"), 1),
        "Vec3" | "Bands" => {
            (["x", "y", "z"].map(|c| format!("put({});", bits(&format!("{field}.{c}")))).concat(), 3)
        }
        "Vec4" => {
            (["x", "y", "z", "w"].map(|c| format!("put({});", bits(&format!("{field}.{c}")))).concat(), 4)
        }
        "Table" => (
            format!(
                "for (var k = 0u; k < 16u; k += 1u) {{ put({field}[k].x); put({field}[k].y); put({field}[k].z); put({field}[k].w); }}"
            ),
            64,
        ),
        "CameraInfo" => {
            let inner = CameraInfo::offsets().into_iter().zip(CameraInfo::TYPES);
            let all: Vec<_> =
                inner.map(|((name, _), ty)| field_words(ty, &format!("{field}.{name}"))).collect();
            (all.iter().map(|(put, _)| put.as_str()).collect(), all.iter().map(|(_, count)| count).sum())
        }
        _ => panic!("a type that this test does not know: {ty}"),
    }
}

/// A buffer of 0, 1, 2, … read field by field on the device gives the words that Rust's offsets say, in storage buffers
/// (second element of an array, so that the stride counts) as in uniforms.
#[test]
fn fields_are_read_where_rust_wrote_them() {
    let context = device_or_return!();
    macro_rules! read_back {
        ($($ty:ty,)*) => {
            $(read_struct(context, <$ty>::NAME, <$ty>::WGSL, &<$ty>::offsets(), size_of::<$ty>());)*
        };
    }
    for_every_struct!(read_back);
}

fn read_struct(
    context: &joton::backend::gpu::Context,
    name: &str,
    wgsl: &str,
    offsets: &[(&'static str, usize)],
    size: usize,
) {
    let types: Vec<(&str, &str)> =
        wgsl.lines().filter_map(|l| l.trim().strip_suffix(',')?.split_once(": ")).collect();
    assert_eq!(types.len(), offsets.len(), "{name}");
    let words = size / 4;
    let mut expected = Vec::new();
    let mut code = String::from("let s = both[1]; let t = one;\n");
    for from in ["s", "t"] {
        for ((field, ty), (_, offset)) in types.iter().zip(offsets) {
            let (put, count) = field_words(ty, &format!("{from}.{field}"));
            code.push_str(&put);
            let first = offset / 4 + if from == "s" { words } else { 0 };
            expected.extend((first..first + count).map(|w| w as u32));
        }
    }
    let declarations = format!(
        "@group(0) @binding(0) var<storage, read> both: array<{name}>;\n\
         @group(0) @binding(1) var<uniform> one: {name};\n\
         @group(0) @binding(2) var<storage, read_write> found: array<u32>;\n\
         var<private> at: u32;\n\
         fn put(word: u32) {{ found[at] = word; at += 1u; }}\n"
    );
    code.push_str("out_u(0u, vec4(at));");
    let mut harness = joton::backend::gpu::harness::Harness::new(context);
    harness.storage("both", &(0..2 * words as u32).collect::<Vec<_>>());
    // PathFilter is the largest
    let mut one = [0u32; 128];
    for (i, w) in one.iter_mut().enumerate() {
        *w = i as u32;
    }
    harness.uniform("one", &one);
    harness.storage("found", &vec![joton::backend::gpu::harness::PATTERN; expected.len()]);
    let snippet = Snippet { imports: &[], declarations: &declarations, code: &code, overrides: &[] };
    let [count]: [Row; 1] = snippet.run_in(context, &mut harness, &[], &[[[0; 4]]])[0];
    assert_eq!(count[0] as usize, expected.len(), "{name}");
    let found: Vec<u32> = harness.read("found").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(found, expected, "{name}");
}

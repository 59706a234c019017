// The scene where it fits into uniform buffers, which are read faster. See scene.wgsl.

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<uniform> nodes: array<vec4<u32>, SMALL_NODE_WORDS>;
@group(0) @binding(2) var<uniform> triangles: array<PackedTriangle, SMALL_TRIANGLES>;
@group(0) @binding(3) var<storage, read> shading_normals: array<vec4<u32>>;
@group(0) @binding(4) var<uniform> materials: array<PackedMaterial, SMALL_MATERIALS>;
@group(0) @binding(5) var<uniform> emitters: array<PackedEmitter, SMALL_EMITTERS>;

// The scene, as every tracing kernel binds it.

@group(0) @binding(0) var<uniform> pass_info: PassInfo;
@group(0) @binding(1) var<storage, read> nodes: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> triangles: array<PackedTriangle>;
@group(0) @binding(3) var<storage, read> shading_normals: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> materials: array<PackedMaterial>;
@group(0) @binding(5) var<storage, read> emitters: array<PackedEmitter>;

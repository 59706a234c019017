// Dispatches over 65,535 workgroups are folded into two dimensions; workgroups have 64 invocations.

const WORKGROUP: u32 = 64u;

// The layer of this invocation: 0, since dispatches have one layer, but no compiler knows that.
var<private> layer: u32;

fn linear_index(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    layer = id.z;
    return id.y * groups.x * WORKGROUP + id.x;
}

// A number of a uniform as each invocation's own; call linear_index first. Mesa's software device clones and compiles a
// kernel that branches on uniforms alone at every dispatch, and keeps the clones: no branch and no loop does. A test looks.
fn own(x: u32) -> u32 {
    return x | layer;
}

const NO_PIXEL: u32 = 0xffffffffu;

// The pixel of an invocation where a workgroup is a tile of 8 × 8 pixels, in Morton's order: invocations that run in step
// look at neighbours. NO_PIXEL beyond the image.
fn tiled_pixel(index: u32, width: u32, height: u32) -> u32 {
    let tiles = (width + TILE - 1u) / TILE;
    let tile = index / WORKGROUP;
    let i = index % WORKGROUP;
    let x = tile % tiles * TILE + (i & 1u | (i >> 1u) & 2u | (i >> 2u) & 4u);
    let y = tile / tiles * TILE + ((i >> 1u) & 1u | (i >> 2u) & 2u | (i >> 3u) & 4u);
    return select(NO_PIXEL, y * width + x, x < width && y < height);
}

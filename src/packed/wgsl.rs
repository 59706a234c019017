//! All that Rust declares for the kernels, as WGSL: structs and constants.

use crate::packed::constants::*;
use crate::packed::gpu_struct::{ALIASES, GpuStruct};
use crate::packed::layout::*;
use crate::packed::{
    CameraInfo, PackedEmitter, PackedMaterial, PackedTexture, PackedTriangle, SceneInfo, Target,
};
use crate::sampling::distributions::{CIRCLE_COSINE, CIRCLE_SINE};

/// Every struct and constant that kernels may use, as WGSL.
pub fn declarations() -> String {
    let mut s = ALIASES.to_string() + &crate::spectrum::wgsl();
    for declaration in [
        CameraInfo::WGSL,
        PassInfo::WGSL,
        MapInfo::WGSL,
        GatherPoint::WGSL,
        Joton::WGSL,
        PathState::WGSL,
        LaneTally::WGSL,
        ScanInfo::WGSL,
        SortInfo::WGSL,
        AreaPoint::WGSL,
        Fit::WGSL,
        Clip::WGSL,
        PathFilter::WGSL,
        PackedTriangle::WGSL,
        PackedMaterial::WGSL,
        PackedEmitter::WGSL,
        PackedTexture::WGSL,
        Target::WGSL,
        SceneInfo::WGSL,
    ] {
        s.push_str(declaration);
    }
    s + &constants()
}

/// Constants that the kernels use, as WGSL.
fn constants() -> String {
    use crate::packed::accel::{EDGE_ROUNDING, EDGE_SLACK, EDGE_SLACK_MAX, END_ROUNDING, ONE_PLACE};
    use crate::packed::{
        BODY_SHIFT, CLEAR, CUT, EmitterKind, FAR, LAMP, MAX_WARPS, MaterialFlags, NESTED, NO_EMITTER,
        SAME_INDEX, SMOOTH, TEXTURED, TextureFlags, VISIBLE_CELL_FACTORS, VISIBLE_CELL_WORDS, WARP_BINS,
        WARP_WORDS, rank,
    };
    use std::fmt::Write;
    let mut s = String::new();
    for (name, value) in shared() {
        match value {
            Value::Unsigned(x) => writeln!(s, "const {name}: u32 = {x}u;"),
            Value::Float(x) => writeln!(s, "const {name}: f32 = {x:?};"),
        }
        .expect("writing to a string");
    }
    let mut u =
        |name: &str, value: u32| writeln!(s, "const {name}: u32 = {value}u;").expect("writing to a string");
    for (name, value) in MaterialFlags::NAMED.into_iter().chain(EmitterKind::NAMED).chain(TextureFlags::NAMED)
    {
        u(name, value);
    }
    u("NO_EMITTER", NO_EMITTER);
    u("SMOOTH", SMOOTH);
    u("CLEAR", CLEAR);
    u("LAMP", LAMP);
    u("TEXTURED", TEXTURED);
    u("CUT", CUT);
    u("NESTED", NESTED);
    u("BODY_SHIFT", BODY_SHIFT);
    u("RANK_CLEAR_FRONT", rank::CLEAR_FRONT);
    u("RANK_CLEAR_BACK", rank::CLEAR_BACK);
    u("RANK_BACK", rank::BACK);
    u("RANK_FRONT", rank::FRONT);
    u("RANK_LAMP", rank::LAMP);
    u("WARP_BINS", WARP_BINS as u32);
    u("WARP_VECTORS", (WARP_WORDS / 4) as u32);
    u("WARPS_VECTORS", (MAX_WARPS * WARP_WORDS / 4) as u32);
    u("VISIBLE_CELL_VECTORS", (VISIBLE_CELL_WORDS / 4) as u32);
    u("VISIBLE_CELL_FACTOR_X", VISIBLE_CELL_FACTORS[0]);
    u("VISIBLE_CELL_FACTOR_Y", VISIBLE_CELL_FACTORS[1]);
    u("VISIBLE_CELL_FACTOR_Z", VISIBLE_CELL_FACTORS[2]);
    u("TILE", TILE);
    u("STATUS_UNFINISHED", status::UNFINISHED);
    u("STATUS_LANE_STORED_MAX", status::LANE_STORED_MAX);
    u("STATUS_LOOP_CUT", status::LOOP_CUT);
    u("STATUS_RAYS", status::RAYS);
    u("STATUS_TRUNCATED", status::TRUNCATED);
    u("STATUS_RAYS_HIGH", status::RAYS_HIGH);
    u("STATUS_TRAVERSAL_CUT", status::TRAVERSAL_CUT);
    u("STATUS_SHADOW_RAYS_SAVED", status::SHADOW_RAYS_SAVED);
    u("STATUS_SHADOW_RAYS_SAVED_HIGH", status::SHADOW_RAYS_SAVED_HIGH);
    u("ROW_FACTOR_Y", ROW_FACTORS[0]);
    u("ROW_FACTOR_Z", ROW_FACTORS[1]);
    u("TILE_MASK", (1 << TILE_BITS) - 1);
    u("PATH_START", crate::film::paths::LightPaths::START);
    u("PATH_DEAD", crate::film::paths::DEAD);
    let mut f = |name: &str, value: f32| {
        writeln!(s, "const {name}: f32 = {value:?};").expect("writing to a string");
    };
    f("ONE_PLACE", ONE_PLACE);
    f("EDGE_SLACK", EDGE_SLACK);
    f("EDGE_ROUNDING", EDGE_ROUNDING);
    f("EDGE_SLACK_MAX", EDGE_SLACK_MAX);
    f("END_ROUNDING", END_ROUNDING);
    f("FAR", FAR);
    f("SAME_INDEX", SAME_INDEX);
    let mut v = |name: &str, [x, y, z, w]: [f32; 4]| {
        writeln!(s, "const {name} = Vec4({x:?}, {y:?}, {z:?}, {w:?});").expect("writing to a string");
    };
    v("CIRCLE_SINE", CIRCLE_SINE);
    for (j, row) in GGX_LOST.into_iter().enumerate() {
        v(&format!("GGX_LOST_{j}"), row);
    }
    for (j, row) in SHEEN_ALBEDO.into_iter().enumerate() {
        v(&format!("SHEEN_ALBEDO_{j}"), row);
    }
    v("CIRCLE_COSINE", CIRCLE_COSINE);
    s
}

//! Addresses of random numbers: one number for each purpose, so that no two draws share a sequence.
//!
//! `STREAM_*` name Sobol sequences ([`crate::sampling::rng::sequence_seed`]); `DIMENSION_*` are the first of 2^16 dimensions of
//! [`crate::sampling::rng::random4`], counted up by the events of a path.

/// Place in the pixel; one sequence a pixel, continued over passes.
pub(super) const STREAM_JITTER: u32 = 0;
/// Emitter and place of a shadow ray; one sequence a pixel.
pub(super) const STREAM_LIGHT: u32 = 1;
/// Emitter and start place of caustic jotons; one sequence for the whole render.
pub(super) const STREAM_CAUSTIC_PLACE: u32 = 2;
/// Direction of caustic jotons.
pub(super) const STREAM_CAUSTIC_DIRECTION: u32 = 3;
/// Emitter and start place of diffuse jotons.
pub(super) const STREAM_DIFFUSE_PLACE: u32 = 4;
/// Direction of diffuse jotons.
pub(super) const STREAM_DIFFUSE_DIRECTION: u32 = 5;
/// Shift of the lattice of area points.
pub(super) const STREAM_AREA: u32 = 6;
/// First two events of the camera's specular chain; one sequence a pixel.
pub(super) const STREAM_CHOICE: u32 = 7;
/// Place in the pixel of a glint's chains.
pub(super) const STREAM_GLINT_JITTER: u32 = 8;
/// First direction of the paths that go on; one sequence a tile of pixels.
pub(super) const STREAM_INDIRECT: u32 = 9;
/// Emitter and place of the shadow ray at their first surface, likewise.
pub(super) const STREAM_INDIRECT_LIGHT: u32 = 10;
/// The band that a path is transmitted in, one number a path: eye paths, trees, paths that go on, jotons of each map, and those of the
/// path tracer.
pub(super) const STREAM_EYE_BAND: u32 = 11;
/// See [`STREAM_EYE_BAND`].
pub(super) const STREAM_GLINT_BAND: u32 = 12;
/// See [`STREAM_EYE_BAND`].
pub(super) const STREAM_INDIRECT_BAND: u32 = 13;
/// See [`STREAM_EYE_BAND`].
pub(super) const STREAM_CAUSTIC_BAND: u32 = 14;
/// See [`STREAM_EYE_BAND`].
pub(super) const STREAM_DIFFUSE_BAND: u32 = 15;
/// See [`STREAM_EYE_BAND`].
pub(super) const STREAM_PATH_BAND: u32 = 16;

/// Emitter and place of a shadow ray at a vertex of an eye path whose lobe is followed.
pub(super) const STREAM_FOLLOWED_LIGHT: u32 = 17;

/// Hard limit of a path's length: the dimensions of a purpose. The roulette ends paths long before.
pub(super) const EVENTS_MAX: u32 = 1 << 16;

/// Events of the camera's specular chain.
pub(super) const DIMENSION_EYE: u32 = 1 << 16;
/// BSDF samples at glossy gather points.
pub(super) const DIMENSION_BSDF: u32 = 2 << 16;
/// Events of a caustic joton.
pub(super) const DIMENSION_CAUSTIC: u32 = 3 << 16;
/// Events of a diffuse joton.
pub(super) const DIMENSION_DIFFUSE: u32 = 4 << 16;
/// The path tracer's events, four draws each.
pub(super) const DIMENSION_PATH: u32 = 5 << 16;
/// Events of a glint's chains.
pub(super) const DIMENSION_GLINT: u32 = 6 << 16;
/// Which of the jotons that the camera does not look at are stored.
pub(super) const DIMENSION_UNSEEN: u32 = 7 << 16;
/// Events of a path that goes on, some draws each.
pub(super) const DIMENSION_INDIRECT: u32 = 8 << 16;
/// Light samples at its surfaces.
pub(super) const DIMENSION_INDIRECT_LIGHT: u32 = 9 << 16;
/// Which of the light samples at a vertex whose lobe is followed gets the shadow ray.
pub(super) const DIMENSION_FOLLOWED: u32 = 10 << 16;

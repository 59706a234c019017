//! Optics: what a ray does on the host. Emission, surfaces, scattering; apart from the kernels, so that each can catch the
//! other's mistakes. The CPU backend renders with it, the plan learns with it.

pub mod bsdf;
pub(crate) mod cone;
pub(crate) mod emit;
pub(crate) mod light;
pub(crate) mod odds;
pub(crate) mod ray;
pub mod reservoir;
pub mod sampling;

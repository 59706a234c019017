//! Optics: what a ray does on the host. Emission, surfaces, scattering; apart from the kernels, so that each can catch the
//! other's mistakes. The CPU backend renders with it, the plan learns with it.

pub mod lights;
pub(crate) mod media;
pub(crate) mod ray;
pub mod shading;

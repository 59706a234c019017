//! Scenes whose light is known in closed form, on the CPU backend, on a device and, where it can see the light, on the
//! path tracer. The formulas are those of docs/EQUATIONS.md, "Closed forms"; a test names its own as [A1].
//!
//! Scenes are built in code and are small. Every claim names its tolerance, relative to the closed form, and is only
//! made where three standard errors, from the spread between groups of passes, lie within it: what passes is not luck,
//! what fails is not noise.

mod anisotropy;
mod bands;
mod build;
mod caustics;
mod cie;
mod contact;
mod direct;
mod discs;
mod estimate;
mod exchange;
mod facet_textures;
mod facets;
mod factors;
mod furnace;
mod glass;
mod glints;
mod glow;
mod harness;
mod layers;
mod lobes;
mod media;
mod mixtures;
mod partition;
mod rainbow;
mod relief;
mod scale;
mod spectral;
mod textures;
mod translucent;

//! Estimators: what the two backends have in common of how light is estimated.

pub mod indirect;
pub mod maps;
pub mod radii;
pub mod split_paths;

//! Claims about what the scene readers accept, repair and refuse.

mod camera;
mod doubts;
mod facets;
mod folder;
mod formats;
mod glass;
mod growth;
mod layers;
mod materials;
mod media;
mod meshes;
mod scene_file;
mod shapes;
mod spectra;
mod textures;

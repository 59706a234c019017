//! Claims about what the scene readers accept, repair and refuse.

mod camera;
mod folder;
mod formats;
mod materials;
mod meshes;
mod scene_file;

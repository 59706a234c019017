//! Host: the machine that joton runs on, its files and its memory.

pub(crate) mod files;
pub mod guard;
pub mod memory;

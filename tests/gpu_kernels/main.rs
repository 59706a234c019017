//! Each kernel on arrays and tiny scenes: sizes at the edges of workgroups, analytic answers, searches over all.

#[path = "../common/mod.rs"]
mod common;

mod caustic;
mod direct;
mod gather;
mod glint;
mod kernel_correction;
mod map;
mod radix;
mod scan;
mod trace;
mod uniform_branches;

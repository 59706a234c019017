//! Each kernel on arrays and tiny scenes: sizes at the edges of workgroups, analytic answers, searches over all.

#[path = "../common/mod.rs"]
mod common;

mod direct;

mod map;
mod radix;
mod scan;
mod trace;

//! The command line holds to its contract: exit status, what goes to stdout and stderr, files, numbers in the report.
//!
//! Runs the program in folders of its own. Tests that need a Vulkan, Metal or DX12 device fail where there is none,
//! unless JOTON_TEST_NO_GPU=1.

mod bands;
mod checkpoint;
mod combinations;
mod compare;
mod devices;
#[cfg(target_os = "linux")]
mod faults;
mod files;
mod folder;
mod images;
mod inputs;
mod merge;
mod plan;
mod refusals;
mod report;
mod slurm;
mod stop;
mod streams;

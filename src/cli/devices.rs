//! `joton devices`: adapters, drivers, limits, and which one auto picks.

use super::{DONE, say};
use joton::Result;

pub(super) fn run() -> Result<u8> {
    let adapters = joton::backend::gpu::adapters();
    for (i, adapter) in adapters.iter().enumerate() {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let picked = if i == 0 { "  <- auto" } else { "" };
        say(format_args!("{} ({:?}, {:?}){picked}", info.name, info.device_type, info.backend));
        say(format_args!("    driver {} {}", info.driver, info.driver_info));
        say(format_args!(
            "    storage binding {} MiB, buffer {} MiB, {} storage buffers a kernel, workgroups of {}",
            limits.max_storage_buffer_binding_size >> 20,
            limits.max_buffer_size >> 20,
            limits.max_storage_buffers_per_shader_stage,
            limits.max_compute_invocations_per_workgroup,
        ));
    }
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let picked = if adapters.is_empty() { "  <- auto" } else { "" };
    say(format_args!("cpu ({threads} threads){picked}"));
    Ok(DONE)
}

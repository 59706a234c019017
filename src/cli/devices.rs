//! `joton devices`: adapters, drivers, limits, and which one auto picks.

use super::{DONE, say, say_json};
use clap::Args;
use joton::Result;

/// Arguments of `joton devices`.
#[derive(Debug, Args)]
pub(super) struct DevicesArguments {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// A device.
#[derive(serde::Serialize)]
struct Device {
    name: String,
    kind: String,
    backend: String,
    driver: String,
    /// Whether `--device auto` takes it.
    is_auto: bool,
    /// Bytes.
    storage_binding: Option<u64>,
    buffer: Option<u64>,
    storage_buffers: Option<u32>,
    workgroup: Option<u32>,
    threads: Option<usize>,
}

pub(super) fn run(a: &DevicesArguments) -> Result<u8> {
    let mut all: Vec<Device> = joton::backend::gpu::adapters()
        .iter()
        .map(|adapter| {
            let (info, limits) = (adapter.get_info(), adapter.limits());
            Device {
                name: info.name,
                kind: format!("{:?}", info.device_type),
                backend: format!("{:?}", info.backend),
                driver: format!("{} {}", info.driver, info.driver_info),
                is_auto: false,
                storage_binding: Some(limits.max_storage_buffer_binding_size),
                buffer: Some(limits.max_buffer_size),
                storage_buffers: Some(limits.max_storage_buffers_per_shader_stage),
                workgroup: Some(limits.max_compute_invocations_per_workgroup),
                threads: None,
            }
        })
        .collect();
    all.push(Device {
        name: "cpu".into(),
        kind: "Cpu".into(),
        backend: "none".into(),
        driver: String::new(),
        is_auto: false,
        storage_binding: None,
        buffer: None,
        storage_buffers: None,
        workgroup: None,
        threads: Some(rayon::current_num_threads()),
    });
    all[0].is_auto = true;
    if a.json {
        say_json(&all)?;
        return Ok(DONE);
    }
    for device in &all {
        let picked = if device.is_auto { "  <- auto" } else { "" };
        if let Some(threads) = device.threads {
            say(format_args!("{} ({threads} threads){picked}", device.name));
            continue;
        }
        let mebibytes = |bytes: Option<u64>| bytes.unwrap_or(0) >> 20;
        say(format_args!("{} ({}, {}){picked}", device.name, device.kind, device.backend));
        say(format_args!("    driver {}", device.driver));
        say(format_args!(
            "    storage binding {} MiB, buffer {} MiB, {} storage buffers a kernel, workgroups of {}",
            mebibytes(device.storage_binding),
            mebibytes(device.buffer),
            device.storage_buffers.unwrap_or(0),
            device.workgroup.unwrap_or(0),
        ));
    }
    Ok(DONE)
}

//! Process memory: what a render takes beside the buffers of a device, and what a limit on all of it leaves for these.

use super::{Features, Plan, lamps_seen};
use crate::error::{Error, Result};
use crate::estimators::maps::MapKind;
use crate::film::{FilmNeeds, Layer};
use crate::packed::{EmitterKind, PackedScene};
use serde::Serialize;

/// Bytes of the program and its runtime.
const PROGRAM: u64 = 20 << 20;
/// Bytes more with a device: its driver and the kernels that it compiled, measured with Mesa's software Vulkan.
const DRIVER: u64 = 144 << 20;
/// Bytes that a driver takes for the code of microfacets and textures, likewise …
const DRIVER_OF_MORE: u64 = 110 << 20;
/// … of brushed surfaces …
const DRIVER_OF_BRUSHES: u64 = 84 << 20;
/// … and of clear coats and sheen.
const DRIVER_OF_LAYERS: u64 = 92 << 20;
/// Bytes of program and driver while kernels are compiled that no cache has: of a scene without glass and mirrors, and of one
/// with some; measured likewise, an image of 64 × 64 included. Small images take no more than that.
const COMPILING: [u64; 2] = [216 << 20, 300 << 20];
/// Bytes on the CPU for each joton that is emitted in a pass: it is stored a few times, and sorted.
const JOTON: u64 = 256;

/// Where passes are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Threads of the host.
    Cpu,
    /// A device of wgpu.
    Device,
}

/// What the process of a render takes at most beside the buffers of a device, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ProcessMemory {
    /// The program, its runtime and the driver of the device.
    pub program: u64,
    /// Triangles and their hierarchy, and the jotons of a pass on the CPU.
    pub scene: u64,
    /// Bytes that are taken in any case while kernels are compiled.
    pub compiling: u64,
    /// Sums of the passes, error estimate, sharing among neighbours, the picture and its files.
    pub films: u64,
}

impl ProcessMemory {
    /// Of a plan for a scene.
    pub fn of(scene: &PackedScene, plan: &Plan, place: Place) -> Self {
        let jotons: u64 = MapKind::ALL.into_iter().map(|kind| u64::from(plan.jotons(kind))).sum();
        let Features { facets, textures, cutouts, anisotropy, layers, .. } = plan.features;
        let code = [
            (facets || textures || cutouts, DRIVER_OF_MORE),
            (anisotropy, DRIVER_OF_BRUSHES),
            (layers, DRIVER_OF_LAYERS),
        ];
        let more: u64 = code.into_iter().filter(|(is_there, _)| *is_there).map(|(_, bytes)| bytes).sum();
        let compiling = COMPILING[usize::from(plan.has_specular_bodies())] + more;
        let (driver, jotons, compiling) = match place {
            Place::Cpu => (0, jotons * JOTON, 0),
            // the device has the scene by then
            Place::Device => (DRIVER + more, 0, compiling + 2 * scene.bytes()),
        };
        Self {
            program: PROGRAM + driver,
            scene: scene.bytes() + jotons,
            compiling,
            films: plan.films(scene).bytes(),
        }
    }

    /// All of it.
    pub fn total(&self) -> u64 {
        self.program.saturating_add(self.scene).saturating_add(self.films)
    }
}

impl Plan {
    /// What films of an image take.
    pub fn films(&self, scene: &PackedScene) -> FilmNeeds {
        let emission = if self.traces(Layer::Emission) { lamps_seen::pixels(scene) } else { 0 };
        // what a sun shines on is as bright everywhere
        let has_sun = scene.emitters.iter().any(|e| e.kind() == EmitterKind::Sun);
        FilmNeeds {
            size: scene.size,
            layers: Layer::ON_SURFACES.into_iter().filter(|layer| self.traces(*layer)).count(),
            emission,
            resting: if has_sun { scene.pixels() as u64 } else { emission },
            resolved: self.resolved_layers().len(),
            has_trees: self.has_specular_bodies(),
            has_maps: MapKind::ALL.into_iter().any(|kind| self.has_map(kind)),
            is_part: self.settings.is_part,
            measured: self.settings.measured,
        }
    }

    /// Keep the whole process to the limit of the settings: what it takes beside the buffers of a device is taken off what these
    /// may have. Without this the limit is theirs. Whether anything is left is told where they are made to fit.
    ///
    /// # Errors
    /// [`Error::Capacity`] where there are no buffers, and it takes more.
    pub fn bound_process(&mut self, scene: &PackedScene, place: Place) -> Result<()> {
        self.beside = ProcessMemory::of(scene, self, place).total();
        match self.settings.memory {
            Some(limit) if place == Place::Cpu && self.beside > limit => {
                Err(self.too_large(self.beside, limit))
            }
            _ => Ok(()),
        }
    }

    /// Bytes that the buffers of a device may take together; none for as much as it allows.
    pub(crate) fn buffer_limit(&self) -> Option<u64> {
        self.settings.memory.map(|limit| limit.saturating_sub(self.beside))
    }

    /// The render needs so many bytes, of a limit.
    pub(crate) fn too_large(&self, need: u64, limit: u64) -> Error {
        let without = if self.resolves { ", share no light among pixels (--resolve off)" } else { "" };
        let bands = if self.settings.measured > 0 { ", fewer bands (--bands)" } else { "" };
        let remedy = format!(
            "allow more (--memory), render a smaller image (--size){without}{bands} or fewer triangles"
        );
        Error::Capacity { buffer: "the render", need, limit, remedy }
    }
}

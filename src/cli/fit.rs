//! Fit: a scene is packed with pictures as large as `--memory` allows.

use super::pack;
use joton::packed::PackedScene;
use joton::plan::buffers::Expected;
use joton::plan::process_memory::Place;
use joton::plan::{Plan, Settings};
use joton::scene::Scene;
use joton::{Error, Result};

/// Copies of the levels of a picture that a device needs: its own, and the host's.
const ON_DEVICE: u64 = 2;
/// A picture without the levels that are a third more.
const OF_LEVELS: [u64; 2] = [3, 4];

/// Where a render on this device may be done: the places that are tried, one after the other.
pub(super) fn places_of(device: &str) -> &'static [Place] {
    match device {
        "cpu" => &[Place::Cpu],
        "auto" => &[Place::Device, Place::Cpu],
        _ => &[Place::Device],
    }
}

/// Pack a scene. Where the render would not fit its memory, the largest pictures are halved until it does, with a warning.
/// Where that does not help at one place, they are fitted to the next as they were; what does not fit at the last without them
/// is refused where it is planned.
///
/// # Errors
/// [`Error::Capacity`] where there is not the memory to pack it.
pub(super) fn pack_to_fit(scene: &mut Scene, settings: &Settings, places: &[Place]) -> Result<PackedScene> {
    joton::packed::fit_pictures(scene);
    let mut packed = pack(scene, settings)?;
    for (i, place) in places.iter().enumerate() {
        // pictures are shared
        let as_it_was = scene.materials.clone();
        let has_shrunk;
        (packed, has_shrunk) = shrink_to_fit(scene, packed, settings, *place)?;
        let is_last = i + 1 == places.len();
        if !has_shrunk || is_last || excess(&packed, settings, *place).is_none() {
            break;
        }
        scene.materials = as_it_was;
        drop(packed);
        packed = pack(scene, settings)?;
    }
    scene.warnings.extend(scene.smaller_pictures());
    Ok(packed)
}

/// Halve the largest pictures until the render fits, or until nothing is left of them; whether any was.
fn shrink_to_fit(
    scene: &mut Scene,
    mut packed: PackedScene,
    settings: &Settings,
    place: Place,
) -> Result<(PackedScene, bool)> {
    let mut has_shrunk = false;
    while settings.memory.is_some()
        && scene.picture_bytes() > 0
        && let Some(excess) = excess(&packed, settings, place)
    {
        let copies = if place == Place::Device { ON_DEVICE } else { 1 };
        let most =
            scene.picture_bytes().saturating_sub((excess * OF_LEVELS[0] / OF_LEVELS[1] / copies).max(1));
        if !scene.shrink_pictures(most) {
            break;
        }
        drop(packed);
        packed = pack(scene, settings)?;
        has_shrunk = true;
    }
    Ok((packed, has_shrunk))
}

/// Bytes by which a render is too large.
fn excess(packed: &PackedScene, settings: &Settings, place: Place) -> Option<u64> {
    let mut plan = Plan::new(packed, settings.clone());
    let fits = plan.bound_process(packed, place).and_then(|()| match place {
        Place::Cpu => Ok(()),
        Place::Device => Expected::look(packed, plan).map(|_| ()),
    });
    match (fits, settings.memory) {
        (Err(Error::Capacity { need, limit, .. }), Some(memory)) if limit == memory => Some(need - limit),
        _ => None,
    }
}

//! Map layout: how the emission of a map is cut into lanes, so that it fits a device.

use super::traffic::Mean;
use crate::estimators::maps::MapKind;
use crate::packed::constants::STEP_BUDGET;
use std::ops::Range;

/// What a device is, as far as sizes follow from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceLimits {
    /// It runs on the host's processor (lavapipe, SwiftShader).
    pub is_software: bool,
    /// Bytes of a storage buffer, at most.
    pub storage_binding: u64,
    /// Bytes of a uniform buffer, at most.
    pub uniform_binding: u64,
    /// Storage buffers of a kernel, at most.
    pub storage_buffers: u32,
}

impl DeviceLimits {
    /// The machine that `joton plan` tells sizes and costs of: lavapipe, whose bindings are as small as WebGPU's.
    pub const REFERENCE: Self = Self {
        is_software: true,
        storage_binding: 128 << 20,
        uniform_binding: 64 << 10,
        storage_buffers: 32,
    };
}

/// Jotons that a lane traces, one after the other: lanes stay busy where others' jotons die early.
const JOTONS_PER_LANE_SOFTWARE: u32 = 64;
/// On a GPU thousands of lanes run together.
const JOTONS_PER_LANE: u32 = 4;
/// Bits of a radix digit.
pub const DIGIT_BITS: u32 = 8;
/// Jotons up to which keys have 16 bits; beyond they have 20.
const SMALL_MAP: u64 = 1 << 19;

/// How a map's emission is cut into lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MapLayout {
    /// Jotons emitted a pass.
    pub emitted: u32,
    /// Invocations that trace them.
    pub lanes: u32,
    /// Jotons that a lane can store.
    pub lane_capacity: u32,
    /// Dispatches of the trace kernel in a pass.
    pub dispatches: u32,
}

/// Room for lanes that store more than the pilot's fullest one.
const CAPACITY_SLACK: f64 = 1.5;
/// Jotons more than that, since lanes that store few differ much.
const CAPACITY_MORE: u32 = 4;
/// Deviations by which the fullest of a few hundred lanes exceeds the mean.
const DEVIATIONS: f64 = 3.0;
/// Loop iterations of an emission, and of a ray for each doubling of the triangles.
const STEPS_EMIT: f64 = 35.0;
const STEPS_RAY: f64 = 2.0;

/// Room for a lane of which one was found to store so many.
pub fn roomy(stored: u32) -> u32 {
    (f64::from(stored) * CAPACITY_SLACK) as u32 + CAPACITY_MORE
}

/// Dispatches of a pass where the pilot needed so many: single paths of other passes are a few times longer, and one that is not at its
/// end costs the whole pass, while a dispatch of lanes that are done costs next to nothing.
pub fn dispatches_kept(needed: u32) -> u32 {
    2 * needed + 2
}

impl MapLayout {
    /// So many jotons in lanes, before anything is known of these.
    pub fn new(emitted: u32, machine: &DeviceLimits) -> Self {
        let per_lane = if machine.is_software { JOTONS_PER_LANE_SOFTWARE } else { JOTONS_PER_LANE };
        Self { emitted, lanes: emitted.div_ceil(per_lane), lane_capacity: 1, dispatches: 1 }
    }

    /// So many jotons in lanes, as the pilot is expected to cut them: a lane's fullest is a few deviations over its mean.
    pub fn expected(emitted: u32, mean: &Mean, triangles: usize, machine: &DeviceLimits) -> Self {
        let shape = Self::new(emitted, machine);
        let jotons = f64::from(emitted) / f64::from(shape.lanes.max(1));
        // numbers of hits are geometric, or nearly so
        let deviation = (jotons * mean.stored * (1.0 + mean.stored)).sqrt();
        let fullest = (jotons * mean.stored + DEVIATIONS * deviation).ceil();
        let doublings = (triangles as f64).log2().max(1.0);
        let steps = jotons * (STEPS_EMIT + mean.rays * STEPS_RAY * doublings);
        let needed = ((steps / f64::from(STEP_BUDGET)).ceil() as u32).max(1).next_power_of_two();
        // as the pilot does: one is room enough where no lane was found to store more
        let lane_capacity = if fullest > 1.0 { roomy(fullest as u32) } else { shape.lane_capacity };
        Self { lane_capacity, dispatches: dispatches_kept(needed), ..shape }
    }

    /// Half the jotons in half the lanes.
    pub fn halved(&self) -> Self {
        Self { emitted: self.emitted.div_ceil(2), lanes: self.lanes.div_ceil(2), ..*self }
    }

    /// Indices of a pass's jotons in the low-discrepancy sequences, where so many were planned: what passes that got fewer leave
    /// out, no other pass uses.
    pub fn indices(&self, pass: u32, planned: u32) -> Range<u64> {
        let first = u64::from(pass) * u64::from(planned);
        first..first + u64::from(self.emitted)
    }

    /// Most jotons that are stored in a pass.
    pub fn max_stored(&self) -> u64 {
        u64::from(self.lanes) * u64::from(self.lane_capacity)
    }

    /// Bits of a bucket's number.
    pub fn key_bits(&self) -> u32 {
        if self.max_stored() <= SMALL_MAP { 16 } else { 20 }
    }

    /// Entries of the bucket table: rows, columns and one more.
    pub fn buckets(&self) -> u64 {
        (1 << self.key_bits()) + 2
    }

    /// Digits that the sort works off.
    pub fn digits(&self) -> u32 {
        self.key_bits().div_ceil(DIGIT_BITS)
    }

    /// Items that one invocation of the sort takes: long where lanes are few, short where a GPU has thousands.
    pub fn chunk(&self, machine: &DeviceLimits) -> u32 {
        if machine.is_software { 2048 } else { (self.max_stored() / 4096).clamp(64, 2048) as u32 }
    }

    /// Invocations of the sort.
    pub fn chunks(&self, machine: &DeviceLimits) -> u32 {
        self.max_stored().div_ceil(u64::from(self.chunk(machine))) as u32
    }
}

/// How each map is cut into lanes; none where it is skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MapLayouts {
    /// The caustic map.
    pub caustic: Option<MapLayout>,
    /// The diffuse map.
    pub diffuse: Option<MapLayout>,
}

impl MapLayouts {
    /// Of one map.
    pub fn of(&self, kind: MapKind) -> Option<MapLayout> {
        match kind {
            MapKind::Caustic => self.caustic,
            MapKind::Diffuse => self.diffuse,
        }
    }

    /// Of one map, to be changed.
    pub fn of_mut(&mut self, kind: MapKind) -> &mut Option<MapLayout> {
        match kind {
            MapKind::Caustic => &mut self.caustic,
            MapKind::Diffuse => &mut self.diffuse,
        }
    }

    /// Of the maps that are traced.
    pub fn each(&self) -> impl Iterator<Item = MapLayout> {
        [self.caustic, self.diffuse].into_iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No joton of one pass has an index of another's, whichever of them get only a half or a quarter of what was planned, and
    /// far beyond 2^32.
    #[test]
    fn passes_share_no_indices() {
        const PLANNED: u32 = 1_555_200;
        let whole = MapLayout::new(PLANNED, &DeviceLimits::REFERENCE);
        let shapes = [whole, whole.halved(), whole.halved().halved()];
        for first in [0, 1, 1000, 1 << 13, 1 << 31, u32::MAX - 9] {
            let mut end = 0;
            for pass in first..first + 9 {
                for shape in shapes {
                    let indices = shape.indices(pass, PLANNED);
                    assert!(indices.start >= end, "pass {pass}: {indices:?}, {end}");
                    assert_eq!(indices.end - indices.start, u64::from(shape.emitted));
                }
                end = whole.indices(pass, PLANNED).end;
            }
        }
    }
}

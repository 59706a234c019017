//! Tiles: the list of tiles on the device, those that rest least first, so that the live ones of a pass are its head [E21].

use crate::film::tile_schedule::{EXPONENT_MAX, TileSchedule};
use crate::packed::constants::{TILE_BITS, TILES_VECTORS};

/// Tiles that one binding, and so one dispatch, sees.
pub(super) const TILES_PER_DISPATCH: u32 = TILES_VECTORS * 4;
/// Bytes of a binding.
pub(super) const BINDING_BYTES: u32 = TILES_VECTORS * 16;

/// The list, and how many of it are live.
pub(super) struct Tiles {
    schedule: TileSchedule,
    /// Tiles of exponent k or less, for each k.
    up_to: [u32; EXPONENT_MAX as usize + 1],
}

impl Tiles {
    /// The list of who rests; its words, to be written into the buffer.
    pub(super) fn new(schedule: TileSchedule) -> (Self, Vec<u32>) {
        let mut words = Vec::with_capacity(schedule.exponents().len());
        let mut up_to = [0; EXPONENT_MAX as usize + 1];
        for (k, end) in up_to.iter_mut().enumerate() {
            let alike = (0u32..).zip(schedule.exponents()).filter(|(_, e)| usize::from(**e) == k);
            words.extend(alike.map(|(tile, _)| tile | (k as u32) << TILE_BITS));
            *end = words.len() as u32;
        }
        (Self { schedule, up_to }, words)
    }

    /// Who rests.
    pub(super) fn tile_schedule(&self) -> &TileSchedule {
        &self.schedule
    }

    /// Tiles that take part in a pass: the first so many.
    pub(super) fn live(&self, pass: u64) -> u32 {
        self.up_to[pass.trailing_zeros().min(EXPONENT_MAX) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The head of the list is what is live, in every pass.
    #[test]
    fn the_head_of_the_list_is_live() {
        let exponents = vec![3, 0, 1, 4, 0, 2, 1, 0, 4];
        let (tiles, words) = Tiles::new(TileSchedule::new([24, 24], exponents.clone()));
        assert_eq!(tiles.live(0), 9);
        for pass in 0..40u64 {
            let head = words[..tiles.live(pass) as usize].iter();
            let mut live: Vec<usize> = head.map(|w| (w & ((1 << TILE_BITS) - 1)) as usize).collect();
            live.sort_unstable();
            let wanted: Vec<usize> = (0..9).filter(|t| tiles.tile_schedule().is_live(*t, pass)).collect();
            assert_eq!(live, wanted, "pass {pass}");
        }
        assert!(words.iter().all(|w| w >> TILE_BITS == u32::from(exponents[(w & 0xff) as usize])));
    }
}

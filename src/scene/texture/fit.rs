//! Fit: the largest pictures are halved until all of them take no more memory than they may.
//!
//! How far follows from what the user allows and from the scene, never from what the machine has free.

use super::levels::{self, Level};
use super::{Bitmap, Space, Texels, Texture};
use crate::host::memory::limit;
use crate::scene::warnings::listed;
use crate::scene::{Material, Scene};
use std::collections::HashMap;
use std::sync::Arc;

/// Bytes of the program that reads a scene.
const PROGRAM: u64 = 16 << 20;
/// Bytes for each of a picture where a scene is packed: itself, its levels, and the first of these in f32.
const PACKED: [u64; 2] = [10, 3];
/// Pictures that a warning names.
const NAMES: usize = 3;

/// Pictures by the address of those whose place they take.
pub(crate) type Replaced = HashMap<usize, Arc<Bitmap>>;

/// Bytes that pictures may take where a scene is read and packed that takes so many bytes beside; none where nothing is
/// said of memory.
pub(crate) fn room(beside: u64) -> Option<u64> {
    Some(limit()?.saturating_sub(PROGRAM.saturating_add(beside)) / PACKED[0] * PACKED[1])
}

/// The largest of these pictures are halved until all take at most so many bytes: those that take the places of others.
pub(crate) fn smaller<'a>(all: impl Iterator<Item = (&'a Arc<Bitmap>, Space)>, most: u64) -> Replaced {
    let all: Vec<_> = all.collect();
    let pictures: Vec<_> =
        all.iter().map(|(bitmap, _)| (bitmap.size, bytes_of_texel(&bitmap.texels))).collect();
    let made = halvings(&pictures, most).into_iter().zip(all);
    let made = made.filter(|(times, _)| *times > 0);
    made.map(|(times, (bitmap, space))| (address(bitmap), Arc::new(halved(bitmap, space, times)))).collect()
}

/// How often each of the pictures is halved, which have a size and bytes of a texel.
fn halvings(pictures: &[([u32; 2], u64)], most: u64) -> Vec<u32> {
    let bytes = |([width, height], texel): ([u32; 2], u64)| u64::from(width) * u64::from(height) * texel;
    let mut left = pictures.to_vec();
    let mut times = vec![0; left.len()];
    let mut all: u64 = left.iter().map(|picture| bytes(*picture)).sum();
    while all > most {
        // of several that are as large the first
        let can_be_halved = |(_, (size, _)): &(usize, &([u32; 2], u64))| *size != [1; 2];
        let largest = left.iter().enumerate().rev().filter(can_be_halved).max_by_key(|(_, p)| bytes(**p));
        let Some(i) = largest.map(|(i, _)| i) else { break };
        all -= bytes(left[i]);
        left[i].0 = levels::half(left[i].0);
        all += bytes(left[i]);
        times[i] += 1;
    }
    times
}

fn bytes_of_texel(texels: &Texels) -> u64 {
    match texels {
        Texels::Bytes(_) => size_of::<[u8; 4]>() as u64,
        Texels::Halves(_) => size_of::<[u16; 4]>() as u64,
    }
}

/// The level after so many of a picture.
fn halved(bitmap: &Bitmap, space: Space, times: u32) -> Bitmap {
    let mut level = Level::after(bitmap, space);
    for _ in 1..times {
        level = level.and_then(|known| known.next());
    }
    let Some(level) = level else { return bitmap.clone() };
    let texels = level.texels_like(&bitmap.texels, space);
    Bitmap { size: level.size, texels, file: bitmap.file.clone() }
}

/// What tells a picture from others.
pub(crate) fn address(bitmap: &Arc<Bitmap>) -> usize {
    Arc::as_ptr(bitmap) as usize
}

/// Let materials show pictures in place of others.
pub(crate) fn replace(materials: &mut [Material], by: &Replaced) {
    for material in materials {
        material.change_textures(&mut |texture| {
            if let Some(bitmap) = by.get(&address(&texture.bitmap)) {
                texture.bitmap = bitmap.clone();
            }
        });
    }
}

/// Pictures of materials, each once in the order in which they are met, and how their levels are made: of one that is colour
/// somewhere as of a colour.
pub(crate) fn pictures(materials: &[Material]) -> Vec<(&Arc<Bitmap>, Space)> {
    let mut place_of = HashMap::new();
    let mut all: Vec<(&Arc<Bitmap>, Space)> = Vec::new();
    for Texture { bitmap, space, .. } in materials.iter().flat_map(Material::textures) {
        let place = *place_of.entry(address(bitmap)).or_insert(all.len());
        match all.get_mut(place) {
            None => all.push((bitmap, *space)),
            Some((_, known)) if *space == Space::Srgb => *known = Space::Srgb,
            Some(_) => {}
        }
    }
    all
}

impl Scene {
    /// Bytes of all its pictures.
    pub fn picture_bytes(&self) -> u64 {
        pictures(&self.materials).iter().map(|(bitmap, _)| bitmap.bytes()).sum()
    }

    /// Halve its largest pictures until all take at most so many bytes; false where nothing is left to be halved.
    pub fn shrink_pictures(&mut self, most: u64) -> bool {
        let by = smaller(pictures(&self.materials).into_iter(), most);
        replace(&mut self.materials, &by);
        !by.is_empty()
    }

    /// A warning that names pictures that are smaller than their files, and what to do.
    pub fn smaller_pictures(&self) -> Option<String> {
        let all = pictures(&self.materials);
        let words = all.iter().filter_map(|(bitmap, _)| {
            let file = bitmap.file.as_ref().filter(|file| file.size != bitmap.size)?;
            let [[w, h], [width, height]] = [file.size, bitmap.size];
            Some(format!("{} from {w} × {h} to {width} × {height} texels", file.path.display()))
        });
        let words: Vec<String> = words.collect();
        let what = listed(&words[..words.len().min(NAMES)], words.len());
        let what = format!("textures are made smaller to fit the memory: {what}; allow more (--memory)");
        (!words.is_empty()).then(|| crate::error::plain(&what).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest is halved first, of those that are as large the first; bytes count, not texels; what fits stays as it is, and
    /// nothing is halved that has one texel.
    #[test]
    fn the_largest_picture_is_halved_first() {
        let pictures = [([8, 8], 4), ([8, 8], 4), ([6, 6], 8), ([1, 1], 4)];
        let all = 256 + 256 + 288 + 4;
        for (most, times) in [
            (all, [0, 0, 0, 0]),
            (all - 1, [0, 0, 1, 0]),
            (all - 288 + 72 - 1, [1, 0, 1, 0]),
            (64 + 64 + 72 + 4, [1, 1, 1, 0]),
            (64 + 64 + 8 + 4, [1, 1, 2, 0]),
            (0, [3, 3, 2, 0]),
        ] {
            assert_eq!(halvings(&pictures, most), times, "{most}");
        }
    }

    /// What takes the place of a picture is its level, in linear light, and remembers its file.
    #[test]
    fn a_smaller_picture_is_a_level() {
        let texels = [0, 255, 0, 255, 0, 255, 0, 255].map(|x: u8| [x, x, x, 255]).to_vec();
        let bitmap = Arc::new(Bitmap::new([4, 2], Texels::Bytes(texels)));
        for (space, grey) in [(Space::Srgb, 188), (Space::Linear, 128)] {
            let by = smaller([(&bitmap, space)].into_iter(), 8);
            let found = &by[&address(&bitmap)];
            assert_eq!(
                (found.size, &found.texels),
                ([2, 1], &Texels::Bytes(vec![[grey, grey, grey, 255]; 2]))
            );
        }
        assert!(smaller([(&bitmap, Space::Srgb)].into_iter(), 32).is_empty());
    }
}

//! Strips: the image cut into rows of which a device holds some at a time.

use crate::packed::constants::TILE;

/// The image in strips of rows, one of which is on the device at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strips {
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Rows of a strip: all, or a multiple of [`TILE`], so that workgroups are the same whatever the strips.
    pub rows: u32,
}

/// A strip: the rows that it renders, and those that its buffers hold. What a pixel's neighbours were found to be is looked
/// up, so there is one row more on each side, where the image has one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Strip {
    /// First row that is rendered.
    pub first: u32,
    /// Rows that are rendered.
    pub rows: u32,
    /// First row in the buffers.
    pub held_first: u32,
    /// Rows in the buffers.
    pub held_rows: u32,
}

impl Strip {
    /// What the buffers hold, all of it rendered: the pilot's.
    pub fn with_overlap(self) -> Self {
        Self { first: self.held_first, rows: self.held_rows, ..self }
    }
}

/// Rows on each side of a strip that its pixels look at.
const OVERLAP: u32 = 1;

impl Strips {
    /// All of an image in one.
    pub fn whole(size: [u32; 2]) -> Self {
        Self { size, rows: size[1] }
    }

    /// An image in `count` strips, or as many as its tiles allow.
    pub fn cut(size: [u32; 2], count: u32) -> Self {
        if count <= 1 {
            return Self::whole(size);
        }
        Self { size, rows: size[1].div_ceil(count).next_multiple_of(TILE).min(size[1]) }
    }

    /// Number of strips.
    pub fn count(&self) -> u32 {
        self.size[1].div_ceil(self.rows)
    }

    /// Strip number `i`.
    pub fn strip(&self, i: u32) -> Strip {
        let height = self.size[1];
        let first = i * self.rows;
        let end = (first + self.rows).min(height);
        let held_first = first.saturating_sub(OVERLAP);
        let held_end = (end + OVERLAP).min(height);
        Strip { first, rows: end - first, held_first, held_rows: held_end - held_first }
    }

    /// All strips, from the top.
    pub fn each(&self) -> impl Iterator<Item = Strip> + use<> {
        let strips = *self;
        (0..strips.count()).map(move |i| strips.strip(i))
    }

    /// Pixels that the buffers hold, at most.
    pub fn pixels_held(&self) -> u64 {
        let rows = if self.count() == 1 { self.rows } else { (self.rows + 2 * OVERLAP).min(self.size[1]) };
        u64::from(self.size[0]) * u64::from(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every row is rendered by one strip, which holds its neighbours, too.
    #[test]
    fn strips_cover_the_image_once() {
        for height in [1, 7, 8, 9, 17, 64, 65, 1600] {
            for count in [1, 2, 3, 5, 1000] {
                let strips = Strips::cut([3, height], count);
                let mut next = 0;
                for s in strips.each() {
                    assert_eq!(s.first, next);
                    assert!(s.rows > 0 && (s.first % TILE == 0));
                    let around = s.first.saturating_sub(1)..(s.first + s.rows + 1).min(height);
                    assert_eq!(s.held_first..s.held_first + s.held_rows, around);
                    assert!(3 * u64::from(s.held_rows) <= strips.pixels_held());
                    next = s.first + s.rows;
                }
                assert_eq!(next, height);
                assert!(strips.count() <= count);
            }
        }
    }
}

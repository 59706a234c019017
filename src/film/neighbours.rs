//! Neighbours: a pixel and those around it.

/// Indices of a pixel and of its up to eight neighbours, row by row.
pub(crate) fn around(pixel: u32, [width, height]: [u32; 2]) -> impl Iterator<Item = usize> {
    let near = |i: u32, end: u32| i.saturating_sub(1)..(i + 2).min(end);
    let columns = near(pixel % width, width);
    near(pixel / width, height).flat_map(move |y| columns.clone().map(move |x| (y * width + x) as usize))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_have_four_edges_six_and_the_rest_nine() {
        let count = |pixel| around(pixel, [4, 3]).count();
        assert_eq!((0..12).map(count).collect::<Vec<_>>(), [4, 6, 6, 4, 6, 9, 9, 6, 4, 6, 6, 4]);
        assert_eq!(around(5, [4, 3]).collect::<Vec<_>>(), [0, 1, 2, 4, 5, 6, 8, 9, 10]);
    }
}

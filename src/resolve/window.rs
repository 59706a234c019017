//! Window: what is held of an image while it is swept from its first row to its last. Numbers count from the image's beginning, wherever
//! the window is.

use std::collections::VecDeque;
use std::ops::{Index, IndexMut, Range};

/// Items one after the other, of which the first ones may be gone.
#[derive(Debug, Clone)]
pub(super) struct Window<T> {
    /// Number of the first that is held.
    first: usize,
    items: VecDeque<T>,
}

impl<T> Default for Window<T> {
    fn default() -> Self {
        Self { first: 0, items: VecDeque::new() }
    }
}

impl<T> Window<T> {
    /// Nothing that begins with this number.
    pub(super) fn at(first: usize) -> Self {
        Self { first, items: VecDeque::new() }
    }

    /// The number after the last one.
    pub(super) fn end(&self) -> usize {
        self.first + self.items.len()
    }

    /// Take what follows; no more room than that needs.
    pub(super) fn extend(&mut self, more: Vec<T>) {
        self.items.reserve_exact(more.len());
        self.items.extend(more);
    }

    /// Let go of all before this number.
    pub(super) fn drop_before(&mut self, number: usize) {
        let gone = number.saturating_sub(self.first).min(self.items.len());
        self.items.drain(..gone);
        self.first += gone;
    }

    /// Some of them.
    pub(super) fn range(&self, numbers: Range<usize>) -> impl Iterator<Item = &T> + Clone {
        self.items.range(numbers.start - self.first..numbers.end - self.first)
    }

    /// Some of them, to be changed.
    pub(super) fn range_mut(&mut self, numbers: Range<usize>) -> impl Iterator<Item = &mut T> {
        self.items.range_mut(numbers.start - self.first..numbers.end - self.first)
    }
}

impl<T> Index<usize> for Window<T> {
    type Output = T;

    #[inline]
    fn index(&self, number: usize) -> &T {
        &self.items[number - self.first]
    }
}

impl<T> IndexMut<usize> for Window<T> {
    #[inline]
    fn index_mut(&mut self, number: usize) -> &mut T {
        &mut self.items[number - self.first]
    }
}

impl<T> FromIterator<T> for Window<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        Self { first: 0, items: items.into_iter().collect() }
    }
}

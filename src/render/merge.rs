//! Merge: parts of a render put together.

use super::RenderState;
use super::pass_range::PassRange;
use crate::error::{Error, Result};

impl RenderState {
    /// Add the passes of the next part of the same render. Sums are exact: parts that were merged have the bits of one that rendered all
    /// their passes on the same device.
    ///
    /// # Errors
    /// [`Error::Usage`] where one is no part of a render, or not finished, where their sizes differ, and where the next one does not begin
    /// with the pass after the last. Nothing is added then.
    pub fn merge(&mut self, next: &Self) -> Result<()> {
        let [part, next_part] = [self.finished_part()?, next.finished_part()?];
        if self.size != next.size || self.sums.resolves() != next.sums.resolves() {
            let what = format!("passes {part} and {next_part} are of different renders");
            return Err(Error::usage(what, "merge parts that differ in their passes alone"));
        }
        let (end, first) = (part.end(), next_part.first());
        if first > end {
            let missing = PassRange::new(end, first).map_or_else(
                |_| format!("passes {end} to {}", first - 1),
                |missing| format!("passes {missing}"),
            );
            return Err(Error::usage(format!("{missing} are missing"), "render these, too"));
        }
        if first < end {
            let what = format!("passes {part} and {next_part} overlap");
            return Err(Error::usage(what, "merge parts that have no pass in common"));
        }
        self.sums.merge(&next.sums);
        self.tally += next.tally;
        self.imbalance.merge(&next.imbalance);
        self.pass = next.pass;
        self.part = Some(PassRange::new(part.first(), next_part.end())?);
        self.error = None;
        self.reading = std::array::from_fn(|i| self.reading[i] + next.reading[i]);
        self.failures.extend(next.failures.iter().cloned());
        Ok(())
    }

    /// The passes that it was to render, and has.
    ///
    /// # Errors
    /// [`Error::Usage`] where it is no part, or has not.
    pub fn finished_part(&self) -> Result<PassRange> {
        let Some(part) = self.part else {
            return Err(Error::usage("is no part of a render", "render parts by --pass-range"));
        };
        if self.pass < part.end() {
            let what = format!("has {} of the {} passes {part}", self.passes(), part.passes());
            return Err(Error::usage(what, "go on with it by joton resume"));
        }
        Ok(part)
    }
}

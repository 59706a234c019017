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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::{Backend, Batch, Tally};
    use crate::estimators::split_paths::{Light, Look, SplitPaths};
    use crate::film::{LAYERS, Layer};
    use crate::render::{Reason, Stop};
    use crate::sampling::rng::random4;
    use crate::spectrum::BANDS;

    const SIZE: [u32; 2] = [8, 8];

    /// Noise of every size, in batches of up to 16 passes that are summed in f32.
    struct Noise;

    impl Backend for Noise {
        fn describe(&self) -> String {
            "noise".into()
        }

        fn batch_passes(&self, first: u64) -> u32 {
            (first.next_power_of_two() / 2).clamp(1, 16) as u32
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            let of = |layer: usize, pixel: u32| -> [f32; BANDS] {
                let passes = (first..first + u64::from(count)).map(|pass| {
                    let [size, value, ..] = random4(layer as u32, pass as u32, pixel, 0);
                    value * (40.0 * size - 30.0).exp2()
                });
                [passes.sum(); BANDS]
            };
            let layers = std::array::from_fn(|layer| (0..64).map(|pixel| of(layer, pixel)).collect());
            let tally = Tally { rays: count.into(), ..Tally::default() };
            Ok(Batch { layers, tally })
        }
    }

    fn range(first: u64, end: u64) -> PassRange {
        PassRange::new(first, end).expect("a range")
    }

    fn part(first: u64, end: u64) -> RenderState {
        rendered(SIZE, range(first, end), end)
    }

    fn rendered(size: [u32; 2], range: PassRange, until: u64) -> RenderState {
        let mut state = RenderState::of_part(size, range);
        state.sums.set_resolves(&[Layer::Direct]);
        let stop = Stop { passes: Some(until), ..Stop::default() };
        state.go_on(&mut Noise, stop, |_| true).expect("passes");
        state
    }

    /// Wherever a render is cut, and whichever parts are merged first, the picture has the same bits, the counts are the same, and each pass counts
    /// once: the head of a part does not.
    #[test]
    fn parts_have_the_bits_of_the_whole() {
        let whole = part(0, 200);
        let picture = |state: RenderState| state.finish(Reason::Passes).picture;
        let wanted = picture(part(0, 200));
        for cuts in [&[16][..], &[16, 32, 48], &[64, 192], &[112]] {
            let ends: Vec<u64> = cuts.iter().copied().chain([200]).collect();
            let firsts = [0].into_iter().chain(cuts.iter().copied());
            let parts: Vec<RenderState> = firsts.zip(&ends).map(|(first, end)| part(first, *end)).collect();
            for (part, end) in parts.iter().zip(&ends) {
                assert_eq!((part.range().end, part.tally.rays), (*end, part.passes()), "{cuts:?}");
            }
            // the last ones first
            let mut parts = parts.into_iter().rev();
            let mut merged = parts.next().expect("a part");
            for mut before in parts {
                before.merge(&merged).expect("they follow each other");
                merged = before;
            }
            assert_eq!((merged.range(), merged.part()), (0..200, Some(range(0, 200))));
            assert_eq!(merged.tally.rays, whole.tally.rays);
            let halves =
                [&merged, &whole].map(|state| state.sums.film().halves(Layer::Direct).expect("kept"));
            for pixel in 0..64 {
                assert_eq!(halves[0].means(pixel), halves[1].means(pixel), "{cuts:?}, pixel {pixel}");
            }
            let found = picture(merged);
            assert_eq!(found.whole, wanted.whole, "{cuts:?}");
            assert_eq!(found.layers.len(), LAYERS);
        }
    }

    /// [`Noise`] that splits paths, and counts how often it is told anew where.
    struct Split {
        paths: SplitPaths,
        told: Vec<u64>,
        next: u64,
    }

    impl Backend for Split {
        fn describe(&self) -> String {
            "split".into()
        }

        fn split_paths(&self) -> Option<&SplitPaths> {
            Some(&self.paths)
        }

        fn set_split_paths(&mut self, paths: SplitPaths) -> Result<()> {
            self.paths = paths;
            self.told.push(self.next);
            Ok(())
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            self.next = first + u64::from(count);
            Noise.render(first, count)
        }
    }

    /// A part decides where paths are split by the first passes alone, which it renders, too; a render that is no part goes on to decide.
    #[test]
    fn parts_decide_by_the_head_alone() {
        let look = Look { light: Light::InPart, branched: true, square: 1.0, squared_mean: 0.5 };
        let told = |mut state: RenderState| {
            let paths = SplitPaths::mark(SIZE, &[look; 64], &[]);
            let mut backend = Split { paths, told: Vec::new(), next: 0 };
            let stop = Stop { passes: Some(80), ..Stop::default() };
            state.go_on(&mut backend, stop, |_| true).expect("passes");
            (backend.told, state.passes())
        };
        assert_eq!(told(RenderState::new(SIZE)), (vec![2, 4, 8, 16, 32, 64], 80));
        assert_eq!(told(RenderState::of_part(SIZE, range(0, 80))), (vec![2, 4, 8, 16], 80));
        assert_eq!(told(RenderState::of_part(SIZE, range(16, 80))), (vec![2, 4, 8, 16], 64));
        assert_eq!(told(RenderState::of_part(SIZE, range(48, 80))), (vec![2, 4, 8, 16], 32));
    }

    /// Of the head nothing is told: neither its passes nor its error.
    #[test]
    fn the_head_is_no_part_of_the_picture() {
        let look = Look { light: Light::InPart, branched: true, square: 1.0, squared_mean: 0.5 };
        let mut backend =
            Split { paths: SplitPaths::mark(SIZE, &[look; 64], &[]), told: Vec::new(), next: 0 };
        let mut state = RenderState::of_part(SIZE, range(32, 64));
        let mut seen = Vec::new();
        let watch = |p: &crate::render::Progress<'_>| {
            seen.push((p.passes, p.error.is_some()));
            p.passes < 2
        };
        state.go_on(&mut backend, Stop { passes: Some(64), ..Stop::default() }, watch).expect("passes");
        assert_eq!(seen.len(), 18, "{seen:?}");
        assert!(seen[..16].iter().all(|(passes, _)| *passes == 0), "{seen:?}");
        assert_eq!(seen[15..], [(0, false), (1, false), (2, false)], "{seen:?}");
        assert_eq!(state.finish(Reason::Interrupted).error_estimate, None);
    }

    /// What does not follow is refused, and changes nothing.
    #[test]
    fn what_does_not_follow_is_refused() {
        let refused = |first: &mut RenderState, next: &RenderState, told: &str| {
            let passes = first.passes();
            let e = first.merge(next).expect_err(told).to_string();
            assert!(e.contains(told), "{e}");
            assert_eq!(first.passes(), passes);
        };
        let mut first = part(0, 32);
        refused(&mut first, &part(48, 64), "passes 32..48 are missing");
        refused(&mut first, &part(16, 64), "passes 0..32 and 16..64 overlap");
        refused(&mut first, &RenderState::new(SIZE), "is no part");
        refused(&mut first, &rendered([16, 4], range(32, 48), 48), "of different renders");
        refused(&mut first, &rendered(SIZE, range(32, 64), 40), "has 8 of the 32 passes 32..64");
        refused(&mut RenderState::new(SIZE), &first, "is no part");
        let mut odd = part(0, 20);
        refused(&mut odd, &part(32, 48), "passes 20 to 31 are missing");
        first.merge(&part(32, 48)).expect("it follows");
    }
}

//! Lists of wavelengths that someone measures at: the bands of a film beside red, green and blue, in threes  \[E53\].

use super::{BANDS, LAMBDA_MAX, LAMBDA_MIN};
use std::str::FromStr;

/// Where bands lie that are counted and not listed, both ends among them, nm: where instruments measure.
const EVEN: [f64; 2] = [400.0, 700.0];
/// Most bands: of those that are counted one every nm. A number up to this is a count, a larger one a wavelength.
const MOST: usize = 301;

/// Wavelengths, nm, ascending, each once; at least one.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct List(Vec<f64>);

impl List {
    /// Wavelengths in any order: what is rendered depends on which they are alone.
    ///
    /// # Errors
    /// What is wrong with them, and what would not be.
    pub fn new(mut lambdas: Vec<f64>) -> Result<Self, String> {
        if let Some(lambda) = lambdas.iter().find(|l| !(LAMBDA_MIN..=LAMBDA_MAX).contains(*l)) {
            return Err(format!("{lambda} nm is not carried; name wavelengths from 360 to 830 nm"));
        }
        if !(1..=MOST).contains(&lambdas.len()) {
            return Err(format!("{} bands; ask for 1 to {MOST}", lambdas.len()));
        }
        // as files write them: what differs by less has one name
        lambdas.iter_mut().for_each(|lambda| *lambda = (*lambda * 1e6).round() / 1e6);
        lambdas.sort_by(f64::total_cmp);
        match lambdas.windows(2).find(|two| two[0] == two[1]) {
            Some(two) => Err(format!("{} nm is named twice; name each wavelength once", two[0])),
            None => Ok(Self(lambdas)),
        }
    }

    /// So many, evenly from 400 to 700 nm, both ends among them; one alone is 550 nm.
    ///
    /// # Errors
    /// Where that are none or too many.
    pub fn even(count: usize) -> Result<Self, String> {
        let [first, last] = EVEN;
        let steps = count.saturating_sub(1) as f64;
        let at = |i: usize| if count == 1 { 550.0 } else { first + (last - first) * i as f64 / steps };
        Self::new((0..count.min(MOST + 1)).map(at).collect())
    }

    /// All of them, nm, ascending.
    pub fn lambdas(&self) -> &[f64] {
        &self.0
    }

    /// The bands of each render: neighbours in threes. Where the last has fewer its last wavelength stands for those that are missing.
    pub fn threes(&self) -> impl ExactSizeIterator<Item = [f64; BANDS]> {
        self.0.chunks(BANDS).map(|some| std::array::from_fn(|band| some[band.min(some.len() - 1)]))
    }
}

/// A count, or wavelengths in nm with commas between.
impl FromStr for List {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if let Ok(count) = text.parse::<usize>()
            && count < LAMBDA_MIN as usize
        {
            return Self::even(count);
        }
        let words = text.trim_end_matches(',').split(',');
        let lambda = |word: &str| {
            let said =
                || format!("'{word}' is no wavelength; give a number of bands, or nm like 450,550,650");
            word.trim().parse::<f64>().map_err(|_| said())
        };
        Self::new(words.map(lambda).collect::<Result<_, _>>()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lambdas(text: &str) -> Vec<f64> {
        text.parse::<List>().map(|list| list.lambdas().to_vec()).unwrap_or_default()
    }

    #[test]
    fn counts_and_wavelengths_are_told_apart() {
        assert_eq!(lambdas("4"), [400.0, 500.0, 600.0, 700.0]);
        assert_eq!(lambdas("31")[..3], [400.0, 410.0, 420.0]);
        assert_eq!(lambdas("301").len(), 301);
        assert_eq!(
            (lambdas("1"), lambdas("589.29"), lambdas("550,")),
            (vec![550.0], vec![589.29], vec![550.0])
        );
        assert_eq!(lambdas("650, 450,550"), [450.0, 550.0, 650.0]);
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        for (text, said) in [
            ("0", "1 to 301"),
            ("302", "1 to 301"),
            ("359", "1 to 301"),
            ("450,350", "360 to 830"),
            ("450,nan", "360 to 830"),
            ("1e9", "360 to 830"),
            ("450,inf", "360 to 830"),
            ("-450", "360 to 830"),
            ("450,450.0000001", "named twice"),
            ("450,,550", "no wavelength"),
            ("red", "'red' is no wavelength"),
            ("", "no wavelength"),
        ] {
            let e = text.parse::<List>().expect_err(text);
            assert!(e.contains(said), "{text}: {e}");
        }
    }

    #[test]
    fn neighbours_are_rendered_together() {
        let list = List::new(vec![500.0, 400.0, 450.0, 600.0]).expect("wavelengths");
        let threes: Vec<_> = list.threes().collect();
        assert_eq!(threes, [[400.0, 450.0, 500.0], [600.0; 3]]);
        assert_eq!(List::even(31).expect("bands").threes().len(), 11);
    }
}

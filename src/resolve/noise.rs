//! Noise: what two halves of the passes tell of variance and bias.

use crate::film::Layer;

/// Where something is found rarely variance is a mean over so many pixels. Were it not, places where it was found would be shared among
/// many, and those around, where it was not, among few: light would be lost.
const POOL_RARE: f32 = 40.0;
/// Where samples are even it is one over so many.
const POOL_EVEN: f32 = 20.0;
/// Part of the doubt that is left where samples are even.
const DOUBT_EVEN: f32 = 0.25;

/// How the noise of passes behaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Noise {
    /// Paths that find something rare: single passes stand out.
    Rare,
    /// Samples that are spread evenly over the passes: both halves together have less noise than their difference tells.
    Even,
}

impl Noise {
    /// Of a layer.
    pub(super) fn of(layer: Layer) -> Self {
        match layer {
            Layer::Emission | Layer::Direct => Noise::Even,
            Layer::Caustic | Layer::Diffuse => Noise::Rare,
        }
    }

    /// Part that the mean of both halves has of the variance that their difference tells: squared errors of even samples fall by
    /// 2^1.5 where there are twice as many.
    pub(super) fn together(self) -> f32 {
        match self {
            Noise::Rare => 1.0,
            Noise::Even => std::f32::consts::FRAC_1_SQRT_2,
        }
    }

    /// Variances are means over so many pixels at least.
    pub(super) fn pool(self) -> f32 {
        match self {
            Noise::Rare => POOL_RARE,
            Noise::Even => POOL_EVEN,
        }
    }

    /// Part of the doubt that is due.
    pub(super) fn doubt(self) -> f32 {
        match self {
            Noise::Rare => 1.0,
            Noise::Even => DOUBT_EVEN,
        }
    }

    /// What two differences have in common, squared: where single passes stand out, what both halves agree on.
    pub(super) fn common(self, x: f32, y: f32) -> f32 {
        match self {
            Noise::Rare => agreed(x, y),
            Noise::Even => x * y,
        }
    }

    /// A mean square as far as it is more than chance, 0 below the square root of `doubt` of its standard errors. Their square is what
    /// noise alone would make of it, or the mean's own spread over places, where single passes stand out.
    pub(super) fn credible(self, mean: f32, by_chance: f32, spread: f32, doubt: f32) -> f32 {
        let uncertain = match self {
            Noise::Rare => by_chance.max(spread),
            Noise::Even => by_chance,
        };
        let doubt = doubt * self.doubt();
        if mean > 0.0 { mean * (1.0 - doubt * uncertain / (mean * mean)).max(0.0) } else { 0.0 }
    }
}

/// The square of the lesser of what both halves say, negative where they differ in sign: what one alone has found is nothing.
pub(super) fn agreed(x: f32, y: f32) -> f32 {
    let least = x.abs().min(y.abs());
    (least * least).copysign(x * y)
}

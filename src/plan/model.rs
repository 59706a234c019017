//! Model: what the kernels of a pass would take on a GPU, from their work and three figures of the device.
//!
//! A kernel takes as long as the slower of two things that a device does at the same time, and its dispatches beside:
//!
//! t = max(bytes / bandwidth, steps · spread / (rays a second · steps of a ray)) + dispatches · latency
//!
//! Bytes are those of [`Kernel::bytes`] and a joton's record for each of [`Kernel::tests`]; steps are the nodes and triangles that rays look
//! at. Serial work within an invocation, atomics and the occupancy of a device are not in it: docs/PERFORMANCE.md.

use super::kernels::Kernel;
use crate::error::{Error, Result};
use crate::packed::layout::Joton;

/// Nodes and triangles that a ray looks at where a device's rays a second are told.
const STEPS_OF_A_RAY: f64 = 20.0;
/// Times as long for a step of a ray that goes its own way: neighbours of its subgroup wait for each other, and caches hold other nodes.
const SPREAD: f64 = 2.0;
/// Seconds from one dispatch to the next.
const LATENCY: f64 = 5e-6;

/// A device as far as the model knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuModel {
    /// What it is called.
    pub name: String,
    /// Bytes a second of its memory.
    pub bandwidth: f64,
    /// Rays a second, traced by a kernel and not by units of their own, where neighbours go the same way.
    pub rays: f64,
}

/// What holds a kernel up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Bound {
    /// Bytes of memory.
    Bandwidth,
    /// Rays through the hierarchy.
    Traversal,
    /// Dispatches that follow each other.
    Latency,
}

impl Bound {
    /// Name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            Bound::Bandwidth => "bandwidth",
            Bound::Traversal => "traversal",
            Bound::Latency => "latency",
        }
    }
}

/// What a kernel would take.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Prediction {
    /// Milliseconds of a pass, all dispatches together.
    pub milliseconds: f64,
    /// What holds it up.
    pub bound: Bound,
}

impl GpuModel {
    /// Devices by name: an RTX 4070 and an H200, as their makers tell the bandwidth; rays a second are what traversal in kernels reaches on
    /// cards of that class, and for the H200 that in proportion to its arithmetic.
    const KNOWN: [(&'static str, f64, f64); 2] = [("rtx-4070", 0.5e12, 1.5e9), ("h200", 4.3e12, 3.5e9)];

    /// A device by its name, or by bandwidth and rays a second: `0.5T,1.5G`.
    ///
    /// # Errors
    /// [`Error::Usage`] for anything else.
    pub fn parse(text: &str) -> Result<Self> {
        if let Some((name, bandwidth, rays)) = Self::KNOWN.into_iter().find(|(name, ..)| *name == text) {
            return Ok(Self { name: name.into(), bandwidth, rays });
        }
        let figures = text.split_once(',').and_then(|(b, r)| Some([figure(b)?, figure(r)?]));
        let [bandwidth, rays] = figures.ok_or_else(|| {
            let names = Self::KNOWN.map(|(name, ..)| name).join(", ");
            let remedy = format!("give {names}, or bytes and rays a second, like 0.5T,1.5G");
            Error::usage(format!("no model of a device: {text:?}"), remedy)
        })?;
        Ok(Self { name: text.into(), bandwidth, rays })
    }

    /// What a kernel would take.
    pub fn predict(&self, kernel: &Kernel) -> Prediction {
        let bytes = kernel.bytes as f64 + kernel.tests as f64 * size_of::<Joton>() as f64;
        let spread = if kernel.is_scattered { SPREAD } else { 1.0 };
        let moved = bytes / self.bandwidth;
        let traced = kernel.steps as f64 * spread / (self.rays * STEPS_OF_A_RAY);
        let waited = kernel.dispatches as f64 * LATENCY;
        let longest = [(moved, Bound::Bandwidth), (traced, Bound::Traversal), (waited, Bound::Latency)]
            .into_iter()
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let bound = longest.map_or(Bound::Latency, |(_, bound)| bound);
        Prediction { milliseconds: (moved.max(traced) + waited) * 1e3, bound }
    }
}

/// A number above 0 with a letter for thousands, millions and so on.
fn figure(text: &str) -> Option<f64> {
    let text = text.trim();
    let factors = [('K', 1e3), ('M', 1e6), ('G', 1e9), ('T', 1e12)];
    let of = |letter: char| factors.into_iter().find(|(l, _)| *l == letter.to_ascii_uppercase());
    let (digits, factor) = match text.chars().last().and_then(of) {
        Some((_, factor)) => (&text[..text.len() - 1], factor),
        None => (text, 1.0),
    };
    digits.trim().parse::<f64>().ok().map(|x| x * factor).filter(|x| x.is_finite() && *x > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(bytes: u64, steps: u64, tests: u64, dispatches: u64, is_scattered: bool) -> Kernel {
        Kernel {
            name: "k",
            map: None,
            dispatches,
            invocations: 0,
            rays: 0,
            steps,
            tests,
            bytes,
            is_scattered,
            milliseconds: 0.0,
        }
    }

    /// The slower of memory and rays, and the dispatches beside, by hand.
    #[test]
    fn the_slower_one_counts() {
        let gpu = GpuModel::parse("1G, 1M").expect("a device");
        for (kernel, milliseconds, bound) in [
            (kernel(1_000_000, 0, 0, 2, false), 1.01, Bound::Bandwidth),
            (kernel(0, 0, 1_000_000, 0, false), 32.0, Bound::Bandwidth),
            (kernel(1_000_000, 200_000, 0, 0, false), 10.0, Bound::Traversal),
            (kernel(1_000_000, 200_000, 0, 0, true), 20.0, Bound::Traversal),
            (kernel(1000, 10, 0, 100, true), 0.501, Bound::Latency),
        ] {
            let found = gpu.predict(&kernel);
            assert!((found.milliseconds - milliseconds).abs() < 1e-9, "{kernel:?}: {found:?}");
            assert_eq!(found.bound, bound, "{kernel:?}");
        }
    }

    /// Devices have names or figures; what has neither is refused.
    #[test]
    fn devices_are_named_or_described() {
        assert_eq!(GpuModel::parse("h200").map(|m| m.bandwidth).ok(), Some(4.3e12));
        let own = GpuModel::parse("0.5T,1500M").expect("a device");
        assert_eq!((own.bandwidth, own.rays), (0.5e12, 1.5e9));
        for text in ["", "4090", "1T", "0,1G", "1T,x", "1T,-1G", "1e400,1G", "É,1"] {
            assert!(GpuModel::parse(text).is_err(), "{text:?}");
        }
    }
}

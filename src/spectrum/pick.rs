//! A wavelength of a pass, and the colour of what bands carry at such wavelengths.
//!
//! XYZ ≈ Σ_k L(λ_k) (x̄, ȳ, z̄)(λ_k) / (3 p(λ_k) ∫ ȳ dλ)  \[E34\]

use super::cie::{Matrix, apply, line_xyz, xyz_to_rgb_matrix};

/// Wavelengths of a pass: one per band.
pub const PICKS: usize = super::BANDS;

/// A wavelength of a pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// nm.
    pub lambda: f64,
    /// Which line it is, in [`super::wavelengths::Distribution::atoms`]; none where it was drawn from the density.
    pub atom: Option<usize>,
    /// Density, 1/nm, or the probability of the atom.
    pub pdf: f64,
}

impl Pick {
    /// A wavelength, nm, that was not drawn: what is seen there is measured by itself  \[E53\].
    pub fn listed(lambda: f64) -> Self {
        Self { lambda, atom: None, pdf: 1.0 }
    }
}

/// XYZ from the bands of a pass with these wavelengths: a column per band  \[E34\].
pub fn xyz_matrix(picks: &[Pick; PICKS]) -> Matrix {
    let columns = picks.map(|pick| line_xyz(pick.lambda).map(|c| c / (PICKS as f64 * pick.pdf)));
    std::array::from_fn(|row| columns.map(|c| c[row]))
}

/// Linear sRGB from the bands of a pass with these wavelengths: a column per band  \[E34\].
pub fn rgb_matrix(picks: &[Pick; PICKS]) -> Matrix {
    let (to_rgb, to_xyz) = (xyz_to_rgb_matrix(), xyz_matrix(picks));
    let columns: [[f64; 3]; PICKS] = std::array::from_fn(|k| apply(&to_rgb, to_xyz.map(|row| row[k])));
    std::array::from_fn(|row| columns.map(|c| c[row]))
}

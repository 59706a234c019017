//! Maps: the two kinds of joton maps.

/// Which of the two maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapKind {
    /// L S+ D.
    Caustic,
    /// Everything that met a D before.
    Diffuse,
}

impl MapKind {
    /// Both, in the order of a pass.
    pub const ALL: [MapKind; 2] = [MapKind::Caustic, MapKind::Diffuse];

    /// Name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            MapKind::Caustic => "caustic",
            MapKind::Diffuse => "diffuse",
        }
    }
}

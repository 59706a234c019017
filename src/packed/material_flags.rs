//! Material flags: what a material can do, as bits that both sides know.

/// What a material can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaterialFlags(pub(super) u32);

impl MaterialFlags {
    pub(crate) const DIFFUSE: u32 = 1;
    pub(crate) const GLOSSY: u32 = 2;
    pub(crate) const SPECULAR: u32 = 4;
    pub(crate) const DIELECTRIC: u32 = 8;
    pub(crate) const EMISSIVE: u32 = 16;
    pub(crate) const THIN: u32 = 32;
    pub(crate) const DISPERSIVE: u32 = 64;
    pub(crate) const FACETS: u32 = 128;
    pub(crate) const CONDUCTOR: u32 = 256;
    pub(crate) const SCHLICK: u32 = 512;
    pub(crate) const COATED: u32 = 1024;
    pub(crate) const VARIED: u32 = 2048;
    pub(crate) const MIXED: u32 = 4096;
    pub(crate) const STORES: u32 = 8192;
    pub(crate) const NORMAL_MAP: u32 = 1 << 14;
    pub(crate) const HEIGHT_MAP: u32 = 1 << 15;
    pub(crate) const RELATIVE_HEIGHT: u32 = 1 << 16;
    pub(crate) const TRANSLUCENT: u32 = 1 << 23;
    pub(crate) const ANISOTROPIC: u32 = 1 << 22;
    pub(crate) const AROUND: u32 = 1 << 21;
    pub(crate) const LAYERED: u32 = 1 << 20;
    pub(crate) const CLEAR_COAT_FOLLOWED: u32 = 1 << 19;
    pub(crate) const LAYERS_SCATTER: u32 = 1 << 18;

    /// Name and value of each bit, as the kernels know it.
    pub(super) const NAMED: [(&str, u32); 23] = [
        ("DIFFUSE", Self::DIFFUSE),
        ("GLOSSY", Self::GLOSSY),
        ("SPECULAR", Self::SPECULAR),
        ("DIELECTRIC", Self::DIELECTRIC),
        ("EMISSIVE", Self::EMISSIVE),
        ("THIN", Self::THIN),
        ("DISPERSIVE", Self::DISPERSIVE),
        ("FACETS", Self::FACETS),
        ("CONDUCTOR", Self::CONDUCTOR),
        ("SCHLICK", Self::SCHLICK),
        ("COATED", Self::COATED),
        ("VARIED", Self::VARIED),
        ("MIXED", Self::MIXED),
        ("STORES", Self::STORES),
        ("NORMAL_MAP", Self::NORMAL_MAP),
        ("HEIGHT_MAP", Self::HEIGHT_MAP),
        ("RELATIVE_HEIGHT", Self::RELATIVE_HEIGHT),
        ("TRANSLUCENT", Self::TRANSLUCENT),
        ("ANISOTROPIC", Self::ANISOTROPIC),
        ("AROUND", Self::AROUND),
        ("LAYERED", Self::LAYERED),
        ("CLEAR_COAT_FOLLOWED", Self::CLEAR_COAT_FOLLOWED),
        ("LAYERS_SCATTER", Self::LAYERS_SCATTER),
    ];

    /// Light can be scattered into all directions here: a gather point, a place for jotons.
    pub fn has_diffuse(self) -> bool {
        self.0 & (Self::DIFFUSE | Self::GLOSSY | Self::LAYERS_SCATTER) != 0
    }
    /// Jotons are stored here: some of it scatters, if only at some places, or but in part.
    pub fn stores(self) -> bool {
        self.0 & Self::STORES != 0
    }
    /// There is a Lambert lobe.
    pub fn has_lambert(self) -> bool {
        self.0 & Self::DIFFUSE != 0
    }
    /// There is a glossy lobe.
    pub fn has_glossy(self) -> bool {
        self.0 & Self::GLOSSY != 0
    }
    /// A mirror or a dielectric: light can leave in a single direction.
    pub fn has_delta(self) -> bool {
        self.0 & (Self::SPECULAR | Self::DIELECTRIC | Self::CLEAR_COAT_FOLLOWED) != 0
    }
    /// What reflects is followed in one direction, or nearly so.
    pub(crate) fn has_specular(self) -> bool {
        self.0 & Self::SPECULAR != 0
    }
    /// Light can pass through.
    pub fn is_dielectric(self) -> bool {
        self.0 & Self::DIELECTRIC != 0
    }
    /// A dielectric with both of its faces in one place: what passes is not bent \[E26\].
    pub fn is_thin(self) -> bool {
        self.0 & Self::THIN != 0
    }
    /// The index differs between the bands \[E36\].
    pub fn is_dispersive(self) -> bool {
        self.0 & Self::DISPERSIVE != 0
    }
    /// What reflects, or the interface, is of microfacets, smooth or rough: it reflects by Fresnel \[E40\].
    pub fn has_facets(self) -> bool {
        self.0 & Self::FACETS != 0
    }
    /// The microfacets are of metal.
    pub(crate) fn is_conductor(self) -> bool {
        self.0 & Self::CONDUCTOR != 0
    }
    /// The microfacets reflect by Schlick's formula.
    pub(crate) fn is_schlick(self) -> bool {
        self.0 & Self::SCHLICK != 0
    }
    /// The diffuse lobe lies under a coat \[E42\].
    pub(crate) fn is_coated(self) -> bool {
        self.0 & Self::COATED != 0
    }
    /// There is a clear coat or sheen, or the base reflects as [`crate::scene::Layers`] says.
    pub fn is_layered(self) -> bool {
        self.0 & Self::LAYERED != 0
    }
    /// The clear coat is followed as a mirror is, not gathered.
    pub(crate) fn follows_clear_coat(self) -> bool {
        self.0 & Self::CLEAR_COAT_FOLLOWED != 0
    }
    /// Roughness, or how much is metal, is looked up at each place; that decides there which of its lobes it has.
    pub fn is_varied(self) -> bool {
        self.0 & Self::VARIED != 0
    }
    /// How much of its colour is metal's is settled at each place.
    pub(crate) fn is_mixed(self) -> bool {
        self.0 & Self::MIXED != 0
    }
    /// A picture says which way it faces.
    pub fn has_relief(self) -> bool {
        self.0 & (Self::NORMAL_MAP | Self::HEIGHT_MAP) != 0
    }
    /// That picture is of normals.
    pub(crate) fn has_normal_map(self) -> bool {
        self.0 & Self::NORMAL_MAP != 0
    }
    /// Its heights are in widths of it.
    pub(crate) fn has_relative_height(self) -> bool {
        self.0 & Self::RELATIVE_HEIGHT != 0
    }
    /// Some light is scattered through to the other side \[E55\].
    pub fn is_translucent(self) -> bool {
        self.0 & Self::TRANSLUCENT != 0
    }
    /// Its microfacets are rougher one way than the other \[E56\].
    pub fn is_anisotropic(self) -> bool {
        self.0 & Self::ANISOTROPIC != 0
    }
    /// They are brushed around an axis, across which its texture coordinates are.
    pub(crate) fn is_around(self) -> bool {
        self.0 & Self::AROUND != 0
    }
    /// Light can come from the other side.
    pub(crate) fn passes_light(self) -> bool {
        self.is_dielectric() || self.is_translucent()
    }
    /// The front emits.
    pub fn is_emissive(self) -> bool {
        self.0 & Self::EMISSIVE != 0
    }
}

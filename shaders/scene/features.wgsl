// What the scene needs; the rest is compiled out.

override HAS_SMOOTH: bool = true;
override HAS_SPECULAR: bool = true;
override HAS_DIELECTRIC: bool = true;
override HAS_GLOSSY: bool = true;
// Some surface has a texture.
override HAS_TEXTURES: bool = true;
// Some surface has microfacets that vary.
override HAS_FACET_TEXTURES: bool = true;
// Some surface has a picture of normals or heights.
override HAS_RELIEF: bool = true;
// Some surface shines by a texture.
override HAS_GLOW: bool = true;
// Some of some surface is not there.
override HAS_CUTOUTS: bool = true;
// The inside of some body matters: what it absorbs, or its priority.
override HAS_MEDIA: bool = true;
// Some surface scatters light through itself.
override HAS_TRANSLUCENT: bool = true;
// Some surface is of microfacets.
override HAS_FACETS: bool = true;
// Some microfacets are rougher one way than the other.
override HAS_ANISOTROPY: bool = true;
// Some material has layers.
override HAS_LAYERS: bool = true;
// Some surface is glass in part.
override HAS_MIXTURES: bool = true;
// What the bands are differs from pass to pass.
override HAS_WAVELENGTHS: bool = true;
// Some dielectric has an index that differs between the bands.
override HAS_DISPERSION: bool = true;
// Light samples may lie in some lobe that is followed.
override HAS_FOLLOWED_LIGHT: bool = true;
override HAS_PATH_FILTER: bool = true;
// Some emitter has a warp.
override HAS_WARPS: bool = true;
// Where the camera looks is marked.
override HAS_VISIBLE_CELLS: bool = true;
// Some light is a point, a spot or a sun.
override HAS_DELTA_LIGHTS: bool = true;
// Some faces lie in one place, or so near each other that rounded distances do not tell which a ray meets first.
override HAS_CONTACTS: bool = true;

//! Assembly: meshes and shapes are put together, with the materials that they use.

use super::glass::{self, Origin};
use super::mtl::{Kind, RawMaterial, RawSpectra};
use super::obj::{ObjFile, UsedMaterial};
use super::scene_file::{Called, MadeOf, MaterialEntry};
use super::texture::fit;
use super::texture::store::Store;
use super::warnings::{Named, Warnings, listed};
use super::{Anisotropy, Material, Mesh, layers, material, rule, text};
use crate::{Error, Result};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Names that an error lists.
const NAMES_TOLD: usize = 20;
/// Name of the material of faces that name none.
const UNNAMED: &str = "(none)";

/// What is put together so far.
pub(super) struct Assembly<'a> {
    mesh: Mesh,
    materials: Vec<Material>,
    /// For each material where it is used first.
    origins: Vec<Origin>,
    overrides: &'a [MaterialEntry],
    /// Overrides by what they are of, in their order.
    overrides_of: HashMap<(Called, &'a str), Vec<&'a RawMaterial>>,
    /// Materials that shapes and whole meshes name, by name.
    named: HashMap<&'a str, u32>,
    /// The material of the faces of each file begins at.
    first_of: HashMap<PathBuf, u32>,
    /// Names of materials that some face uses, each once.
    used: Vec<String>,
    /// Pictures on surfaces.
    textures: Store,
    is_used: HashSet<(Called, String)>,
}

impl<'a> Assembly<'a> {
    pub(super) fn new(overrides: &'a [MaterialEntry]) -> Self {
        let mut overrides_of: HashMap<_, Vec<&RawMaterial>> = HashMap::new();
        for MaterialEntry { of, raw } in overrides {
            overrides_of.entry((*of, raw.name.as_str())).or_default().push(raw);
        }
        let (mesh, materials, origins, named, first_of, used, is_used, textures) = Default::default();
        Self { mesh, materials, origins, overrides, overrides_of, named, first_of, used, is_used, textures }
    }

    /// The objects and groups that something is said of.
    pub(super) fn objects(&self) -> HashSet<&'a str> {
        let all = self.overrides_of.keys();
        all.filter(|(of, _)| *of == Called::Object).map(|(_, name)| *name).collect()
    }

    /// The pictures that were read.
    pub(super) fn pictures(&self) -> &[PathBuf] {
        &self.textures.files
    }

    /// The whole, its glass settled.
    pub(super) fn finish(mut self, warnings: &mut Warnings) -> (Mesh, Vec<Material>) {
        glass::settle(&mut self.mesh, &mut self.materials, &self.origins, warnings);
        material::number_rests(&mut self.materials);
        self.settle_uvs(warnings);
        (self.mesh, self.materials)
    }

    /// Texture coordinates are kept where some material has textures; a warning tells which triangles of such have none.
    fn settle_uvs(&mut self, warnings: &mut Warnings) {
        if !self.materials.iter().any(|m| m.has_texture() || m.anisotropy.is_some()) {
            self.mesh.uvs = Vec::new();
            self.mesh.triangles.iter_mut().for_each(|t| t.uv = None);
            return;
        }
        let mut is_told = vec![false; self.materials.len()];
        for t in &self.mesh.triangles {
            let i = t.material as usize;
            let material = &self.materials[i];
            if t.uv.is_none() && material.has_texture() && !std::mem::replace(&mut is_told[i], true) {
                let kind = Named {
                    noun: ["material", "materials"],
                    what: [
                        " has a texture, and faces without texture coordinates: they show its lower left corner",
                        " have textures, and faces without texture coordinates: they show the lower left corner",
                    ],
                };
                // the last ones were made of others, when glass was settled
                let file = self.origins.get(i).map_or(Path::new(""), |origin| &origin.file);
                let line = self.origins.get(i).map(|origin| origin.line);
                warnings.add_named(file, line, kind, &material.name, String::new);
            }
        }
    }

    /// Where the materials of a file begin, which are looked up once.
    pub(super) fn materials_of(
        &mut self,
        file: &ObjFile,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Result<u32> {
        if let Some(&first) = self.first_of.get(path) {
            return Ok(first);
        }
        let mut library: HashMap<&str, &RawMaterial> = HashMap::new();
        for raw in &file.library {
            library.insert(&raw.name, raw);
            // A comment may follow the name.
            if let Some((name, _)) = raw.name.split_once(" #") {
                library.entry(name.trim()).or_insert(raw);
            }
        }
        let first = self.materials.len() as u32;
        for used in &file.materials {
            match self.stated(used, &library, path, warnings) {
                Some(raw) => self.push_stated(&raw, path, used.line, warnings)?,
                None => self.push_grey(used.name.as_deref(), path, used.line),
            };
        }
        self.first_of.insert(path.to_owned(), first);
        Ok(first)
    }

    /// The material that a shape or a whole mesh is said to be made of; none where nothing is said.
    pub(super) fn made_of(
        &mut self,
        made_of: &'a MadeOf,
        scene: &Path,
        line: usize,
        warnings: &mut Warnings,
    ) -> Result<Option<u32>> {
        let (name, raw) = match made_of {
            MadeOf::Nothing => return Ok(None),
            MadeOf::Own(raw) => return self.push_stated(raw, scene, line, warnings).map(Some),
            MadeOf::Named(name) => match self.named.get(name.value.as_str()) {
                Some(&known) => return Ok(Some(known)),
                None => (name, self.overridden(None, Called::Material, &name.value)),
            },
        };
        let Some(raw) = raw else {
            let all =
                || self.overrides.iter().filter(|o| o.of == Called::Material).map(|o| o.raw.name.as_str());
            let remedy = match text::did_you_mean(&name.value, all()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("add [[material]] with name = \"{}\"", name.value),
            };
            let what = format!("no [[material]] is called \"{}\"", name.value);
            return Err(Error::scene(scene, Some(name.line), what, remedy));
        };
        let index = self.push_stated(&raw, scene, line, warnings)?;
        self.named.insert(&name.value, index);
        Ok(Some(index))
    }

    /// The same material where it is brushed around the axis of a shape; nothing where it is not brushed, or has pictures.
    pub(super) fn around(&mut self, material: u32) -> Option<u32> {
        let stated = &self.materials[material as usize];
        let anisotropy = stated.anisotropy.filter(|_| !stated.has_texture())?;
        let mut around = stated.clone();
        let rest = around.mixture.as_mut().map(|mixture| &mut mixture.rest.anisotropy);
        for brushed in [Some(&mut around.anisotropy), rest].into_iter().flatten() {
            *brushed = Some(Anisotropy { is_around: true, ..anisotropy });
        }
        if let Some(known) = self.materials.iter().position(|m| *m == around) {
            return Some(known as u32);
        }
        let origin = self.origins[material as usize].clone();
        Some(self.push(around, origin))
    }

    /// Adds the material of what says nothing of it; its number.
    pub(super) fn push_grey(&mut self, name: Option<&str>, path: &Path, line: usize) -> u32 {
        let material = Material::matte(name.unwrap_or(UNNAMED), super::material::GREY);
        self.push(material, Origin { file: path.to_owned(), line, thin: None })
    }

    /// Adds a material as it is stated, and tells where it is used first; its number.
    fn push_stated(
        &mut self,
        raw: &RawMaterial,
        path: &Path,
        line: usize,
        warnings: &mut Warnings,
    ) -> Result<u32> {
        let material = rule::material(raw, &mut self.textures, warnings)?;
        let has_pictures = material.has_texture();
        if let Some(thin) = raw.thin.filter(|_| material.dielectric.is_none()) {
            let what = format!("material \"{}\": thin says nothing of what is no glass", raw.name);
            warnings.add(&raw.file, Some(thin.line), what);
        }
        let thin = raw.thin.map(|thin| thin.value);
        let number = self.push(material, Origin { file: path.to_owned(), line, thin });
        if has_pictures && let Some(most) = fit::room(0) {
            self.textures.make_room(most, &mut self.materials);
        }
        Ok(number)
    }

    fn push(&mut self, material: Material, origin: Origin) -> u32 {
        self.materials.push(material);
        self.origins.push(origin);
        self.materials.len() as u32 - 1
    }

    /// A material with what the scene file states of what is called so.
    fn overridden(&mut self, raw: Option<RawMaterial>, of: Called, name: &str) -> Option<RawMaterial> {
        if self.is_used.insert((of, name.to_owned())) && of == Called::Material {
            self.used.push(name.to_owned());
        }
        let stated = self.overrides_of.get(&(of, name)).into_iter().flatten();
        stated.fold(raw, |raw, &stated| {
            Some(match raw {
                Some(raw) if stated.kind.is_none() => raw.overridden_by(stated),
                _ => stated.clone(),
            })
        })
    }

    /// Adds triangles whose materials begin at `first_material`.
    pub(super) fn add(&mut self, mesh: Mesh, first_material: u32, path: &Path) -> Result<()> {
        let offset = |count: usize| {
            u32::try_from(count).map_err(|_| {
                Error::scene(path, None, "more than 4 294 967 295 vertices", "use fewer or smaller meshes")
            })
        };
        offset(self.mesh.positions.len() + mesh.positions.len())?;
        offset(self.mesh.normals.len() + mesh.normals.len())?;
        offset(self.mesh.uvs.len() + mesh.uvs.len())?;
        let first_vertex = offset(self.mesh.positions.len())?;
        let first_normal = offset(self.mesh.normals.len())?;
        let first_uv = offset(self.mesh.uvs.len())?;
        self.mesh.positions.extend(mesh.positions);
        self.mesh.normals.extend(mesh.normals);
        self.mesh.uvs.extend(mesh.uvs);
        self.mesh.triangles.extend(mesh.triangles.into_iter().map(|mut t| {
            t.vertex = t.vertex.map(|v| v + first_vertex);
            t.normal = t.normal.map(|n| n.map(|n| n + first_normal));
            t.uv = t.uv.map(|uv| uv.map(|i| i + first_uv));
            t.material += first_material;
            t
        }));
        Ok(())
    }

    /// What is stated of a material that faces use; none, with a warning, where that is nothing.
    fn stated(
        &mut self,
        used: &UsedMaterial,
        library: &HashMap<&str, &RawMaterial>,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Option<RawMaterial> {
        let of_objects = |this: &mut Self, raw| {
            used.objects.iter().fold(raw, |raw, object| this.overridden(raw, Called::Object, object))
        };
        let Some(name) = &used.name else {
            let raw = of_objects(self, None);
            if raw.is_none() {
                warnings.add(path, Some(used.line), "faces without a material are matte grey 0.5");
            }
            return raw;
        };
        let name_alone = name.split_once(" #").map_or(name.as_str(), |(name, _)| name.trim());
        let defined = library.get(name.as_str()).or_else(|| library.get(name_alone)).copied();
        let raw = self.overridden(defined.cloned(), Called::Material, name);
        let raw = of_objects(self, raw);
        if raw.is_none() {
            let kind = Named {
                noun: ["material", "materials"],
                what: [" is not defined; it is matte grey 0.5", " are not defined; they are matte grey 0.5"],
            };
            let hint = || {
                let near = text::did_you_mean(name, library.keys().copied());
                near.map_or(String::new(), |near| format!(" (did you mean \"{near}\"?)"))
            };
            warnings.add_named(path, Some(used.line), kind, name, hint);
        }
        raw
    }

    /// An override that meets nothing is a slip.
    pub(super) fn check_overrides<'f>(&self, files: impl Iterator<Item = &'f ObjFile>) -> Result<()> {
        let is_lost = |o: &&MaterialEntry| !self.is_used.contains(&(o.of, o.raw.name.clone()));
        let Some(MaterialEntry { of, raw: lost }) = self.overrides.iter().find(is_lost) else {
            return Ok(());
        };
        let (what, names, noun) = match of {
            Called::Material => ("uses material", self.used.clone(), "materials in use are"),
            Called::Object => {
                let names: BTreeSet<&String> = files.flat_map(|file| &file.object_names).collect();
                ("has an object or group", names.into_iter().cloned().collect(), "there are")
            }
        };
        let remedy = match text::did_you_mean(&lost.name, names.iter().map(String::as_str)) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None if names.is_empty() => "leave it out".to_owned(),
            None => format!("{noun} {}", listed(&names[..names.len().min(NAMES_TOLD)], names.len())),
        };
        let what = format!("no mesh {what} \"{}\"", lost.name);
        Err(Error::scene(&lost.file, Some(lost.line), what, remedy))
    }
}

impl RawMaterial {
    /// This material with what another states in place of its own.
    fn overridden_by(self, other: &RawMaterial) -> RawMaterial {
        // either of a colour and its texture replaces both
        let colours = other.kd.is_some() || other.map_kd.is_some();
        let (kd, map_kd, textured) = if colours {
            (other.kd, other.map_kd.clone(), other.textured)
        } else {
            (self.kd, self.map_kd, self.textured)
        };
        let opacities = other.opacity.is_some() || other.map_d.is_some();
        let (opacity, map_d) =
            if opacities { (other.opacity, other.map_d.clone()) } else { (self.opacity, self.map_d) };
        let emissions = other.ke.is_some() || other.map_ke.is_some();
        let (ke, map_ke) = if emissions { (other.ke, other.map_ke.clone()) } else { (self.ke, self.map_ke) };
        // a relief replaces another, of whatever kind
        let reliefs = other.norm.is_some() || other.bump.is_some();
        let (norm, bump) =
            if reliefs { (other.norm.clone(), other.bump.clone()) } else { (self.norm, self.bump) };
        // each of roughness, α, exponent and their textures replaces the others
        let states_roughness = other.pr.or(other.alpha).is_some() || other.map_pr.is_some();
        let map_pr = if states_roughness || other.ns.is_some() { other.map_pr.clone() } else { self.map_pr };
        let states_metal = other.pm.is_some() || other.map_pm.is_some();
        // a statement replaces another whole, by wavelength or not
        let theirs = other.spectra.clone();
        let spectra = RawSpectra {
            kd: if colours { theirs.kd } else { self.spectra.kd.clone() },
            ks: if other.ks.is_some() { theirs.ks } else { self.spectra.ks.clone() },
            tf: if other.tf.is_some() { theirs.tf } else { self.spectra.tf.clone() },
            transmit: if other.transmit.is_some() { theirs.transmit } else { self.spectra.transmit.clone() },
            ke: if emissions { theirs.ke } else { self.spectra.ke.clone() },
            absorption: if other.absorption.is_some() {
                theirs.absorption
            } else {
                self.spectra.absorption.clone()
            },
            ni: if other.ni.is_some() { theirs.ni } else { self.spectra.ni.clone() },
        };
        // a lobe that is stated replaces Blender's
        let has_lobe = other.ks.is_some() || other.ns.is_some();
        let is_replaced = self.is_of_blender && self.kind == Some(Kind::Principled) && has_lobe;
        RawMaterial {
            kind: self.kind.filter(|_| !is_replaced),
            file: other.file.clone(),
            line: other.line,
            thin: other.thin.or(self.thin),
            kd,
            ks: other.ks.or(self.ks),
            ke,
            map_ke,
            tf: other.tf.or(self.tf),
            transmit: other.transmit.or(self.transmit),
            ni: other.ni.or(self.ni),
            ns: other.ns.or(if states_roughness { None } else { self.ns }),
            pr: other.pr.or(if other.ns.is_some() || states_roughness { None } else { self.pr }),
            alpha: other.alpha.or(if other.ns.is_some() || states_roughness { None } else { self.alpha }),
            aniso: other.aniso.or(self.aniso),
            anisor: other.anisor.or(self.anisor),
            pm: if states_metal { other.pm } else { self.pm.filter(|_| !is_replaced) },
            norm,
            bump,
            map_pr,
            map_pm: if states_metal { other.map_pm.clone() } else { self.map_pm.filter(|_| !is_replaced) },
            metal: if other.eta.is_some() { None } else { other.metal.clone().or(self.metal) },
            eta: other.eta.or(self.eta),
            k: other.k.or(self.k),
            saturated: other.saturated.or(self.saturated),
            absorption: other.absorption.or(self.absorption),
            priority: other.priority.or(self.priority),
            map_transmission: match other.layers.transmission {
                Some(_) => None,
                None => other.map_transmission.clone().or(self.map_transmission),
            },
            map_kd,
            textured,
            opacity,
            map_d,
            spectra,
            layers: layers::overridden(self.layers, &other.layers),
            ..self
        }
    }
}

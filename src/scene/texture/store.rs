//! Store: finds and reads the pictures that textures show, each once.

use super::decode::{self, Picture};
use super::stated::{Source, StatedTexture};
use super::{Bitmap, NumberMap, Space, Texels, Texture, f16, fit};
use crate::scene::Material;
use crate::scene::finder::Finder;
use crate::scene::warnings::{Named, Warnings};
use crate::{Error, Result};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a texture is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Role {
    /// Colour: its red, green and blue.
    Colour,
    /// Opacity: its own, or its luminance where it has none.
    Opacity,
    /// Numbers of whatever kind: in proportion to what they say.
    Number,
    /// What shines: its red, green and blue, which may be more than one.
    Emission,
}

impl Role {
    /// How numbers of a file without a space of its own are meant.
    fn space(self, stated: &StatedTexture) -> Space {
        match self {
            Self::Opacity | Self::Number => Space::Linear,
            Self::Colour | Self::Emission => stated.space.unwrap_or(Space::Srgb),
        }
    }

    /// What stands in place of a picture that cannot be had.
    fn plain(self) -> &'static str {
        match self {
            Self::Colour | Self::Opacity | Self::Emission => "the plain colour is",
            Self::Number => "the plain value is",
        }
    }
}

/// A picture as it is asked for: file, what it is of, the bits of the range that it is put into, and whether it is linear after that.
type Key = (PathBuf, Role, [u32; 2], Space);

/// Pictures that were read.
#[derive(Debug, Default)]
pub(crate) struct Store {
    finders: HashMap<PathBuf, Finder>,
    read: HashMap<PathBuf, Result<Picture, String>>,
    /// Those that are not used as they were read.
    derived: HashMap<Key, Arc<Bitmap>>,
    boards: Vec<Arc<Bitmap>>,
    /// Their files, in the order in which they were read.
    pub(crate) files: Vec<PathBuf>,
}

impl Store {
    /// Make pictures smaller until all that were read take at most so many bytes: here, and on these materials.
    pub(crate) fn make_room(&mut self, most: u64, materials: &mut [Material]) {
        let mut derived: Vec<(&Key, &Arc<Bitmap>)> = self.derived.iter().collect();
        derived.sort_by_key(|(key, _)| *key);
        let read = self.files.iter().filter_map(|path| self.read.get(path)?.as_ref().ok());
        let all = read.map(|picture| &picture.bitmap).chain(derived.into_iter().map(|(_, bitmap)| bitmap));
        if all.clone().map(|bitmap| bitmap.bytes()).sum::<u64>() <= most {
            return;
        }
        let spaces: HashMap<usize, Space> = fit::pictures(materials)
            .into_iter()
            .map(|(bitmap, space)| (fit::address(bitmap), space))
            .collect();
        let space = |bitmap| spaces.get(&fit::address(bitmap)).copied().unwrap_or(Space::Srgb);
        let by = fit::smaller(all.map(|bitmap| (bitmap, space(bitmap))), most);
        let read = self.read.values_mut().filter_map(|read| read.as_mut().ok());
        for bitmap in read.map(|picture| &mut picture.bitmap).chain(self.derived.values_mut()) {
            if let Some(smaller) = by.get(&fit::address(bitmap)) {
                *bitmap = smaller.clone();
            }
        }
        fit::replace(materials, &by);
    }
}

impl Store {
    /// The texture that is stated; none, with a warning, where its picture cannot be had.
    ///
    /// # Errors
    /// [`Error::Scene`] where that is no warning: where a scene file states it.
    pub(crate) fn texture(
        &mut self,
        stated: &StatedTexture,
        role: Role,
        warnings: &mut Warnings,
    ) -> Result<Option<Texture>> {
        let bitmap = match &stated.source {
            Source::Board(colours) => self.board(*colours, role),
            Source::File(name) => {
                let Some(path) = self.find(stated, name) else {
                    if stated.is_required {
                        let what = format!("texture {name} does not exist");
                        let remedy = "names are relative to the scene file";
                        return Err(Error::scene(&stated.file, Some(stated.line), what, remedy));
                    }
                    let plain = role.plain();
                    let what = ["is", "are"].map(|is| format!(" {is} not found; {plain} used"));
                    let kind = Named { noun: ["texture", "textures"], what: [&what[0], &what[1]] };
                    warnings.add_named(&stated.file, Some(stated.line), kind, name, String::new);
                    return Ok(None);
                };
                match self.bitmap(&path, role, stated, warnings) {
                    Ok(bitmap) => bitmap,
                    Err(what) if stated.is_required => {
                        let remedy = "name another one, or leave the texture out";
                        return Err(Error::scene(&stated.file, Some(stated.line), what, remedy));
                    }
                    Err(what) => {
                        let what = format!("{what}; {} used", role.plain());
                        warnings.add(&stated.file, Some(stated.line), what);
                        return Ok(None);
                    }
                }
            }
        };
        let space = match &bitmap.texels {
            Texels::Halves(_) => Space::Linear,
            Texels::Bytes(_) => role.space(stated),
        };
        let StatedTexture { wrap, filter, scale, offset, .. } = *stated;
        Ok(Some(Texture { bitmap, space, wrap, filter, scale, offset }))
    }

    /// The number that is stated to vary over a surface; none, with a warning, where its picture cannot be had.
    ///
    /// # Errors
    /// As [`Store::texture`].
    pub(crate) fn number(
        &mut self,
        stated: &StatedTexture,
        warnings: &mut Warnings,
    ) -> Result<Option<NumberMap>> {
        let texture = self.texture(stated, Role::Number, warnings)?;
        Ok(texture.map(|texture| NumberMap { texture, channel: stated.channel, factor: stated.factor }))
    }

    fn board(&mut self, colours: [[f32; 3]; 2], role: Role) -> Arc<Bitmap> {
        let mut board = Bitmap::board(colours);
        if role == Role::Opacity {
            board = derived(&board, role, [0.0, 1.0], Space::Linear);
        }
        if let Some(known) = self.boards.iter().find(|known| ***known == board) {
            return known.clone();
        }
        self.boards.push(Arc::new(board));
        self.boards[self.boards.len() - 1].clone()
    }

    /// The file that a name means; what follows a `#` may be a comment.
    fn find(&mut self, stated: &StatedTexture, name: &str) -> Option<PathBuf> {
        let folder = stated.file.parent().unwrap_or(Path::new("")).to_owned();
        let finder = self.finders.entry(folder.clone()).or_insert_with(|| Finder::new(folder));
        let alone = name.split_once(" #").map(|(name, _)| name);
        finder.find(name).or_else(|| finder.find(alone?))
    }

    fn bitmap(
        &mut self,
        path: &Path,
        role: Role,
        stated: &StatedTexture,
        warnings: &mut Warnings,
    ) -> Result<Arc<Bitmap>, String> {
        if !self.read.contains_key(path) {
            self.files.push(path.to_owned());
            self.read.insert(path.to_owned(), decode::read(path).map_err(|error| error.to_string()));
        }
        let Picture { bitmap, is_wide, may_be_encoded } = match self.read.get(path) {
            Some(read) => read.clone()?,
            None => return Err(format!("{} was not read", path.display())),
        };
        let is_cut = is_wide && role != Role::Emission;
        if is_cut {
            let what = format!("texture {} has values outside of 0 to 1", path.display());
            let what = format!("{what}, more than is reflected; they are cut");
            warnings.add(&stated.file, Some(stated.line), what);
        }
        let encoded = if may_be_encoded { role.space(stated) } else { Space::Linear };
        let is_plain = stated.range == [0.0, 1.0] && !is_cut && encoded == Space::Linear;
        if is_plain && (role != Role::Opacity || has_opacity(&bitmap)) {
            return Ok(bitmap);
        }
        let key = (path.to_owned(), role, stated.range.map(f32::to_bits), encoded);
        let derive = || Arc::new(derived(&bitmap, role, stated.range, encoded));
        Ok(self.derived.entry(key).or_insert_with(derive).clone())
    }
}

/// True where some texel is not opaque.
fn has_opacity(bitmap: &Bitmap) -> bool {
    match &bitmap.texels {
        Texels::Bytes(texels) => texels.iter().any(|t| t[3] < u8::MAX),
        Texels::Halves(texels) => texels.iter().any(|t| t[3] < f16::ONE),
    }
}

/// Luminance of the primaries of sRGB.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// A picture with its numbers put into a range; as opacity where it is to be that and has none. Half floats are made linear where they
/// are `encoded`.
fn derived(bitmap: &Bitmap, role: Role, [base, gain]: [f32; 2], encoded: Space) -> Bitmap {
    let by_luminance = role == Role::Opacity && !has_opacity(bitmap);
    let texel = |[r, g, b, a]: [f32; 4]| {
        let ranged = |x: f32| (base + gain * x).clamp(0.0, 1.0);
        let luminance = r * LUMINANCE[0] + g * LUMINANCE[1] + b * LUMINANCE[2];
        match (role, by_luminance) {
            (Role::Colour, _) => [ranged(r), ranged(g), ranged(b), a],
            (Role::Emission, _) => {
                let [r, g, b] = [r, g, b].map(|x| (base + gain * x).clamp(0.0, f32::from(f16::MAX)));
                [r, g, b, a]
            }
            (Role::Number, _) => [r, g, b, a].map(ranged),
            (Role::Opacity, true) => [ranged(luminance); 4],
            (Role::Opacity, false) => [ranged(a); 4],
        }
    };
    let texels = match &bitmap.texels {
        Texels::Bytes(texels) => {
            let byte = |x: f32| (x * 255.0).round().min(255.0) as u8;
            Texels::Bytes(texels.iter().map(|t| texel(t.map(|x| f32::from(x) / 255.0)).map(byte)).collect())
        }
        Texels::Halves(texels) => {
            let linear = |[r, g, b, a]: [f32; 4]| {
                let [r, g, b] = [r, g, b].map(|x| encoded.to_linear(x));
                [r, g, b, a]
            };
            Texels::Halves(
                texels.iter().map(|t| linear(texel(t.map(f32::from))).map(f16::from_f32)).collect(),
            )
        }
    };
    Bitmap { size: bitmap.size, texels, file: bitmap.file.clone() }
}

//! Stated: what a file says of a texture, before its picture is looked for.

use super::{Channel, Filter, Space, Wrap};
use std::path::PathBuf;

/// What a texture shows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Source {
    /// A picture, by its name.
    File(String),
    /// Squares of two colours.
    Board([[f32; 3]; 2]),
}

/// A texture as a file states it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StatedTexture {
    /// What it shows.
    pub(crate) source: Source,
    /// The file that says so; names of pictures are relative to it.
    pub(crate) file: PathBuf,
    /// Line there.
    pub(crate) line: usize,
    /// Factor on texture coordinates.
    pub(crate) scale: [f32; 2],
    /// What is added to them after that.
    pub(crate) offset: [f32; 2],
    /// What lies outside of it.
    pub(crate) wrap: Wrap,
    /// What lies between its texels.
    pub(crate) filter: Filter,
    /// How its colours are meant, where that is said.
    pub(crate) space: Option<Space>,
    /// What a number of 0 in the picture means, and how much more one of 1.
    pub(crate) range: [f32; 2],
    /// Which of a texel's numbers counts where one is asked for …
    pub(crate) channel: Channel,
    /// … and a factor on it.
    pub(crate) factor: f32,
    /// How strong a relief is.
    pub(crate) relief: f32,
    /// The user asked for it by itself: a fault is an error.
    pub(crate) is_required: bool,
}

impl StatedTexture {
    /// All of a picture, again and again.
    pub(crate) fn of(source: Source, file: PathBuf, line: usize) -> Self {
        Self {
            source,
            file,
            line,
            scale: [1.0; 2],
            offset: [0.0; 2],
            wrap: Wrap::Repeat,
            filter: Filter::Linear,
            space: None,
            range: [0.0, 1.0],
            channel: Channel::Red,
            factor: 1.0,
            relief: 1.0,
            is_required: false,
        }
    }

    /// What it shows, in words.
    pub(crate) fn what(&self) -> &str {
        match &self.source {
            Source::File(name) => name,
            Source::Board(_) => "the board",
        }
    }

    /// Reads what follows `map_Kd` and its like: options, then the name of a file, which may hold spaces.
    pub(crate) fn parse(rest: &str, file: PathBuf, line: usize) -> Result<Self, &'static str> {
        let mut texture = Self::of(Source::File(String::new()), file, line);
        let mut rest = rest.trim();
        while let Some((option, after)) = split_word(rest) {
            let Some((_, [least, most])) =
                OPTIONS.into_iter().find(|(name, _)| option.eq_ignore_ascii_case(name))
            else {
                break;
            };
            rest = after;
            let mut values: Vec<&str> = Vec::new();
            while values.len() < most {
                // the last word is the name
                let Some((word, after)) = split_word(rest).filter(|(_, after)| !after.is_empty()) else {
                    break;
                };
                if values.len() >= least && word.parse::<f32>().is_err() {
                    break;
                }
                values.push(word);
                rest = after;
            }
            if values.len() < least {
                return Err("an option without its values");
            }
            texture.apply(&option.to_ascii_lowercase(), &values)?;
        }
        if rest.is_empty() {
            return Err("no file is named");
        }
        texture.source = Source::File(rest.to_owned());
        Ok(texture)
    }

    fn apply(&mut self, option: &str, values: &[&str]) -> Result<(), &'static str> {
        let number = |i: usize, default: f32| match values.get(i) {
            None => Ok(default),
            Some(word) => match word.parse::<f32>() {
                Ok(x) if x.abs() <= COORDINATE_MOST => Ok(x),
                _ => Err("an option whose value is no finite number"),
            },
        };
        match option {
            "-s" => self.scale = [number(0, 1.0)?, number(1, 1.0)?],
            "-o" => self.offset = [number(0, 0.0)?, number(1, 0.0)?],
            "-bm" => self.relief = number(0, 1.0)?,
            "-mm" => self.range = [number(0, 0.0)?, number(1, 1.0)?],
            "-clamp" if values[0].eq_ignore_ascii_case("on") => self.wrap = Wrap::Clamp,
            "-imfchan" => {
                self.channel = match values[0] {
                    "g" => Channel::Green,
                    "b" => Channel::Blue,
                    "m" => Channel::Alpha,
                    // of a grey picture luminance is any of the three
                    _ => Channel::Red,
                }
            }
            "-colorspace" => {
                let is_srgb = values[0].eq_ignore_ascii_case("srgb");
                self.space = Some(if is_srgb { Space::Srgb } else { Space::Linear });
            }
            _ => {}
        }
        Ok(())
    }
}

/// Largest texture coordinate, scale and offset: their products are finite.
pub(crate) const COORDINATE_MOST: f32 = 1e6;

/// Options of MTL, and how many values each has: at least, and at most. Those that say nothing of colour are passed over.
const OPTIONS: [(&str, [usize; 2]); 14] = [
    ("-blendu", [1, 1]),
    ("-blendv", [1, 1]),
    ("-bm", [1, 1]),
    ("-boost", [1, 1]),
    ("-cc", [1, 1]),
    ("-clamp", [1, 1]),
    ("-colorspace", [1, 1]),
    ("-imfchan", [1, 1]),
    ("-mm", [2, 2]),
    ("-o", [1, 3]),
    ("-s", [1, 3]),
    ("-t", [1, 3]),
    ("-texres", [1, 2]),
    ("-type", [1, 1]),
];

/// The first word and what follows it, trimmed.
fn split_word(text: &str) -> Option<(&str, &str)> {
    if text.is_empty() {
        return None;
    }
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    Some((word, rest.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(rest: &str) -> Result<StatedTexture, &'static str> {
        StatedTexture::parse(rest, PathBuf::new(), 7)
    }

    fn name(rest: &str) -> String {
        let Source::File(name) = parse(rest).expect("a texture").source else { panic!("a file") };
        name
    }

    /// Names keep their spaces; options are taken off before them, however many values they have.
    #[test]
    fn names_follow_options() {
        assert_eq!(name("a picture with spaces.jpg"), "a picture with spaces.jpg");
        assert_eq!(name("-o 0.1 diffuse.jpg"), "diffuse.jpg");
        assert_eq!(name("-s 2 3 4 5.png"), "5.png");
        assert_eq!(name("-bm 0.5 -texres 512 input.jpg"), "input.jpg");
        assert_eq!(name("-type cube_right -blendu on -mm 0 1 my file.png"), "my file.png");
        assert_eq!(name("-unknown.png"), "-unknown.png");
    }

    /// What options say is kept.
    #[test]
    fn options_say_how_it_lies() {
        let t = parse("-clamp on -s 2 3 1 -o 0.5 0.25 -mm 0.1 0.9 -colorspace linear a.png").expect("read");
        assert_eq!((t.scale, t.offset, t.wrap), ([2.0, 3.0], [0.5, 0.25], Wrap::Clamp));
        assert_eq!((t.range, t.space), ([0.1, 0.9], Some(Space::Linear)));
        assert_eq!(parse("-s 2 a.png").expect("read").scale, [2.0, 1.0]);
    }

    /// What names nothing, or says numbers that are none, is refused.
    #[test]
    fn what_is_no_texture_is_refused() {
        for rest in ["", "   ", "-s 1 2 3", "-clamp", "-mm 0.5 x a.png", "-s nan 1 a.png", "-o 1e30 a.png"] {
            let found = parse(rest);
            assert!(found.is_err() || rest == "-s 1 2 3", "{rest}: {found:?}");
        }
        // the last word is the name, whatever it looks like
        assert_eq!(name("-s 1 2 3"), "3");
    }
}

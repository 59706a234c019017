//! Versus: other renderers from the Python package index measured on the same scene in the same sitting.
//!
//! Each has a driver in Python here, which renders an exported scene and tells of its pictures line by line
//! (`line`); `measure` runs it and compares the pictures as joton's own are.

mod line;
mod run;

pub use line::Line;
pub use run::{PeerScene, check, measure};

use crate::error::{Error, Result};

/// Where an algorithm can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fit {
    /// Everywhere, and it is worth a look everywhere.
    All,
    /// It misses light or has nothing to offer where surfaces mirror or refract.
    Matte,
    /// It is made for scenes where surfaces mirror or refract.
    Specular,
}

/// An algorithm of another renderer.
#[derive(Debug, PartialEq, Eq)]
struct Mode {
    name: &'static str,
    fit: Fit,
    /// It misses light where surfaces mirror or refract.
    blind: bool,
}

/// What decides which renderers and algorithms a scene is for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traits {
    /// Some surface mirrors or refracts.
    pub specular: bool,
    /// There is a spot.
    pub spots: bool,
}

/// Another renderer.
#[derive(Debug, PartialEq, Eq)]
pub struct Renderer {
    /// As in `--versus`.
    pub name: &'static str,
    /// What pip installs.
    pub packages: &'static str,
    /// Its driver: file name and text.
    driver: (&'static str, &'static str),
    modes: &'static [Mode],
    /// Its spots are as bright in all directions as ours.
    spots: bool,
}

/// What drivers share: file names and texts.
const SHARED: [(&str, &str); 2] =
    [("driving.py", include_str!("driving.py")), ("driving_mitsuba.py", include_str!("driving_mitsuba.py"))];

/// All that there are drivers for.
pub const RENDERERS: [Renderer; 3] = [
    Renderer {
        name: "mitsuba",
        packages: "mitsuba",
        driver: ("drive_mitsuba.py", include_str!("drive_mitsuba.py")),
        modes: &[
            Mode { name: "path", fit: Fit::All, blind: false },
            // light that reaches the eye over a mirror or through glass cannot be splatted
            Mode { name: "ptracer", fit: Fit::Matte, blind: true },
        ],
        spots: true,
    },
    Renderer {
        name: "mitsuba+oidn",
        packages: "mitsuba pyoidn",
        driver: ("drive_mitsuba_oidn.py", include_str!("drive_mitsuba_oidn.py")),
        modes: &[
            Mode { name: "path", fit: Fit::All, blind: false },
            // albedo and normals of a mirror or a pane say nothing of what is seen there
            Mode { name: "path-colour", fit: Fit::Specular, blind: false },
        ],
        spots: true,
    },
    Renderer {
        name: "luxcore",
        packages: "pyluxcore",
        driver: ("drive_luxcore.py", include_str!("drive_luxcore.py")),
        modes: &[
            Mode { name: "path", fit: Fit::Matte, blind: false },
            Mode { name: "photongi", fit: Fit::Specular, blind: false },
            Mode { name: "bidirvm", fit: Fit::Specular, blind: false },
        ],
        // brighter by one over the cosine off the axis
        spots: false,
    },
];

/// A word of `--versus`: a renderer with the algorithms that fit the scene, or with the one that is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The renderer.
    pub renderer: &'static Renderer,
    mode: Option<&'static Mode>,
}

impl Choice {
    /// Read a word: `mitsuba`, `mitsuba-path`, or `mitsuba+oidn-path`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the words that there are.
    pub fn parse(word: &str) -> Result<Self> {
        let found = RENDERERS.iter().find_map(|renderer| {
            let rest = word.strip_prefix(renderer.name)?;
            if rest.is_empty() {
                return Some(Self { renderer, mode: None });
            }
            let mode = renderer.modes.iter().find(|m| rest.strip_prefix('-') == Some(m.name))?;
            Some(Self { renderer, mode: Some(mode) })
        });
        found.ok_or_else(|| {
            let names = RENDERERS.iter().flat_map(|r| {
                std::iter::once(r.name.to_string())
                    .chain(r.modes.iter().map(|m| format!("{}-{}", r.name, m.name)))
            });
            let names: Vec<String> = names.collect();
            Error::usage(
                format!("--versus {word}: not a renderer"),
                format!("there are {}", names.join(", ")),
            )
        })
    }

    /// Names of the algorithms to run on a scene.
    ///
    /// # Errors
    /// [`Error::Usage`] where the renderer would show something else, or the algorithm that is named miss light.
    pub fn modes(&self, scene: &str, traits: Traits) -> Result<Vec<&'static str>> {
        if traits.spots && !self.renderer.spots {
            let what = format!("--versus {}: its spots are not those of {scene}", self.renderer.name);
            return Err(Error::usage(what, "leave it out for this scene"));
        }
        let specular = traits.specular;
        if let Some(mode) = self.mode {
            if mode.blind && specular {
                let what = format!(
                    "--versus {}-{} misses what {scene} shows in mirrors and glass",
                    self.renderer.name, mode.name
                );
                return Err(Error::usage(what, "leave it out for this scene"));
            }
            return Ok(vec![mode.name]);
        }
        let fits = |m: &&Mode| match m.fit {
            Fit::All => true,
            Fit::Matte => !specular,
            Fit::Specular => specular,
        };
        Ok(self.renderer.modes.iter().filter(fits).map(|m| m.name).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::{Choice, RENDERERS, SHARED, Traits};

    const MATTE: Traits = Traits { specular: false, spots: false };
    const SPECULAR: Traits = Traits { specular: true, spots: false };
    const SPOTS: Traits = Traits { specular: false, spots: true };

    fn choice(word: &str) -> Choice {
        Choice::parse(word).unwrap_or_else(|e| panic!("{e}"))
    }

    /// Every name that an error offers is one, and stands for what it says.
    #[test]
    fn words_name_renderers_and_algorithms() {
        for renderer in &RENDERERS {
            assert_eq!(choice(renderer.name).renderer, renderer);
            for mode in renderer.modes {
                let named = choice(&format!("{}-{}", renderer.name, mode.name));
                assert_eq!(named.modes("a scene", MATTE).expect("no light is missed"), [mode.name]);
            }
        }
        for wrong in [
            "",
            "mitsuba-",
            "mitsubapath",
            "mitsuba-photongi",
            "Mitsuba",
            "luxcore path",
            "oidn",
            "mitsuba+",
            "mitsuba-oidn",
            "mitsuba-path+oidn",
            "mitsuba+oidn-ptracer",
        ] {
            assert!(Choice::parse(wrong).is_err(), "{wrong:?}");
        }
    }

    /// What a driver imports lies beside it, and it knows its algorithms.
    #[test]
    fn drivers_are_whole() {
        let shared = SHARED.map(|(name, _)| name);
        let texts = SHARED.iter().chain(RENDERERS.iter().map(|r| &r.driver));
        for (name, text) in texts {
            for module in text.lines().filter_map(|l| l.strip_prefix("import driving")) {
                let file = format!("driving{module}.py");
                assert!(shared.contains(&file.as_str()), "{name}: no {file}");
            }
        }
        for renderer in &RENDERERS {
            let (name, text) = renderer.driver;
            assert!(text.contains("import driving"), "{name}");
            for mode in renderer.modes {
                assert!(text.contains(&format!("`{}`", mode.name)), "{name}: what is {}", mode.name);
            }
        }
    }

    #[test]
    fn algorithms_fit_the_scene() {
        let modes = |word: &str, traits| choice(word).modes("a scene", traits);
        assert_eq!(modes("mitsuba", MATTE).expect("some"), ["path", "ptracer"]);
        assert_eq!(modes("mitsuba", SPECULAR).expect("some"), ["path"]);
        assert_eq!(modes("luxcore", MATTE).expect("some"), ["path"]);
        assert_eq!(modes("luxcore", SPECULAR).expect("some"), ["photongi", "bidirvm"]);
        assert_eq!(modes("luxcore-path", SPECULAR).expect("slow, but it sees all"), ["path"]);
        assert_eq!(modes("mitsuba+oidn", MATTE).expect("some"), ["path"]);
        assert_eq!(modes("mitsuba+oidn", SPECULAR).expect("some"), ["path", "path-colour"]);
        assert_eq!(modes("mitsuba+oidn-path", SPECULAR).expect("some"), ["path"]);
        assert!(modes("mitsuba-ptracer", SPECULAR).is_err(), "it would miss light");
        assert_eq!(modes("mitsuba", SPOTS).expect("some"), ["path", "ptracer"]);
        assert!(modes("luxcore", SPOTS).is_err() && modes("luxcore-path", SPOTS).is_err(), "other spots");
    }
}

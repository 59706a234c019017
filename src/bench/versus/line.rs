//! Line: what a driver says, one JSON object a line.

use serde::Deserialize;

/// A line of a driver. Unknown fields are passed over.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Line {
    /// First of all: what it is.
    Renderer {
        /// Name, version and variant.
        name: String,
        /// What the user should know about this installation; may be empty.
        #[serde(default)]
        note: String,
    },
    /// A picture.
    Picture {
        /// Seed of the random numbers.
        seed: u32,
        /// Index of the step of the ladder that was reached.
        step: usize,
        /// Seconds of rendering.
        seconds: f64,
        /// Processor seconds of all threads.
        cpu_seconds: f64,
        /// Samples a pixel.
        samples: u64,
        /// File of its radiance in the job's folder: f32, little-endian, RGB, row 0 at the top.
        file: String,
    },
    /// A Python package is not installed.
    Missing {
        /// Its name.
        module: String,
    },
    /// It cannot go on.
    Failed {
        /// Why, in the renderer's words.
        what: String,
    },
    /// All pictures are there.
    Done,
}

impl Line {
    /// Read a line; what is wrong with it otherwise.
    pub fn parse(text: &str) -> Result<Self, String> {
        let line: Self = serde_json::from_str(text).map_err(|e| e.to_string())?;
        match &line {
            Self::Picture { seconds, cpu_seconds, .. }
                if [*seconds, *cpu_seconds].iter().any(|t| !t.is_finite() || *t < 0.0) =>
            {
                Err(format!("{seconds} and {cpu_seconds} are no times"))
            }
            // a name of its own keeps the driver inside its folder
            Self::Picture { file, .. } if file.is_empty() || file.contains(['/', '\\']) || file == ".." => {
                Err(format!("{file:?} is no name of a file"))
            }
            _ => Ok(line),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Line;

    const PICTURE: &str = r#"{"kind": "picture", "seed": 1, "step": 2, "seconds": 0.5, "cpu_seconds": 1.0,
        "samples": 64, "file": "a.raw", "mode": "path"}"#;

    #[test]
    fn lines_are_read() {
        assert_eq!(Line::parse(r#"{"kind": "done"}"#), Ok(Line::Done));
        let name = "Mitsuba 3.9.1".to_string();
        let renderer = Line::Renderer { name, note: String::new() };
        assert_eq!(
            Line::parse(r#"{"kind": "renderer", "name": "Mitsuba 3.9.1", "modes": []}"#),
            Ok(renderer)
        );
        let Ok(Line::Picture { seed: 1, step: 2, seconds, cpu_seconds, samples: 64, file }) =
            Line::parse(PICTURE)
        else {
            panic!("a picture: {:?}", Line::parse(PICTURE));
        };
        assert_eq!((seconds, cpu_seconds, file.as_str()), (0.5, 1.0, "a.raw"));
    }

    /// Neither half a line nor a wrong time nor a path out of the folder goes through.
    #[test]
    fn wrong_lines_are_told() {
        for text in ["", "hello", "{}", r#"{"kind": "dance"}"#, r#"{"kind": "picture", "seed": 1}"#] {
            assert!(Line::parse(text).is_err(), "{text}");
        }
        for (part, wrong) in [
            ("0.5", "-0.5"),
            ("1.0", "1e999"),
            ("a.raw", "../a.raw"),
            ("a.raw", ".."),
            ("a.raw", ""),
            ("64", "-64"),
            (r#""seed": 1"#, r#""seed": 1.5"#),
        ] {
            let text = PICTURE.replace(part, wrong);
            assert!(Line::parse(&text).is_err(), "{text}");
        }
    }
}

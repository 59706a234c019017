//! Lights beside emissive triangles: those that a surface cannot stand for.

use crate::error::Result;
use crate::scene::mtl::At;
use crate::scene::spectrum_entry;
use crate::scene::table::Table;
use crate::spectrum::Bands;
use crate::spectrum::lamp::Emission;
use glam::DVec3;

/// A light without a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Shines the same in every direction.
    Point {
        /// World position.
        position: DVec3,
        /// Radiant intensity, W/sr per band. Flux is 4π times this.
        intensity: Bands,
    },
    /// Shines into a cone: full intensity inside `angle_inner`, smoothly (cubic in the cosine) to none at `angle_outer`.
    Spot {
        /// World position.
        position: DVec3,
        /// Unit axis, away from the light.
        direction: DVec3,
        /// Radiant intensity on the axis, W/sr per band.
        intensity: Bands,
        /// Angle from the axis up to which the intensity is full, rad. Not its cosine: that of a narrow cone has no digits.
        angle_inner: f64,
        /// Angle from the axis at which the intensity reaches zero, rad.
        angle_outer: f64,
    },
    /// Parallel light from far away.
    Sun {
        /// Unit direction in which the light travels.
        direction: DVec3,
        /// Irradiance on a surface that faces the sun, W/m² per band.
        irradiance: Bands,
    },
}

/// Where a light is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightPlace {
    /// World position.
    At(DVec3),
    /// Infinitely far; unit direction in which the light travels.
    Infinity(DVec3),
}

impl Light {
    /// Radiant intensity or irradiance, by its kind.
    pub fn power(&self) -> Bands {
        match *self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Sun { irradiance, .. } => irradiance,
        }
    }

    /// Where it is.
    pub fn place(&self) -> LightPlace {
        match *self {
            Self::Point { position, .. } | Self::Spot { position, .. } => LightPlace::At(position),
            Self::Sun { direction, .. } => LightPlace::Infinity(direction),
        }
    }
}

/// Half angles of a spot where the file gives none, degrees.
const DEFAULT_SPOT: [f64; 2] = [20.0, 30.0];

/// A light of a scene file.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(super) fn read(table: Table) -> Result<(Light, Option<Emission>)> {
    let kind = table.string("kind")?;
    match kind.value.as_str() {
        "point" => {
            table.allow(&["kind", "position", "intensity"])?;
            let (intensity, spectrum) = power(&table, "intensity")?;
            Ok((Light::Point { position: table.vector("position")?.value, intensity }, spectrum))
        }
        "spot" => spot(table),
        "sun" => {
            table.allow(&["kind", "direction", "irradiance"])?;
            let (irradiance, spectrum) = power(&table, "irradiance")?;
            Ok((Light::Sun { direction: direction(&table)?, irradiance }, spectrum))
        }
        other => Err(table.unknown(kind.line, "kind of light", other, &["point", "spot", "sun"])),
    }
}

fn spot(table: Table) -> Result<(Light, Option<Emission>)> {
    table.allow(&["kind", "position", "direction", "target", "intensity", "angle_inner", "angle_outer"])?;
    let position = table.vector("position")?.value;
    let direction = match table.optional_vector("target")? {
        Some(_) if table.optional_vector("direction")?.is_some() => {
            return Err(table.fault(table.line(), "both direction and target", "give one of them"));
        }
        Some(target) => (target - position).try_normalize().ok_or_else(|| {
            table.fault(table.line(), "spot whose target is its position", "move one of them")
        })?,
        None if table.optional_vector("direction")?.is_none() => {
            let remedy = "add target = [x, y, z], or direction = [x, y, z]";
            return Err(table.fault(table.line(), "spot without a target", remedy));
        }
        None => direction(&table)?,
    };
    let mut angles = DEFAULT_SPOT;
    let inner = table.number("angle_inner")?;
    let outer = table.number("angle_outer")?;
    if let Some(outer) = outer {
        // A lone outer angle keeps the proportion of the defaults.
        angles = [outer.value * DEFAULT_SPOT[0] / DEFAULT_SPOT[1], outer.value];
    }
    if let Some(inner) = inner {
        angles[0] = inner.value;
        if outer.is_none() {
            angles[1] = angles[1].max(inner.value);
        }
    }
    let line = outer.or(inner).map_or(table.line(), |a| a.line);
    if !(angles[0] >= 0.0 && angles[1] > 0.0 && angles[0] <= angles[1] && angles[1] <= 180.0) {
        let what = format!("spot with half angles {} and {} degrees", angles[0], angles[1]);
        return Err(table.fault(line, &what, "give 0 <= angle_inner <= angle_outer <= 180"));
    }
    let (intensity, spectrum) = power(&table, "intensity")?;
    let [angle_inner, angle_outer] = angles.map(f64::to_radians);
    Ok((Light::Spot { position, direction, intensity, angle_inner, angle_outer }, spectrum))
}

fn direction(table: &Table) -> Result<DVec3> {
    let direction = table.vector("direction")?;
    direction.value.try_normalize().ok_or_else(|| {
        table.fault(direction.line, "direction without length", "give a vector that is not zero")
    })
}

/// A quantity of light: required, and something in some band.
fn power(table: &Table, key: &str) -> Result<(Bands, Option<Emission>)> {
    let (stated, spectrum) = spectrum_entry::emission(table, key)?;
    let Some(At { value, line }) = stated else {
        return Err(table.missing(key));
    };
    if crate::spectrum::is_black(&value) {
        return Err(table.fault(
            line,
            &format!("light without {key}"),
            "give a value above 0 or remove the light",
        ));
    }
    Ok((value, spectrum))
}

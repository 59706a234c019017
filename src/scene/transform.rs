//! Transform: where a mesh or a shape of a scene file stands.

use super::table::Table;
use super::{Mesh, mtl::At};
use crate::Result;
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};

/// An affine map of positions that keeps them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Transform {
    affine: DAffine3,
    /// Takes normals to normals, but for their length: the inverse, transposed.
    normals: DMat3,
}

impl Transform {
    /// Keys of a table that say where something stands.
    pub(crate) const KEYS: [&'static str; 4] = ["scale", "rotate", "translate", "matrix"];

    /// Leaves everything where it is.
    pub(crate) fn identity() -> Self {
        Self::of(DAffine3::IDENTITY)
    }

    fn of(affine: DAffine3) -> Self {
        Self { affine, normals: affine.matrix3.inverse().transpose() }
    }

    /// `matrix`, or `scale`, then `rotate`, then `translate`.
    ///
    /// # Errors
    /// Line and remedy where the table says something else.
    pub(crate) fn read(table: &Table) -> Result<Self> {
        let scale = table.factors("scale")?;
        let rotate = table.at_vector("rotate")?;
        let translate = table.at_vector("translate")?;
        if let Some(At { value: rows, line }) = table.matrix("matrix")? {
            if scale.is_some() || rotate.is_some() || translate.is_some() {
                return Err(table.fault(
                    line,
                    "matrix beside scale, rotate or translate",
                    "give one or the other",
                ));
            }
            let [x, y, z] = rows.map(|[a, b, c, _]| DVec3::new(a, b, c));
            let linear = DMat3::from_cols(x, y, z).transpose();
            if linear.determinant() == 0.0 || !linear.inverse().is_finite() {
                return Err(table.fault(line, "matrix that flattens everything", "give one with an inverse"));
            }
            let moved = DVec3::from(rows.map(|row| row[3]));
            return Ok(Self::of(DAffine3 { matrix3: linear, translation: moved }));
        }
        let scale = scale.unwrap_or(At { value: DVec3::ONE, line: table.line() });
        if scale.value.min_element() <= 0.0 {
            let told = scale.value.min_element();
            return Err(table.fault(
                scale.line,
                &format!("scale {told}"),
                "give numbers above 0; matrix can mirror",
            ));
        }
        let turns = rotate.map_or(DVec3::ZERO, |r| r.value).to_array().map(f64::to_radians);
        // about x first, then y, then z, which stay where they are
        let rotation = DQuat::from_euler(EulerRot::ZYX, turns[2], turns[1], turns[0]);
        let translation = translate.map_or(DVec3::ZERO, |t| t.value);
        Ok(Self::of(DAffine3::from_scale_rotation_translation(scale.value, rotation, translation)))
    }

    /// A position.
    pub(crate) fn position(&self, p: DVec3) -> DVec3 {
        self.affine.transform_point3(p)
    }

    /// A normal; as long as it comes.
    pub(crate) fn normal(&self, n: DVec3) -> DVec3 {
        self.normals * n
    }

    /// Whether it turns what is left into what is right, and so the front of a triangle to its back.
    pub(crate) fn mirrors(&self) -> bool {
        self.affine.matrix3.determinant() < 0.0
    }

    /// A mesh where it stands.
    pub(crate) fn mesh(&self, mut mesh: Mesh) -> Mesh {
        for p in &mut mesh.positions {
            *p = self.position(*p);
        }
        for n in &mut mesh.normals {
            *n = self.normal(n.as_dvec3()).normalize_or_zero().as_vec3();
        }
        if self.mirrors() {
            for t in &mut mesh.triangles {
                t.vertex.reverse();
                if let Some(normal) = &mut t.normal {
                    normal.reverse();
                }
                if let Some(uv) = &mut t.uv {
                    uv.reverse();
                }
            }
        }
        mesh
    }
}

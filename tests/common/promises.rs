//! What a scene promises that was read from whatever bytes.

use joton::scene::Scene;

/// What [`Scene`] promises.
pub fn check(scene: &Scene) {
    let mesh = &scene.mesh;
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
    for t in &mesh.triangles {
        assert!(t.vertex.iter().all(|&v| (v as usize) < mesh.positions.len()));
        assert!(t.normal.iter().flatten().all(|&n| (n as usize) < mesh.normals.len()));
        assert!((t.material as usize) < scene.materials.len());
    }
    for m in &scene.materials {
        for band in 0..m.diffuse.len() {
            // what reflects by Fresnel shares out what it gets
            let lobes = [m.diffuse[band], m.glossy[band], m.specular[band]];
            let albedo =
                if m.facets.is_some() { lobes.into_iter().fold(0.0, f32::max) } else { lobes.iter().sum() };
            // Three sums of rounded f32.
            assert!((0.0..=1.0 + 1e-6).contains(&albedo), "{m:?}");
            assert!(m.emission[band] >= 0.0 && m.emission[band].is_finite());
        }
        assert!(m.glossy_exponent.is_finite());
    }
    assert!(scene.camera.basis().iter().all(|axis| axis.is_normalized()), "{:?}", scene.camera);
    assert!(scene.camera.tan_half_fov.iter().all(|t| t.is_finite() && *t > 0.0));
    assert!(!scene.lights.is_empty() || scene.materials.iter().any(|m| m.emission.iter().any(|&e| e > 0.0)));
}

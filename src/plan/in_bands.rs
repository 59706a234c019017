//! In bands: a scene and what was learned of it, in the bands of a pass, where these differ from pass to pass \[E34\].

use super::{Guides, Plan};
use crate::packed::{PackedScene, PassBands};
use std::sync::Arc;

/// A scene in the bands of one pass.
#[derive(Debug, Clone)]
pub struct InBands {
    /// What the bands are.
    pub bands: PassBands,
    /// The scene; hierarchy and triangles are shared with the one that it is of.
    pub scene: PackedScene,
    /// The lists of emitters that are picked from.
    pub guides: Arc<Guides>,
}

impl InBands {
    /// In the bands of `pass`; none where all passes have the scene's own.
    pub fn of(scene: &PackedScene, plan: &Plan, pass: u64) -> Option<Self> {
        let spectra = scene.spectra.as_deref()?;
        let bands = spectra.bands(plan.settings.seed, pass);
        let emitted = spectra.emitted(&bands);
        let Guides { caustic, diffuse, direct } = &*plan.guides;
        let [caustic, diffuse, direct] =
            [caustic, diffuse, direct].map(|guide| guide.with(|list| spectra.emitters(list, &emitted)));
        let guides = Arc::new(Guides { caustic, diffuse, direct });
        Some(Self { bands, scene: spectra.scene(scene, &bands, &emitted), guides })
    }

    /// The plan of a pass in these bands.
    pub fn plan(&self, plan: &Plan) -> Plan {
        Plan { guides: self.guides.clone(), ..plan.clone() }
    }
}

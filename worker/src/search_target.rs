//! Target of a search: its file, with the scenes of pictures corrected.

use brood_protocol::{CalibratedView, SceneCorrection};
use brood_search::{Calibrated, Corrected, calibrate};
use brood_target::{TargetFile, TargetKind};

/// Target of a search.
pub(crate) struct SearchTarget {
    /// The file. Its pictures are in their corrected scenes.
    pub(crate) file: TargetFile,
    corrections: Vec<Corrected>,
}

impl SearchTarget {
    /// Reads a file, and corrects the scenes of its pictures within their uncertainties.
    pub(crate) fn read(kind: TargetKind, bytes: &[u8]) -> Result<Self, String> {
        let file = TargetFile::read(kind, bytes).map_err(|error| error.to_string())?;
        let TargetFile { target, pictures: Some(pictures), skipped, rows } = file else {
            return Ok(Self { file, corrections: Vec::new() });
        };
        let Calibrated { pictures, target, corrections } =
            calibrate(pictures, target).map_err(|error| error.to_string())?;
        let file = TargetFile { target, pictures: Some(pictures), skipped, rows };
        Ok(Self { file, corrections })
    }

    /// Report of the corrected scenes; `None` if all scenes are as stated.
    pub(crate) fn report(&self) -> Option<Vec<CalibratedView>> {
        let pictures = self.file.pictures.as_ref().filter(|_| !self.corrections.is_empty())?;
        let view = |(index, view): (usize, &brood_target::KnownView)| {
            let own = self.corrections.iter().filter(|one| one.pictures.contains(&index));
            let scene = &view.setting.scene;
            CalibratedView {
                scene: serde_json::to_string(scene).expect("scenes serialise as JSON"),
                corrections: own.map(of_protocol).collect(),
            }
        };
        Some(pictures.views.iter().enumerate().map(view).collect())
    }
}

fn of_protocol(one: &Corrected) -> SceneCorrection {
    SceneCorrection {
        name: one.name.clone(),
        value: one.value,
        stated_deviation: one.stated_deviation,
        deviation: one.deviation,
    }
}

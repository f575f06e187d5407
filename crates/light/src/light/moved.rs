//! Lights moved about the subject, to correct scenes that are known only roughly.

use brood_mesh::UnitFrame;
use brood_mesh::angle::rotated_deg;
use glam::DVec3;

use super::{DirectionalLight, IesLight, Light, PointLight, SpotLight};
use crate::sampler::placement::LightPlacement;

/// Movement of a light about the centre of the subject, as seen from there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightMove {
    /// Turn to the right and upwards, in degrees.
    pub turn_deg: [f64; 2],
    /// Factor of the distance. Lights without position ignore it.
    pub distance: f64,
}

impl Light {
    /// True if the light has a direction or a position, and no size.
    #[must_use]
    pub fn is_movable(&self) -> bool {
        matches!(self, Self::Point(_) | Self::Directional(_) | Self::Spot(_) | Self::Ies(_))
    }

    /// True if the light has a position and no size.
    #[must_use]
    pub fn has_distance(&self) -> bool {
        self.is_movable() && !matches!(self, Self::Directional(_))
    }

    /// Returns the light moved about the centre of the subject. Axes turn with it. A default
    /// position becomes explicit; a default strength stays, and with it the irradiance at the
    /// centre. Other lights than [`Light::is_movable`] do not change.
    #[must_use]
    pub fn moved(&self, frame: &UnitFrame, by: LightMove) -> Self {
        let position = |position: Option<[f64; 3]>| {
            let turn = Turn::new(position.map_or_else(default, |place| frame.relative(place)), by);
            (Some(frame.world(turn.of(turn.from) * by.distance)), turn)
        };
        match self {
            Self::Point(own) => {
                Self::Point(PointLight { position: position(own.position).0, ..own.clone() })
            }
            Self::Spot(own) => {
                let (position, turn) = position(own.position);
                Self::Spot(SpotLight { position, axis: turn.axis(own.axis), ..own.clone() })
            }
            Self::Ies(own) => {
                let (position, turn) = position(own.position);
                let (axis, up) = (turn.axis(own.axis), turn.axis(own.up));
                Self::Ies(IesLight { position, axis, up, ..own.clone() })
            }
            Self::Directional(own) => {
                let from = own.direction.map_or_else(default, |towards| -DVec3::from(towards));
                let turn = Turn::new(from, by);
                let direction = Some((-turn.of(from)).to_array());
                Self::Directional(DirectionalLight { direction, ..own.clone() })
            }
            Self::Sphere(_)
            | Self::Disk(_)
            | Self::Rectangle(_)
            | Self::Environment(_)
            | Self::Ambient(_) => self.clone(),
        }
    }
}

/// Default position, relative to the centre of the subject, in its radii.
fn default() -> DVec3 {
    LightPlacement::default_relative()
}

/// Rotation about the centre of the subject.
struct Turn {
    /// Position before, relative to the centre.
    from: DVec3,
    up: DVec3,
    right: DVec3,
    by_deg: [f64; 2],
}

impl Turn {
    fn new(from: DVec3, by: LightMove) -> Self {
        let towards = from.try_normalize().unwrap_or(DVec3::Y);
        // To the right as seen from the centre.
        let right = towards.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        Self { from, up: right.cross(towards), right, by_deg: by.turn_deg }
    }

    fn of(&self, v: DVec3) -> DVec3 {
        let [right_deg, up_deg] = self.by_deg;
        rotated_deg(rotated_deg(v, self.right, up_deg), self.up, -right_deg)
    }

    fn axis(&self, axis: Option<[f64; 3]>) -> Option<[f64; 3]> {
        axis.map(|axis| self.of(DVec3::from(axis)).to_array())
    }
}

#[cfg(test)]
mod tests {
    use brood_mesh::{BuiltinMesh, Mesh};

    use super::*;

    #[test]
    fn light_turns_about_the_centre_and_keeps_its_distance() {
        let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Knob), 1.0, [0.0; 3]);
        let place = |light: &Light| match light {
            Light::Point(PointLight { position, .. }) => frame.relative(position.unwrap()),
            Light::Directional(own) => -DVec3::from(own.direction.unwrap()),
            Light::Spot(own) => frame.relative(own.position.unwrap()),
            _ => unreachable!(),
        };
        for json in [
            r#"{"kind": "point", "position": [1, 2, 3]}"#,
            r#"{"kind": "directional", "direction": [0, -1, 0]}"#,
            r#"{"kind": "spot", "position": [-3, 0.5, -2], "axis": [3, 0, 2]}"#,
        ] {
            let light: Light = serde_json::from_str(json).unwrap();
            let moved = light.moved(&frame, LightMove { turn_deg: [3.0, 4.0], distance: 1.0 });
            let (before, after) = (place(&light), place(&moved));
            assert!((before.length() - after.length()).abs() < 1e-12);
            let angle = before.angle_between(after).to_degrees();
            assert!((angle - 5.0).abs() < 0.02, "{json}: {angle}");
            let far = light.moved(&frame, LightMove { turn_deg: [0.0; 2], distance: 1.5 });
            let wanted = if light.has_distance() { 1.5 } else { 1.0 };
            assert!((place(&far) - before * wanted).length() < 1e-12, "{json}");
            let none = light.moved(&frame, LightMove { turn_deg: [0.0; 2], distance: 1.0 });
            assert!((place(&none) - before).length() < 1e-12);
        }
    }

    #[test]
    fn default_light_moves_from_its_default_place() {
        let frame = UnitFrame::new(&Mesh::builtin(BuiltinMesh::Sphere), 1.0, [0.0; 3]);
        let light = Light::default();
        let same = light.moved(&frame, LightMove { turn_deg: [0.0; 2], distance: 1.0 });
        let Light::Point(PointLight { position: Some(position), .. }) = same else {
            panic!("{same:?}")
        };
        let wanted = PointLight::default().place(0.0, &frame);
        assert!((frame.position(frame.relative(position)) - wanted).length() < 1e-12);
    }
}

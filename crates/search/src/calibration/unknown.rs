//! Unknowns of scenes, and the scenes that their values give.

use brood_light::LightMove;
use brood_scene::{CameraMove, Correction, Scene};
use brood_target::KnownView;

/// Steps of finite differences: in degrees, in shares, and in standard deviations if that is less.
const STEP_DEG: f64 = 0.1;
const STEP: f64 = 2e-3;
const STEP_DEVIATIONS: f64 = 0.1;

/// Number of a scene that is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    LightRight(usize),
    LightUp(usize),
    LightDistance(usize),
    CameraRight,
    CameraUp,
    AimRight,
    AimUp,
    Roll,
    CameraDistance,
    Fov,
    Gain,
    Channel(usize),
}

/// An unknown, shared by all views for which the same light or camera is stated.
#[derive(Debug, Clone)]
struct Unknown {
    part: Part,
    /// Standard deviation: degrees, or a difference of logarithms.
    deviation: f64,
    /// Indices of the views, in ascending order.
    views: Vec<usize>,
}

/// All unknowns. Their values z are in standard deviations from what is stated.
#[derive(Debug, Clone, Default)]
pub(super) struct Unknowns(Vec<Unknown>);

/// A number of the scenes that was corrected.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrected {
    /// Name: `lights/0/right_deg`, `lights/0/up_deg`, `lights/0/distance`, `camera/right_deg`,
    /// `camera/up_deg`, `camera/aim_right_deg`, `camera/aim_up_deg`, `camera/roll_deg`,
    /// `camera/distance`, `camera/fov`, `gain`, `gain/red`, `gain/green` or `gain/blue`. Angles are
    /// turns in degrees, the others factors of the stated number.
    pub name: String,
    /// Indices of the pictures.
    pub pictures: Vec<usize>,
    /// Value.
    pub value: f64,
    /// Standard deviation of the value before the fit.
    pub stated_deviation: f64,
    /// The same after the fit.
    pub deviation: f64,
}

impl Corrected {
    /// Difference from what was stated, in its standard deviations. Above 2, the scene as stated is
    /// probably wrong in something else.
    #[must_use]
    pub fn moved(&self) -> f64 {
        let change = if self.name.ends_with("_deg") { self.value } else { libm::log(self.value) };
        (change / self.stated_deviation).abs()
    }
}

impl Part {
    fn is_angle(self) -> bool {
        match self {
            Self::LightRight(_)
            | Self::LightUp(_)
            | Self::CameraRight
            | Self::CameraUp
            | Self::AimRight
            | Self::AimUp
            | Self::Roll => true,
            Self::LightDistance(_)
            | Self::CameraDistance
            | Self::Fov
            | Self::Gain
            | Self::Channel(_) => false,
        }
    }

    fn name(self) -> String {
        match self {
            Self::LightRight(light) => format!("lights/{light}/right_deg"),
            Self::LightUp(light) => format!("lights/{light}/up_deg"),
            Self::LightDistance(light) => format!("lights/{light}/distance"),
            Self::CameraRight => "camera/right_deg".to_owned(),
            Self::CameraUp => "camera/up_deg".to_owned(),
            Self::AimRight => "camera/aim_right_deg".to_owned(),
            Self::AimUp => "camera/aim_up_deg".to_owned(),
            Self::Roll => "camera/roll_deg".to_owned(),
            Self::CameraDistance => "camera/distance".to_owned(),
            Self::Fov => "camera/fov".to_owned(),
            Self::Gain => "gain".to_owned(),
            Self::Channel(channel) => format!("gain/{}", ["red", "green", "blue"][channel]),
        }
    }

    /// True if it changes which points are seen, or how they are lit.
    fn moves(self) -> bool {
        !matches!(self, Self::Gain | Self::Channel(_))
    }

    /// True if two views have the same unknown, because the same is stated for both.
    fn is_shared(self, a: &KnownView, b: &KnownView) -> bool {
        let (one, other) = (&a.setting, &b.setting);
        match self {
            Self::LightRight(light) | Self::LightUp(light) | Self::LightDistance(light) => {
                one.scene.lights.get(light) == other.scene.lights.get(light)
                    && one.scene.light_deg == other.scene.light_deg
            }
            Self::Gain | Self::Channel(_) => true,
            Self::CameraRight
            | Self::CameraUp
            | Self::AimRight
            | Self::AimUp
            | Self::Roll
            | Self::CameraDistance
            | Self::Fov => one.scene.camera == other.scene.camera && a.size_px() == b.size_px(),
        }
    }

    /// Unknowns of a view, with their standard deviations.
    fn of(view: &KnownView) -> Vec<(Self, f64)> {
        let (scene, refine) = (&view.setting.scene, view.setting.refine);
        let mut parts = Vec::new();
        for (k, light) in scene.lights.iter().enumerate().filter(|(_, light)| light.is_movable()) {
            parts.push((Self::LightRight(k), refine.light_deg));
            parts.push((Self::LightUp(k), refine.light_deg));
            if light.has_distance() {
                parts.push((Self::LightDistance(k), refine.light_distance));
            }
        }
        if scene.has_eye() {
            let turns = [Self::CameraRight, Self::CameraUp, Self::AimRight, Self::AimUp];
            parts.extend(turns.map(|part| (part, refine.camera_deg)));
            parts.push((Self::Roll, refine.camera_deg));
            parts.push((Self::CameraDistance, refine.camera_distance));
            parts.push((Self::Fov, refine.fov));
        }
        if !view.view.is_gain_unknown() {
            parts.push((Self::Gain, refine.gain));
        }
        parts.extend([0, 1, 2].map(|channel| (Self::Channel(channel), refine.white_balance)));
        parts.retain(|(_, deviation)| *deviation > 0.0);
        parts
    }
}

impl Unknown {
    /// Value in degrees, or factor.
    fn value(&self, z: f64) -> f64 {
        let change = self.deviation * z;
        if self.part.is_angle() { change } else { libm::exp(change) }
    }

    fn step(&self) -> f64 {
        let step = if self.part.is_angle() { STEP_DEG } else { STEP };
        (step / self.deviation).min(STEP_DEVIATIONS)
    }
}

impl Unknowns {
    /// Unknowns of the fitted views. Held-out views share them.
    pub(super) fn of(views: &[KnownView]) -> Self {
        let mut all: Vec<Unknown> = Vec::new();
        let (held, fitted): (Vec<usize>, Vec<usize>) =
            (0..views.len()).partition(|index| views[*index].setting.is_held_out);
        for index in fitted {
            for (part, deviation) in Part::of(&views[index]) {
                let is_same = |known: &&mut Unknown| {
                    known.part == part
                        && known.deviation == deviation
                        && part.is_shared(&views[known.views[0]], &views[index])
                };
                match all.iter_mut().find(is_same) {
                    Some(known) => known.views.push(index),
                    None => all.push(Unknown { part, deviation, views: vec![index] }),
                }
            }
        }
        for index in held {
            for known in &mut all {
                if known.part.is_shared(&views[known.views[0]], &views[index]) {
                    known.views.push(index);
                }
            }
        }
        Self(all)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Values as stated.
    pub(super) fn stated(&self) -> Vec<f64> {
        vec![0.0; self.len()]
    }

    /// Step of the finite difference of an unknown.
    pub(super) fn step(&self, unknown: usize) -> f64 {
        self.0[unknown].step()
    }

    /// True if an unknown changes a view.
    pub(super) fn changes(&self, unknown: usize, view: usize) -> bool {
        self.0[unknown].views.contains(&view)
    }

    /// True if an unknown changes the scene of its views, and not only their brightness.
    pub(super) fn moves(&self, unknown: usize) -> bool {
        self.0[unknown].part.moves()
    }

    /// Scene of a view.
    pub(super) fn scene(&self, view: &KnownView, index: usize, z: &[f64]) -> Scene {
        let scene = &view.setting.scene;
        let still = LightMove { turn_deg: [0.0; 2], distance: 1.0 };
        let mut lights = vec![still; scene.lights.len()];
        let mut camera = CameraMove::default();
        for (unknown, z) in self.0.iter().zip(z).filter(|(own, _)| own.views.contains(&index)) {
            let value = unknown.value(*z);
            match unknown.part {
                Part::LightRight(light) => lights[light].turn_deg[0] = value,
                Part::LightUp(light) => lights[light].turn_deg[1] = value,
                Part::LightDistance(light) => lights[light].distance = value,
                Part::CameraRight => camera.turn_deg[0] = value,
                Part::CameraUp => camera.turn_deg[1] = value,
                Part::AimRight => camera.aim_deg[0] = value,
                Part::AimUp => camera.aim_deg[1] = value,
                Part::Roll => camera.aim_deg[2] = value,
                Part::CameraDistance => camera.distance = value,
                Part::Fov => camera.fov = value,
                Part::Gain | Part::Channel(_) => {}
            }
        }
        scene.corrected(&view.setting.mesh, view.size_px(), &Correction { lights, camera })
    }

    /// Brightness of red, green and blue of a view, relative to what is stated.
    pub(super) fn balance(&self, index: usize, z: &[f64]) -> [f64; 3] {
        let mut balance = [1.0; 3];
        for (unknown, z) in self.0.iter().zip(z).filter(|(own, _)| own.views.contains(&index)) {
            let value = unknown.value(*z);
            match unknown.part {
                Part::Gain => balance.iter_mut().for_each(|own| *own *= value),
                Part::Channel(channel) => balance[channel] *= value,
                _ => {}
            }
        }
        balance
    }

    /// Report of values and of their standard deviations, in those stated.
    pub(super) fn corrected(&self, z: &[f64], deviations: &[f64]) -> Vec<Corrected> {
        let all = self.0.iter().zip(z).zip(deviations);
        let report = |((unknown, z), deviation): ((&Unknown, &f64), &f64)| Corrected {
            name: unknown.part.name(),
            pictures: unknown.views.clone(),
            value: unknown.value(*z),
            stated_deviation: unknown.deviation,
            deviation: unknown.deviation * deviation,
        };
        all.map(report).collect()
    }
}

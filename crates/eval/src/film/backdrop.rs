//! Backdrop behind developed pictures.

use std::sync::Arc;

use brood_light::LightAssets;
use brood_mesh::Mesh;
use brood_scene::{
    Backdrop, Film, PictureSize, PixelArea, Scene, backdrop_colors, backdrop_radiance,
};

use super::developed::Developed;
use super::surroundings::Surroundings;
use crate::radiance::RadianceImage;

/// Surroundings of the object in a part of a picture, for pictures of any material: other objects,
/// and the backdrop behind all.
#[derive(Debug)]
pub struct LitBackdrop {
    surroundings: Option<Arc<Surroundings>>,
    film: Film,
    content: Content,
}

#[derive(Debug)]
enum Content {
    None,
    /// The same for every exposure.
    Plain(Developed),
    /// Radiance of each pixel.
    Radiance {
        size: PictureSize,
        radiance: Vec<[f32; 3]>,
    },
}

impl LitBackdrop {
    /// Computes the backdrop of a scene in an area of a picture. Pictures stay transparent if the
    /// scene has none, or an image that is missing.
    #[must_use]
    pub fn new(
        (scene, mesh, assets): (&Scene, &Mesh, &LightAssets),
        size_px: PictureSize,
        area: PixelArea,
    ) -> Self {
        let size = PictureSize { width: area.width, height: area.height };
        let content = match &scene.backdrop {
            None => Content::None,
            Some(Backdrop::Color { color }) => Content::Plain(Developed::plain(size, *color)),
            Some(Backdrop::Environment { blur_deg }) => {
                let view = (scene, mesh, assets);
                let radiance = backdrop_radiance(*blur_deg, view, size_px, area);
                Content::Radiance { size, radiance }
            }
            Some(Backdrop::Image { image }) => match assets.image(image) {
                Some(image) => {
                    let colors = backdrop_colors(image, size_px, area);
                    Content::Plain(Developed::of_display(size, &colors))
                }
                None => Content::None,
            },
        };
        Self { surroundings: None, film: scene.film, content }
    }

    /// Returns the backdrop with other objects in front of it, as pictures of the same area.
    #[must_use]
    pub fn with_surroundings(self, surroundings: Option<Arc<Surroundings>>) -> Self {
        Self { surroundings, ..self }
    }

    /// Adds the other objects to a linear picture of that area.
    ///
    /// # Panics
    /// If the picture has another size.
    pub fn join(&self, picture: &mut RadianceImage) {
        if let Some(surroundings) = &self.surroundings {
            surroundings.join(picture);
        }
    }

    /// Puts the other objects beside a picture of that area, and the backdrop behind it, in the
    /// exposure of the objects if they have one, else in the picture's.
    ///
    /// # Panics
    /// If the picture has another size.
    #[must_use]
    pub fn behind(&self, mut picture: Developed) -> Developed {
        if let Some(surroundings) = &self.surroundings {
            surroundings.develop_beside(&mut picture, self.film);
        }
        match &self.content {
            Content::None => {}
            Content::Plain(plain) => picture.put_over(plain),
            Content::Radiance { size, radiance } => {
                let around = self.surroundings.as_ref().and_then(|around| around.ev);
                let exposed = (self.film, around.unwrap_or(picture.exposure_ev));
                picture.put_over(&Developed::opaque(*size, radiance, exposed));
            }
        }
        picture
    }
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;

    use super::*;

    /// Picture of four pixels: covered, half covered, clear, clear.
    fn picture() -> Developed {
        let rgba = vec![200, 100, 50, 255, 255, 255, 255, 128, 9, 9, 9, 0, 0, 0, 0, 0];
        Developed { width: 2, height: 2, rgba, exposure_ev: 1.0 }
    }

    fn backdrop(json: &str) -> LitBackdrop {
        let lights = r#""lights": [{"kind": "environment", "image": "overcast"}]"#;
        let scene: Scene = serde_json::from_str(&format!("{{{lights}{json}}}")).unwrap();
        scene.validate().unwrap();
        let mesh = Mesh::builtin(BuiltinMesh::Sphere);
        let size = PictureSize { width: 2, height: 2 };
        LitBackdrop::new((&scene, &mesh, &LightAssets::default()), size, PixelArea::whole(size))
    }

    #[test]
    fn pictures_without_a_backdrop_are_unchanged() {
        assert_eq!(backdrop("").behind(picture()), picture());
    }

    #[test]
    fn colours_fill_what_the_object_does_not_cover() {
        let color = r#", "backdrop": {"kind": "color", "color": [0, 0.2, 1]}"#;
        let found = backdrop(color).behind(picture()).rgba;
        assert_eq!(found[..4], [200, 100, 50, 255]);
        assert_eq!(found[8..], [0, 51, 255, 255, 0, 51, 255, 255]);
        // Half white and half black light is code 188, not 128.
        assert_eq!(found[4], 188);
        assert_eq!(found[6..8], [255, 255]);
    }

    #[test]
    fn environments_are_exposed_as_the_picture_is() {
        let json = r#", "backdrop": {"kind": "environment"}"#;
        let exposed = |exposure_ev: f64| {
            backdrop(json).behind(Developed { exposure_ev, ..picture() }).rgba[12..].to_vec()
        };
        let (dark, bright) = (exposed(-3.0), exposed(-1.0));
        assert!(dark[0] > 0 && dark[0] < bright[0] && dark[3] == 255, "{dark:?} {bright:?}");
    }
}

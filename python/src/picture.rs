//! Pictures of materials in scenes, rendered on the CPU as a worker renders them.

use std::sync::{Arc, LazyLock};

use brood_eval::{Developed, IMAGE_SIDE_MOST, SheetCell, centre_px, decode_linear, encode_png};
use brood_genome::preset::{Preset, neutral};
use brood_mesh::{ObjLimits, parse_obj};
use brood_program::Program;
use brood_protocol::{Backend, Frame, MeshSource, ObjectSource, PictureFormat, RenderedPicture};
use brood_scene::{MeshRef, PictureSize, Sampling, Scene};
use brood_worker::{LoadedMesh, Renderer};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::error::value_error;
use crate::material::NativeMaterial;
use crate::threads;

/// Largest side of a picture in pixels.
const SIDE_MAX_PX: u32 = 4096;
/// Gap between the pictures of a sheet in pixels.
const GAP_PX: u32 = 4;
/// Number of children around a centre.
const RING: usize = 20;

/// Renderer of the process, with its caches.
static RENDERER: LazyLock<Renderer> = LazyLock::new(|| Renderer::new(Backend::Cpu));

/// Scene with its mesh.
struct Shown {
    scene: Scene,
    source: MeshSource,
    mesh: Arc<LoadedMesh>,
    objects: Vec<ObjectSource>,
}

impl Shown {
    /// Reads a scene, and the OBJ file of its mesh if that is not built in.
    fn read(scene: &str, obj: Option<&[u8]>) -> PyResult<Self> {
        let mut scene: Scene = serde_json::from_str(scene)
            .map_err(|error| value_error(format!("`scene` is no scene: {error}")))?;
        if obj.is_some() {
            scene.mesh = MeshRef::Uploaded("file".to_owned());
        }
        scene.validate().map_err(|error| value_error(format!("`scene`: {error}")))?;
        if let Some((asset, pointer)) = scene.assets().next() {
            return Err(value_error(format!(
                "`scene`: {pointer} is a file ({asset:?}): scenes with profiles, environments and \
                 images are rendered by a server"
            )));
        }
        let (mesh, source) = match (scene.builtin(), obj) {
            (Some(mesh), _) => (RENDERER.builtin(mesh), MeshSource::Builtin),
            (None, Some(bytes)) => {
                let file = parse_obj(bytes, &ObjLimits::default())
                    .map_err(|error| value_error(format!("`mesh` is no OBJ file: {error}")))?;
                let mesh = LoadedMesh::new(file.mesh);
                let source = MeshSource::Uploaded(*mesh.hash());
                (Arc::new(mesh), source)
            }
            (None, None) => {
                return Err(value_error(
                    "`scene`: /mesh is an uploaded one; give its OBJ file as `mesh`",
                ));
            }
        };
        let objects = objects(&scene)?;
        Ok(Self { scene, source, mesh, objects })
    }

    fn frame(&self, size: PictureSize, sampling: Sampling, format: PictureFormat) -> Frame {
        let how = (format, Backend::Cpu);
        let frame = Frame::new(&self.scene, self.source, size, sampling, how);
        frame.with_objects(self.objects.clone())
    }
}

/// Returns the sources of a scene's other objects and its ground: built-in meshes and presets.
fn objects(scene: &Scene) -> PyResult<Vec<ObjectSource>> {
    for (index, object) in scene.objects.iter().enumerate() {
        if matches!(object.mesh, MeshRef::Uploaded(_)) {
            return Err(value_error(format!(
                "`scene`: /objects/{index}/mesh is an uploaded one; other objects must be built in"
            )));
        }
    }
    let source = |(name, pointer): (Option<&str>, String)| {
        let genome = match name {
            None => neutral(),
            Some(name) => Preset::find(name)
                .ok_or_else(|| value_error(format!("`scene`: {pointer} must be a preset")))?
                .genome(),
        };
        let words = brood_eval::express(genome).to_words();
        Ok(ObjectSource { mesh: MeshSource::Builtin, words })
    };
    scene.materials().map(source).collect()
}

/// Options of a picture.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    /// Scene as JSON.
    scene: String,
    /// OBJ file of its mesh.
    mesh: Option<Vec<u8>>,
    /// Width and height in pixels.
    size: (u32, u32),
    /// Samples per pixel; adaptive by default.
    samples: Option<u16>,
    threads: Option<usize>,
}

impl Options {
    fn checked(&self) -> PyResult<(PictureSize, Sampling)> {
        let (width, height) = self.size;
        if width.min(height) == 0 || width.max(height) > SIDE_MAX_PX {
            return Err(value_error(format!(
                "`size` must be 1 to {SIDE_MAX_PX} pixels a side, got {width} x {height}"
            )));
        }
        let sampling = match self.samples {
            None => Sampling::Adaptive,
            Some(count) if (1..=1024).contains(&count) => Sampling::Fixed(count),
            Some(count) => {
                return Err(value_error(format!("`samples` must be 1 to 1024, got {count}")));
            }
        };
        Ok((PictureSize { width, height }, sampling))
    }
}

/// Renders one material to a file of a format.
fn encoded(
    py: Python<'_>,
    material: &Bound<'_, NativeMaterial>,
    options: &Options,
    format: PictureFormat,
) -> PyResult<RenderedPicture> {
    let (size, sampling) = options.checked()?;
    let material = material.get();
    threads::run(py, options.threads, || {
        let shown = Shown::read(&options.scene, options.mesh.as_deref())?;
        let frame = shown.frame(size, sampling, format);
        let pictures = RENDERER.render(&frame, &shown.mesh, &[material.program()]);
        let picture = pictures.map_err(value_error)?.pop();
        Ok(picture.expect("there is a picture for the program"))
    })?
}

fn developed(
    shown: &Shown,
    programs: &[&Program],
    (size, sampling): (PictureSize, Sampling),
) -> PyResult<Vec<Developed>> {
    let frame = shown.frame(size, sampling, PictureFormat::Png);
    RENDERER.develop(&frame, &shown.mesh, programs).map_err(value_error)
}

/// Picture as PNG or EXR.
#[pyfunction]
pub(crate) fn picture<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    options: Options,
    linear: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let format = if linear { PictureFormat::Exr } else { PictureFormat::Png };
    Ok(PyBytes::new(py, &encoded(py, material, &options, format)?.bytes))
}

/// Developed picture: codes of red, green, blue and alpha.
#[pyfunction]
pub(crate) fn pixels<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    options: Options,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let how = options.checked()?;
    let material = material.get();
    let picture = threads::run(py, options.threads, || {
        let shown = Shown::read(&options.scene, options.mesh.as_deref())?;
        let pictures = developed(&shown, &[material.program()], how)?;
        Ok::<_, PyErr>(pictures.into_iter().next().expect("there is a picture for the program"))
    })??;
    let shape = [picture.height as usize, picture.width as usize, 4];
    PyArray1::from_vec(py, picture.rgba).reshape(shape)
}

/// Linear picture: red, green and blue, composed over black.
#[pyfunction]
pub(crate) fn radiance<'py>(
    py: Python<'py>,
    material: &Bound<'py, NativeMaterial>,
    options: Options,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let bytes = encoded(py, material, &options, PictureFormat::Exr)?.bytes;
    let picture = py.detach(|| decode_linear(&bytes, IMAGE_SIDE_MOST)).map_err(value_error)?;
    let shape = [picture.height as usize, picture.width as usize, 3];
    PyArray1::from_vec(py, picture.pixels.into_flattened()).reshape(shape)
}

/// Sheet of materials as PNG; twenty are placed around the centre if there is one.
#[pyfunction]
#[pyo3(signature = (materials, centre, options))]
pub(crate) fn sheet<'py>(
    py: Python<'py>,
    materials: Vec<Bound<'py, NativeMaterial>>,
    centre: Option<Bound<'py, NativeMaterial>>,
    options: Options,
) -> PyResult<Bound<'py, PyBytes>> {
    let (size, sampling) = options.checked()?;
    let side_px = size.width;
    let materials: Vec<&NativeMaterial> = materials.iter().map(Bound::get).collect();
    let centre = centre.as_ref().map(Bound::get).filter(|_| materials.len() == RING);
    let png = threads::run(py, options.threads, || {
        let shown = Shown::read(&options.scene, options.mesh.as_deref())?;
        let programs: Vec<&Program> = materials.iter().map(|it| it.program()).collect();
        let pictures = developed(&shown, &programs, (size, sampling))?;
        let large = PictureSize::from(centre_px(side_px, GAP_PX));
        let centre = match centre {
            Some(centre) => developed(&shown, &[centre.program()], (large, sampling))?.pop(),
            None => None,
        };
        let cells: Vec<SheetCell<'_>> = pictures.iter().map(cell).collect();
        let centre = centre.as_ref().map(cell);
        let (width, height, rgba) = brood_eval::sheet(&cells, centre, side_px, GAP_PX);
        Ok::<_, PyErr>(encode_png(width, height, &rgba))
    })??;
    Ok(PyBytes::new(py, &png))
}

fn cell(picture: &Developed) -> SheetCell<'_> {
    SheetCell { width: picture.width, height: picture.height, rgba: &picture.rgba }
}

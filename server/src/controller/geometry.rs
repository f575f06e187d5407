//! Triangles of a mesh, in the page's binary format and as glTF.

use axum::extract::State;
use axum::response::Response;
use brood_mesh::{BuiltinMesh, Mesh};
use brood_protocol::decode_stored;
use brood_scene::{MeshRef, Scene, SpherePole};
use http::HeaderMap;
use serde::Deserialize;

use super::file::FileHead;
use crate::extract::{Path, Query};
use crate::problem::ApiError;
use crate::state::App;

const CONTENT_TYPE: &str = "application/vnd.brood.geometry";
const GLTF_BINARY: &str = "model/gltf-binary";
const CACHE: &str = "private, no-cache";
const MAGIC: &[u8; 8] = b"broodgeo";
const VERSION: u32 = 1;

/// Texture of a mesh.
#[derive(Debug, Clone, Copy, Deserialize, utoipa::IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct TextureQuery {
    /// Axis through the poles of the texture of the mesh `sphere`: `y` (default) or `z`, which
    /// needs that mesh.
    #[serde(default)]
    #[param(inline)]
    sphere_pole: SpherePole,
}

/// Returns a mesh's geometry in a little-endian binary format.
///
/// `broodgeo`; u32 version 1, vertices, triangles, has_uv (0 or 1); f64 centre (3) and radius of
/// the bounding sphere; then f32 arrays: positions relative to the centre in radii (3 per vertex),
/// unit normals (3), unit tangents along u (3), texture coordinates (2); then u32 corners (3 per
/// triangle).
#[utoipa::path(get, path = "/v1/meshes/{id}/geometry", operation_id = "get_mesh_geometry", tag = "meshes",
    params(("id" = String, Path, description = "id of a mesh, name of a built-in mesh, or `ground`"), TextureQuery),
    responses((status = 200, description = "geometry in the binary format above",
        content_type = "application/vnd.brood.geometry"),
        (status = 304)))]
pub async fn get(
    State(app): State<App>,
    Path(id): Path<String>,
    Query(query): Query<TextureQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let bytes = encoded(&app, &id, query, encode).await?;
    Ok(answer(&headers, CONTENT_TYPE, bytes))
}

/// Returns a mesh with its tangents as a glTF 2.0 binary, to preview exported materials in other
/// renderers.
///
/// POSITION in the mesh's own units, NORMAL, TANGENT along u, and TEXCOORD_0 if the mesh has
/// texture coordinates.
#[utoipa::path(get, path = "/v1/meshes/{id}/mesh.glb", operation_id = "get_mesh_glb", tag = "meshes",
    params(("id" = String, Path, description = "id of a mesh, name of a built-in mesh, or `ground`"), TextureQuery),
    responses((status = 200, description = "mesh as glTF 2.0 binary", content_type = "model/gltf-binary"),
        (status = 304)))]
pub async fn glb(
    State(app): State<App>,
    Path(id): Path<String>,
    Query(query): Query<TextureQuery>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let bytes = encoded(&app, &id, query, Mesh::to_glb).await?;
    Ok(answer(&headers, GLTF_BINARY, bytes))
}

/// Encodes a built-in or uploaded mesh.
async fn encoded(
    app: &App,
    id: &str,
    TextureQuery { sphere_pole }: TextureQuery,
    encode: fn(&Mesh) -> Vec<u8>,
) -> Result<Vec<u8>, ApiError> {
    let scene = Scene { mesh: MeshRef::from(id), sphere_pole, ..Scene::default() };
    if sphere_pole == SpherePole::Z && scene.builtin() != Some(BuiltinMesh::SphereZ) {
        return Err(ApiError::bad_parameter("sphere_pole", "`z` needs the mesh `sphere`"));
    }
    let is_ground = id == BuiltinMesh::Ground.name();
    let encoded = match scene.builtin().or(is_ground.then_some(BuiltinMesh::Ground)) {
        Some(name) => app.processors.run(move || Ok(encode(&Mesh::builtin(name)))).await?,
        None => {
            let unknown = |_| ApiError::not_found("there is no mesh with this id or name");
            let row = app.store.mesh(id.parse().map_err(unknown)?).await?;
            let data = app.store.mesh_data(row.content_hash).await?;
            let read = move || decode_stored::<Mesh>(&data).map(|mesh| encode(&mesh));
            app.processors.run(read).await?
        }
    };
    encoded.map_err(|error| ApiError::internal(format!("cannot read a stored mesh: {error}")))
}

fn answer(headers: &HeaderMap, content_type: &'static str, bytes: Vec<u8>) -> Response {
    let etag = format!("\"{}\"", blake3::hash(&bytes).to_hex());
    FileHead { etag, content_type, cache: CACHE }.answer(headers, bytes)
}

fn encode(mesh: &Mesh) -> Vec<u8> {
    let parts = mesh.parts();
    let (vertices, triangles) = (parts.positions.len(), parts.triangles.len());
    let mut bytes = Vec::with_capacity(56 + 44 * vertices + 12 * triangles);
    bytes.extend_from_slice(MAGIC);
    let count = |count| u32::try_from(count).expect("a mesh's counts fit 32 bits");
    for number in [VERSION, count(vertices), count(triangles), u32::from(parts.has_uv)] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    for number in mesh.centre().to_array().into_iter().chain([mesh.radius()]) {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    let (centre, radius) = (mesh.centre(), mesh.radius());
    let relative = parts.positions.iter().map(|place| (*place - centre) / radius);
    put(&mut bytes, relative.map(|place| place.as_vec3().to_array()));
    put(&mut bytes, parts.normals.iter().map(|normal| normal.as_vec3().to_array()));
    put(&mut bytes, parts.tangents.iter().map(|tangent| tangent.as_vec3().to_array()));
    put(&mut bytes, parts.uvs.iter().map(|uv| uv.as_vec2().to_array()));
    for corner in parts.triangles.iter().flatten() {
        bytes.extend_from_slice(&corner.to_le_bytes());
    }
    bytes
}

fn put<const N: usize>(bytes: &mut Vec<u8>, values: impl Iterator<Item = [f32; N]>) {
    for value in values.flatten() {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use brood_mesh::BuiltinMesh;

    use super::*;

    #[test]
    fn geometry_has_the_length_of_its_header_and_a_radius_of_one() {
        let mesh = Mesh::builtin(BuiltinMesh::Torus);
        let bytes = encode(&mesh);
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let (vertices, triangles) = (word(12), word(16));
        assert_eq!((word(8), word(20)), (1, 1));
        assert_eq!((vertices, triangles), (mesh.vertex_count(), mesh.triangle_count()));
        assert_eq!(bytes.len(), 56 + 44 * vertices + 12 * triangles);
        let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let length = |k: usize| (0..3).map(|c| number(56 + 12 * k + 4 * c).powi(2)).sum::<f32>();
        let farthest = (0..vertices).map(length).fold(0.0, f32::max);
        assert!((farthest - 1.0).abs() < 1e-5, "{farthest}");
        let corners = 56 + 44 * vertices;
        assert!((0..3 * triangles).all(|k| word(corners + 4 * k) < vertices));
    }
}

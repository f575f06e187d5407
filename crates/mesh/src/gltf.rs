//! Export of meshes as glTF binaries with tangents.
//!
//! Programs depend on the tangent frame, which a vertex shader cannot derive by itself, so a
//! material exported as shader code needs its mesh with tangents.

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use crate::Mesh;

const MAGIC: u32 = 0x4654_6c67;
const VERSION: u32 = 2;
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;
/// glTF codes of component types and buffer view targets.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

impl Mesh {
    /// Encodes the mesh as a glTF 2.0 binary (`.glb`) with one primitive: POSITION, NORMAL,
    /// TANGENT, TEXCOORD_0 if the mesh has texture positions, and indices.
    ///
    /// TANGENT is the direction of growing u used in shading, orthogonal to the normal; its w is
    /// always 1, because y = n x u also where a texture is mirrored. TEXCOORD_0 has v downwards, as
    /// glTF requires.
    ///
    /// # Units
    /// The mesh's own, y up.
    ///
    /// # Error
    /// Everything is rounded to f32; normals and tangents are unit to 1e-6.
    ///
    /// # Source
    /// Khronos, *glTF 2.0 Specification*, sections 3.7.2 and 4.4.
    #[must_use]
    pub fn to_glb(&self) -> Vec<u8> {
        self.glb(None)
    }

    /// As [`Mesh::to_glb`], with a material of glTF. Its extensions are listed as used.
    #[must_use]
    pub fn to_glb_with(&self, material: &Value) -> Vec<u8> {
        self.glb(Some(material))
    }

    fn glb(&self, material: Option<&Value>) -> Vec<u8> {
        let parts = self.parts();
        let unit = |vector: &DVec3| vector.as_vec3().normalize_or(Vec3::Z).to_array();
        let positions: Vec<[f32; 3]> =
            parts.positions.iter().map(|position| position.as_vec3().to_array()).collect();
        let bound = |select: fn(f32, f32) -> f32| {
            let join = |a: [f32; 3], b: &[f32; 3]| {
                [select(a[0], b[0]), select(a[1], b[1]), select(a[2], b[2])]
            };
            positions.iter().fold(positions[0], join)
        };
        let mut file = GlbBuilder::default();
        file.add(ARRAY_BUFFER, FLOAT, "VEC3", &positions, |accessor| {
            accessor["min"] = json!(bound(f32::min));
            accessor["max"] = json!(bound(f32::max));
        });
        let normals: Vec<[f32; 3]> = parts.normals.iter().map(unit).collect();
        file.add(ARRAY_BUFFER, FLOAT, "VEC3", &normals, |_| {});
        let with_handedness = |vector: &DVec3| {
            let [x, y, z] = unit(vector);
            [x, y, z, 1.0]
        };
        let tangents: Vec<[f32; 4]> = parts.tangents.iter().map(with_handedness).collect();
        file.add(ARRAY_BUFFER, FLOAT, "VEC4", &tangents, |_| {});
        let mut attributes = json!({ "POSITION": 0, "NORMAL": 1, "TANGENT": 2 });
        if parts.has_uv {
            let uvs: Vec<[f32; 2]> =
                parts.uvs.iter().map(|uv| [uv.x as f32, (1.0 - uv.y) as f32]).collect();
            attributes["TEXCOORD_0"] = file.add(ARRAY_BUFFER, FLOAT, "VEC2", &uvs, |_| {}).into();
        }
        let corners: Vec<[u32; 1]> =
            parts.triangles.iter().flatten().map(|&corner| [corner]).collect();
        let indices = file.add(ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR", &corners, |_| {});
        let primitive = json!({ "attributes": attributes, "indices": indices, "mode": 4 });
        file.finish(primitive, material)
    }
}

/// Builder of the binary chunk with its buffer views and accessors.
#[derive(Default)]
struct GlbBuilder {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl GlbBuilder {
    /// Appends an array and returns its accessor index. Every component is four bytes, so the
    /// alignment holds.
    fn add<T: bytemuck::Pod>(
        &mut self,
        target: u32,
        component: u32,
        kind: &str,
        values: &[T],
        describe: impl FnOnce(&mut Value),
    ) -> usize {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        let view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        });
        let mut accessor = json!({
            "bufferView": self.views.len(), "componentType": component, "count": values.len(), "type": kind,
        });
        describe(&mut accessor);
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Returns the file with one mesh of this primitive.
    fn finish(self, mut primitive: Value, material: Option<&Value>) -> Vec<u8> {
        if material.is_some() {
            primitive["material"] = 0.into();
        }
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "brood" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [primitive] }],
            "buffers": [{ "byteLength": self.bytes.len() }],
            "bufferViews": self.views,
            "accessors": self.accessors,
        });
        if let Some(material) = material {
            document["materials"] = json!([material]);
            if let Some(extensions) = material["extensions"].as_object() {
                document["extensionsUsed"] = extensions.keys().cloned().collect();
            }
        }
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = |bytes: usize| u32::try_from(bytes).expect("a mesh is smaller than 4 GiB");
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        let mut file = Vec::with_capacity(total);
        let words = |file: &mut Vec<u8>, words: &[u32]| {
            file.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        };
        words(&mut file, &[MAGIC, VERSION, length(total), length(text.len()), JSON_CHUNK]);
        file.extend_from_slice(&text);
        words(&mut file, &[length(self.bytes.len()), BINARY_CHUNK]);
        file.extend_from_slice(&self.bytes);
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BuiltinMesh, ObjLimits, parse_obj};

    /// Parses a file; returns its JSON document and a function that reads an accessor as floats.
    fn read(file: &[u8]) -> (Value, impl Fn(usize) -> Vec<f32> + use<>) {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((word(0), word(4), word(8)), (MAGIC as usize, 2, file.len()));
        let text = word(12);
        assert_eq!((word(16), text % 4), (JSON_CHUNK as usize, 0));
        assert_eq!(word(20 + text + 4), BINARY_CHUNK as usize);
        assert_eq!(28 + text + word(20 + text), file.len());
        let description: Value = serde_json::from_slice(&file[20..20 + text]).unwrap();
        let (views, bytes) = (description["bufferViews"].clone(), file[28 + text..].to_vec());
        let floats = move |accessor: usize| {
            let number = |name: &str| views[accessor][name].as_u64().unwrap() as usize;
            let range = number("byteOffset")..number("byteOffset") + number("byteLength");
            bytes[range].chunks(4).map(|it| f32::from_le_bytes(it.try_into().unwrap())).collect()
        };
        (description, floats)
    }

    #[test]
    fn glb_has_unit_tangents_orthogonal_to_normals() {
        for builtin in BuiltinMesh::ALL {
            let mesh = Mesh::builtin(builtin);
            let (description, floats) = read(&mesh.to_glb());
            let [positions, normals, tangents] = [floats(0), floats(1), floats(2)];
            assert_eq!(positions.len(), 3 * mesh.vertex_count());
            for (normal, tangent) in normals.chunks(3).zip(tangents.chunks(4)) {
                let (n, t) = (Vec3::from_slice(normal), Vec3::from_slice(tangent));
                assert!(n.dot(t).abs() < 1e-5 && t.is_normalized() && n.is_normalized(), "{n} {t}");
                assert!(tangent[3] > 0.5);
            }
            let lowest =
                positions.chunks(3).map(|position| position[1]).fold(f32::INFINITY, f32::min);
            assert_eq!(description["accessors"][0]["min"][1].as_f64(), Some(f64::from(lowest)));
            assert_eq!(description["accessors"][4]["count"], 3 * mesh.triangle_count());
        }
    }

    #[test]
    fn glb_has_the_material_and_lists_its_extensions() {
        let material = json!({ "name": "red", "extensions": { "KHR_materials_sheen": {} } });
        let (description, _) = read(&Mesh::builtin(BuiltinMesh::Torus).to_glb_with(&material));
        assert_eq!(description["materials"], json!([material]));
        assert_eq!(description["extensionsUsed"], json!(["KHR_materials_sheen"]));
        assert_eq!(description["meshes"][0]["primitives"][0]["material"], 0);
        let (without, _) = read(&Mesh::builtin(BuiltinMesh::Torus).to_glb());
        assert!(without.get("materials").is_none());
    }

    #[test]
    fn glb_flips_v_and_omits_missing_texture_positions() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0.25\nvt 0 1\nf 1/1 2/2 3/3\n";
        let mesh = parse_obj(text.as_bytes(), &ObjLimits::default()).unwrap().mesh;
        let (description, floats) = read(&mesh.to_glb());
        assert_eq!(description["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"], 3);
        assert_eq!(floats(3)[..2], [0.0, 0.75]);
        let without_uv =
            parse_obj(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &ObjLimits::default()).unwrap();
        let (description, _) = read(&without_uv.mesh.to_glb());
        assert!(description["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"].is_null());
    }
}

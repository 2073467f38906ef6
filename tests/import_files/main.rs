//! Models from files: glTF documents made here, of the kinds that exporters write, and OBJ.

mod well_known;

use bevy_cleave::import::{ImportOptions, Model, ModelFileError};
use bevy_cleave::prelude::*;
use glam::{Mat4, Quat, Vec3};
use serde_json::{Value, json};

const BASE64: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn data_uri(bytes: &[u8]) -> String {
    let mut text = String::from("data:application/octet-stream;base64,");
    for chunk in bytes.chunks(3) {
        let word = chunk
            .iter()
            .fold(0_u32, |word, &b| word << 8 | u32::from(b))
            << (8 * (3 - chunk.len()));
        for k in 0..4 {
            let digit = BASE64[(word >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= chunk.len() { digit as char } else { '=' });
        }
    }
    text
}

/// A unit cube about the origin: positions and indices.
fn cube() -> (Vec<Vec3>, Vec<u16>) {
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).unwrap().hull().to_mesh();
    let indices = mesh
        .triangles()
        .iter()
        .flatten()
        .map(|&v| v as u16)
        .collect();
    (mesh.positions().to_vec(), indices)
}

/// A document of one buffer with a cube in it, drawn by one mesh; `nodes` use it as mesh 0.
fn document(nodes: Value) -> (Value, Vec<u8>) {
    let (positions, indices) = cube();
    let mut bytes: Vec<u8> = positions
        .iter()
        .flat_map(|p| p.to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let split = bytes.len();
    bytes.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
    let document = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.as_array().unwrap().len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": [{ "name": "cube", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3", "min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5] },
            { "bufferView": 1, "componentType": 5123, "count": indices.len(), "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": split },
            { "buffer": 0, "byteOffset": split, "byteLength": bytes.len() - split }
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": data_uri(&bytes) }]
    });
    (document, bytes)
}

fn read(document: &Value) -> Result<Model, ModelFileError> {
    let nothing = |_: &str| Err(std::io::ErrorKind::NotFound.into());
    Model::from_gltf(document.to_string().as_bytes(), nothing)
}

fn volume(model: &Model) -> f64 {
    model
        .import(&ImportOptions::default())
        .unwrap()
        .mesh
        .volume()
}

#[test]
fn nodes_with_transforms_are_objects_and_mirrored_ones_face_outwards() {
    let (document, _) = document(json!([
        { "name": "left", "mesh": 0, "translation": [-2.0, 0.0, 0.0] },
        { "name": "large", "mesh": 0, "scale": [2.0, 2.0, 2.0], "rotation": [0.0, 0.38268343, 0.0, 0.92387953] },
        { "name": "mirrored", "mesh": 0, "translation": [2.5, 0.0, 0.0], "scale": [-1.0, 1.0, 1.0] }
    ]));
    let model = read(&document).unwrap();
    let names: Vec<&str> = model
        .objects
        .iter()
        .map(|object| object.name.as_str())
        .collect();
    assert_eq!(names, ["left", "large", "mirrored"]);
    let import = model.import(&ImportOptions::default()).unwrap();
    assert!((import.mesh.volume() - 10.0).abs() < 1e-5);
    assert!(import.report.is_untouched(), "{}", import.report);
    assert!(!import.mesh.normals().is_empty());
}

#[test]
fn children_are_placed_by_their_parents() {
    let (mut document, _) = document(json!([
        { "translation": [0.0, 5.0, 0.0], "children": [1] },
        { "mesh": 0, "translation": [1.0, 0.0, 0.0] }
    ]));
    document["scenes"][0]["nodes"] = json!([0]);
    let model = read(&document).unwrap();
    let import = model.import(&ImportOptions::default()).unwrap();
    assert!(
        import
            .mesh
            .aabb()
            .center()
            .distance(Vec3::new(1.0, 5.0, 0.0))
            < 1e-6
    );
    document["nodes"][1]["children"] = json!([0]);
    assert!(matches!(
        read(&document),
        Err(ModelFileError::Damaged { .. })
    ));
}

#[test]
fn extensions_that_change_no_shape_are_left_out_and_noted() {
    let (mut document, _) = document(json!([{ "mesh": 0 }]));
    for extension in [
        "KHR_lights_punctual",
        "KHR_materials_unlit",
        "KHR_texture_basisu",
    ] {
        document["extensionsUsed"] = json!([extension]);
        document["extensionsRequired"] = json!([extension]);
        let model = read(&document).unwrap();
        assert!((volume(&model) - 1.0).abs() < 1e-6);
        assert!(model.notes[0].contains(extension), "{:?}", model.notes);
    }
}

#[test]
fn compression_is_named_as_what_it_is() {
    let (document, _) = document(json!([{ "mesh": 0 }]));
    let kinds = [
        ("KHR_draco_mesh_compression", "Draco"),
        ("EXT_meshopt_compression", "meshopt"),
        ("KHR_meshopt_compression", "meshopt"),
    ];
    for (extension, name) in kinds {
        let mut required = document.clone();
        required["extensionsUsed"] = json!([extension]);
        required["extensionsRequired"] = json!([extension]);
        let error = read(&required).unwrap_err().to_string();
        assert!(
            error.contains(name) && error.contains("without compression"),
            "{error}"
        );
        // Used, not required, and the data is nowhere else.
        let mut used = document.clone();
        used["extensionsUsed"] = json!([extension]);
        used["accessors"][0]
            .as_object_mut()
            .unwrap()
            .remove("bufferView");
        let error = read(&used).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
}

#[test]
fn files_beside_the_document_and_glb_are_read() {
    let (mut document, bytes) = document(json!([{ "mesh": 0 }]));
    document["buffers"][0]["uri"] = json!("my%20cube.bin");
    let beside = |uri: &str| {
        assert_eq!(uri, "my cube.bin");
        Ok(bytes.clone())
    };
    let text = document.to_string();
    assert!((volume(&Model::from_gltf(text.as_bytes(), beside).unwrap()) - 1.0).abs() < 1e-6);
    assert!(matches!(
        read(&document),
        Err(ModelFileError::Unreadable { .. })
    ));
    document["buffers"][0]
        .as_object_mut()
        .unwrap()
        .remove("uri");
    let pad = |mut chunk: Vec<u8>, with: u8| {
        chunk.resize(chunk.len().next_multiple_of(4), with);
        chunk
    };
    let (json, bin) = (pad(document.to_string().into_bytes(), b' '), pad(bytes, 0));
    let mut glb = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    for word in [2, total as u32, json.len() as u32, 0x4E4F_534A] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(&json);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(0x004E_4942_u32.to_le_bytes());
    glb.extend(&bin);
    let folder = std::env::temp_dir().join(format!("bevy_cleave_import_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("cube.GLB");
    std::fs::write(&path, &glb).unwrap();
    assert!((volume(&Model::load(&path).unwrap()) - 1.0).abs() < 1e-6);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn damaged_files_are_refused_and_never_panic() {
    let (good, bytes) = document(json!([{ "mesh": 0 }]));
    let mut short = good.clone();
    short["buffers"][0]["uri"] = json!(data_uri(&bytes[..bytes.len() / 2]));
    assert!(matches!(
        read(&short),
        Err(ModelFileError::MissingData { .. })
    ));
    let mut wild = good.clone();
    wild["accessors"][0]["bufferView"] = json!(7);
    assert!(matches!(read(&wild), Err(ModelFileError::Damaged { .. })));
    let text = good.to_string();
    for end in (0..text.len()).step_by(97) {
        let nothing = |_: &str| Err(std::io::ErrorKind::NotFound.into());
        assert!(Model::from_gltf(&text.as_bytes()[..end], nothing).is_err());
    }
    assert!(matches!(
        Model::load("nowhere.glb"),
        Err(ModelFileError::Unreadable { .. })
    ));
    assert!(matches!(
        Model::load("thing.fbx"),
        Err(ModelFileError::UnknownFormat { .. })
    ));
}

#[test]
fn strips_quantized_positions_and_skins_at_rest_are_read() {
    // A tetrahedron as a strip, its corners as normalized 16-bit numbers.
    let corners: [[i16; 4]; 4] = [
        [0, 0, 0, 0],
        [32767, 0, 0, 0],
        [0, 32767, 0, 0],
        [0, 0, 32767, 0],
    ];
    let mut bytes: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|c| c.to_le_bytes())
        .collect();
    let strip: [u8; 6] = [0, 2, 1, 3, 0, 2];
    bytes.extend(strip);
    bytes.extend([0, 0]);
    let joints = bytes.len();
    for _ in 0..4 {
        bytes.extend([1_u8, 0, 0, 0]);
    }
    let weights = bytes.len();
    for _ in 0..4 {
        bytes.extend([1.0_f32, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat());
    }
    let inverse_bind = bytes.len();
    let bind = Mat4::from_translation(Vec3::new(0.0, -1.0, 0.0));
    for matrix in [Mat4::IDENTITY, bind] {
        bytes.extend(matrix.to_cols_array().map(f32::to_le_bytes).concat());
    }
    let quarter = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2).to_array();
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "mesh": 0, "skin": 0, "translation": [100.0, 0.0, 0.0] },
            { "translation": [0.0, 3.0, 0.0], "children": [2] },
            { "rotation": quarter }
        ],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": 4 }],
        "meshes": [{ "primitives": [{ "mode": 5, "attributes": { "POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5122, "normalized": true, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [32767, 32767, 32767] },
            { "bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4" },
            { "bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC4" },
            { "bufferView": 4, "componentType": 5126, "count": 2, "type": "MAT4" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 32, "byteStride": 8 },
            { "buffer": 0, "byteOffset": 32, "byteLength": 6 },
            { "buffer": 0, "byteOffset": joints, "byteLength": 16 },
            { "buffer": 0, "byteOffset": weights, "byteLength": 64 },
            { "buffer": 0, "byteOffset": inverse_bind, "byteLength": 128 }
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": data_uri(&bytes) }]
    });
    let model = read(&document).unwrap();
    let import = model.import(&ImportOptions::default()).unwrap();
    assert!(
        (import.mesh.volume() - 1.0 / 6.0).abs() < 1e-4,
        "{}",
        import.report
    );
    // Joint 1 is turned by a quarter at height 3, and the bind pose had its origin one higher: (x, y) -> (1 - y, 3 + x).
    let aabb = import.mesh.aabb();
    assert!(
        aabb.min.distance(Vec3::new(0.0, 3.0, 0.0)) < 1e-4,
        "{aabb:?}"
    );
    assert!(
        aabb.max.distance(Vec3::new(1.0, 4.0, 1.0)) < 1e-4,
        "{aabb:?}"
    );
}

#[test]
fn the_models_of_the_tests_are_read_and_closed() {
    for name in [
        "barrel",
        "floor_tile",
        "rubble",
        "wall_broken",
        "demosthenes",
        "building",
        "candle",
        "spot",
    ] {
        let path = format!("{}/assets/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"));
        let model = Model::load(path).unwrap();
        // The floor tile has no underside, which is almost half of its area.
        let options = ImportOptions {
            max_fill: 1.0,
            ..ImportOptions::default()
        };
        let import = (model.import(&options)).unwrap_or_else(|e| panic!("{name}: {e}"));
        import.mesh.check_closed().unwrap();
        assert!(import.mesh.volume() > 0.0, "{name}");
        import.shape().unwrap();
    }
}

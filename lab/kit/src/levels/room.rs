//! A small level as files: a lightmapped room with a block, a grate, a pane and lamps.

use std::{fs, path::Path};

use bevy::prelude::*;
use serde_json::{Value, json};

use crate::headless::Picture;

/// Texels per side of the lightmap.
const LIGHTMAP: u32 = 16;

/// Numbers of glTF 2.0, sections 3.6.2.2 and 5.11.5: types of components, and targets of buffer views.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// A parallelogram: a corner, and the edges from it. Its front is where their cross product points.
type Quad = [[f32; 3]; 3];

/// A floor and two walls.
const SHELL: [Quad; 3] = [
    [[-2.0, 0.0, 2.0], [4.0, 0.0, 0.0], [0.0, 0.0, -4.0]],
    [[-2.0, 0.0, -2.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
    [[-2.0, 0.0, 2.0], [0.0, 0.0, -4.0], [0.0, 3.0, 0.0]],
];
const BLOCK: [Quad; 4] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
    [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
];
const GRATE: [Quad; 1] = [[[-1.5, 0.0, -0.8], [1.0, 0.0, 0.0], [0.0, 1.2, 0.0]]];
const PANE: [Quad; 1] = [[[-1.2, 0.3, 0.8], [1.4, 0.0, 0.0], [0.0, 1.1, 0.0]]];

/// Writes `scene.gltf`, its buffer, its lightmap and `level.json` into `folder`, which is created.
pub fn write_room(folder: &Path) -> Result<(), String> {
    let says = |error: std::io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(folder.join("lightmaps")).map_err(says)?;
    lightmap().try_save(folder.join("lightmaps/room.png"))?;
    let mut buffer = Buffer::default();
    let meshes: Vec<Value> = [&SHELL[..], &BLOCK, &GRATE, &PANE]
        .into_iter()
        .enumerate()
        .map(|(index, quads)| buffer.mesh(quads, index))
        .collect();
    let files = [
        ("scene.bin", buffer.bytes.clone()),
        ("scene.gltf", document(meshes, buffer).to_string().into()),
        ("level.json", level().to_string().into()),
    ];
    for (name, bytes) in files {
        fs::write(folder.join(name), bytes).map_err(says)?;
    }
    Ok(())
}

/// Views, and the light that the glTF file has no place for.
fn level() -> Value {
    json!({
        "name": "room",
        "ev100": 1.0,
        "lightmap_exposure": 2.0,
        "ambient": [0.0, 0.0, 0.0],
        "sky": [0.05, 0.1, 0.2],
        "suns": [{ "color": [1.0, 0.9, 0.8], "to_sun": [2.0, 4.0, 3.0], "lux": 3.0 }],
        "views": [
            { "position": [1.6, 1.7, 3.4], "target": [-0.3, 0.8, -0.5] },
            { "position": [0.4, 1.2, 2.6], "target": [-0.9, 0.7, 0.0] },
        ],
    })
}

fn document(meshes: Vec<Value>, buffer: Buffer) -> Value {
    let lamps = [
        ([-1.0, 1.8, 0.0], [1.0, 0.6, 0.3]),
        ([1.2, 1.4, 0.8], [0.3, 0.6, 1.0]),
        ([0.0, 2.2, -1.4], [0.7, 1.0, 0.6]),
    ];
    let lights: Vec<Value> = lamps
        .iter()
        .map(
            |(_, color)| json!({ "type": "point", "color": color, "intensity": 6.0, "range": 4.0 }),
        )
        .collect();
    let nodes: Vec<Value> = (0..meshes.len())
        .map(|mesh| json!({ "mesh": mesh }))
        .chain(lamps.iter().enumerate().map(|(light, (place, _))| {
            json!({ "translation": place, "extensions": { "KHR_lights_punctual": { "light": light } } })
        }))
        .collect();
    let scene: Vec<usize> = (0..nodes.len()).collect();
    let rough = |color: [f32; 4]| json!({ "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 0.6 });
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": lights } },
        "scene": 0,
        "scenes": [{ "nodes": scene }],
        "nodes": nodes,
        "meshes": meshes,
        // The grate's alpha is the same everywhere, and above its cutoff.
        "materials": [
            {
                "name": "shell", "pbrMetallicRoughness": rough([0.6, 0.55, 0.5, 1.0]),
                "extras": { "lightmap": "room.png" },
            },
            { "name": "block", "pbrMetallicRoughness": rough([0.7, 0.3, 0.2, 1.0]) },
            {
                "name": "grate", "pbrMetallicRoughness": rough([0.4, 0.5, 0.3, 0.8]),
                "alphaMode": "MASK", "doubleSided": true,
            },
            {
                "name": "pane", "pbrMetallicRoughness": rough([0.5, 0.7, 0.9, 0.4]),
                "alphaMode": "BLEND", "doubleSided": true,
            },
        ],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "uri": "scene.bin", "byteLength": buffer.bytes.len() }],
    })
}

/// Light that is warm on one side and cold on the other, with a dark spot.
fn lightmap() -> Picture {
    let texel = |index: u32| {
        let at = UVec2::new(index % LIGHTMAP, index / LIGHTMAP).as_vec2() / LIGHTMAP as f32;
        let shade = (2.5 * at.distance(Vec2::splat(0.5))).min(1.0);
        let light = Vec3::new(0.6, 0.45, 0.3).lerp(Vec3::new(0.15, 0.25, 0.4), at.x);
        let [red, green, blue] = (light * shade * 255.0).to_array().map(|x| x as u8);
        [red, green, blue, 255]
    };
    Picture {
        size: UVec2::splat(LIGHTMAP),
        rgba: (0..LIGHTMAP * LIGHTMAP).flat_map(texel).collect(),
    }
}

/// The buffer of a glTF file under construction.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Adds a mesh of quads. Each has the whole texture and the whole lightmap.
    fn mesh(&mut self, quads: &[Quad], material: usize) -> Value {
        let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
        let mut indices = Vec::new();
        for (quad, [corner, right, up]) in (0u16..).zip(quads) {
            let [corner, right, up] = [corner, right, up].map(|v| Vec3::from(*v));
            let normal = right.cross(up).normalize();
            for [u, v] in [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                positions.push((corner + u * right + v * up).to_array());
                normals.push(normal.to_array());
                uvs.push([u, 1.0 - v]);
            }
            indices.extend([0, 1, 2, 0, 2, 3].map(|vertex: u16| 4 * quad + vertex));
        }
        let at = |axis: usize| positions.iter().map(move |p| p[axis]);
        let least: [f32; 3] = [0, 1, 2].map(|axis| at(axis).fold(f32::INFINITY, f32::min));
        let most: [f32; 3] = [0, 1, 2].map(|axis| at(axis).fold(f32::NEG_INFINITY, f32::max));
        let vertices = positions.len();
        let position = self.accessor(&floats(&positions), FLOAT, "VEC3", vertices, VERTICES);
        self.accessors[position]["min"] = json!(least);
        self.accessors[position]["max"] = json!(most);
        let normal = self.accessor(&floats(&normals), FLOAT, "VEC3", vertices, VERTICES);
        let uv = self.accessor(&floats(&uvs), FLOAT, "VEC2", vertices, VERTICES);
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(&bytes, UNSIGNED_SHORT, "SCALAR", indices.len(), INDICES);
        json!({ "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv, "TEXCOORD_1": uv },
            "indices": indices,
            "material": material,
        }] })
    }

    /// Appends data and returns the index of its accessor.
    fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        kind: &str,
        count: usize,
        target: u32,
    ) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target
        }));
        self.bytes.extend(bytes);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": kind
        }));
        self.accessors.len() - 1
    }
}

fn floats<const N: usize>(vectors: &[[f32; N]]) -> Vec<u8> {
    let floats = vectors.as_flattened().iter();
    floats.flat_map(|float| float.to_le_bytes()).collect()
}

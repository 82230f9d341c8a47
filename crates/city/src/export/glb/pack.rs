//! Meshes packed as glTF 2.0 in one binary file.

use super::{Group, Model, Surface, Tile, TileKey};
use geom::Mesh;
use gltf::binary::{Glb, Header};
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target, View};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::scene::Node;
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Buffer, Index, Material, Root, Scene, Value};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;

/// Why a model can't be packed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GlbError {
    /// The file would be larger than its format can say.
    #[error("the model takes {bytes} bytes, more than the 4 GiB that a .glb holds")]
    TooLarge {
        /// What it takes.
        bytes: usize,
    },
    /// Its description could not be written.
    #[error("the description of the model could not be written: {0}")]
    Json(String),
    /// The file could not be written.
    #[error("{0}")]
    Written(String),
}

/// The views of the one buffer, in this order.
const POSITIONS: u32 = 0;
const NORMALS: u32 = 1;
const INDICES: u32 = 2;

/// Writes the model as a `.glb` file.
///
/// # Errors
/// When it does not fit the format, and those of the writer.
pub fn write(model: &Model, out: impl Write) -> Result<(), GlbError> {
    let meshes = || model.tiles.values().flat_map(Tile::values);
    let (corners, indices) = meshes()
        .fold((0, 0), |(corners, indices), mesh| (corners + mesh.positions.len(), indices + mesh.indices.len()));
    // Room for all from the start: to move a hundred megabytes again and again takes longer than to fill them.
    let mut packer = Packer {
        positions: Vec::with_capacity(12 * corners),
        normals: Vec::with_capacity(12 * corners),
        indices: Vec::with_capacity(4 * indices + 4 * meshes().count()),
        ..Packer::default()
    };
    packer.root.asset.generator = Some("Plat".into());
    let tiles: Vec<_> = model.tiles.iter().map(|(&key, tile)| packer.tile(key, tile)).collect();
    let about = serde_json::json!({ "crs": model.crs, "origin": model.origin.map(|at| [at.x, at.y]) });
    let extras = serde_json::value::to_raw_value(&about).map_err(|error| GlbError::Json(error.to_string()))?;
    let scene = Scene { name: Some("city".into()), nodes: tiles, extras: Some(extras), extensions: None };
    packer.root.scene = Some(packer.root.push(scene));
    packer.finish(out)
}

#[derive(Default)]
struct Packer {
    root: Root,
    materials: BTreeMap<Surface, Index<Material>>,
    positions: Vec<u8>,
    normals: Vec<u8>,
    indices: Vec<u8>,
}

impl Packer {
    /// A tile with a child for each group that it has.
    fn tile(&mut self, key: TileKey, tile: &Tile) -> Index<Node> {
        let mut groups: BTreeMap<Group, Vec<(Surface, &Mesh)>> = BTreeMap::new();
        for (&(group, surface), mesh) in tile {
            groups.entry(group).or_default().push((surface, &**mesh));
        }
        let place = format!("{} {}", key.column, key.row);
        let children = groups.into_iter().map(|(group, meshes)| self.group(group, &place, &meshes)).collect();
        let origin = key.origin();
        let translation = Some([origin.x as f32, 0.0, -origin.y as f32]);
        self.root.push(Node {
            name: Some(format!("tile {place}")),
            children: Some(children),
            translation,
            ..Node::default()
        })
    }

    fn group(&mut self, group: Group, place: &str, meshes: &[(Surface, &Mesh)]) -> Index<Node> {
        let name = Some(format!("{} {place}", group_name(group)));
        let primitives = meshes.iter().map(|(surface, mesh)| self.primitive(*surface, mesh)).collect();
        let mesh = gltf_json::Mesh { name: name.clone(), primitives, weights: None, extensions: None, extras: None };
        let mesh = Some(self.root.push(mesh));
        self.root.push(Node { name, mesh, ..Node::default() })
    }

    fn primitive(&mut self, surface: Surface, mesh: &Mesh) -> Primitive {
        let positions = self.vectors(POSITIONS, &mesh.positions);
        let normals = self.vectors(NORMALS, &mesh.normals);
        let attributes = [(Semantic::Positions, positions), (Semantic::Normals, normals)];
        Primitive {
            attributes: attributes.into_iter().map(|(semantic, index)| (Checked::Valid(semantic), index)).collect(),
            indices: Some(self.triangles(&mesh.indices, mesh.positions.len())),
            material: Some(self.material(surface)),
            mode: Checked::Valid(gltf_json::mesh::Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        }
    }

    /// An accessor of three numbers each; positions say their extent, as they must.
    fn vectors(&mut self, view: u32, vectors: &[[f32; 3]]) -> Index<Accessor> {
        let bytes = if view == POSITIONS { &mut self.positions } else { &mut self.normals };
        let offset = bytes.len();
        bytes.reserve(12 * vectors.len());
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for vector in vectors {
            for axis in 0..3 {
                bytes.extend_from_slice(&vector[axis].to_le_bytes());
                (low[axis], high[axis]) = (low[axis].min(vector[axis]), high[axis].max(vector[axis]));
            }
        }
        let told = |extent: [f32; 3]| {
            (view == POSITIONS).then(|| Value::from(extent.map(|x| if x.is_finite() { x } else { 0.0 }).to_vec()))
        };
        let (min, max) = (told(low), told(high));
        self.accessor(view, offset, vectors.len(), ComponentType::F32, Type::Vec3, (min, max))
    }

    /// An accessor of indices, as small as they allow.
    fn triangles(&mut self, indices: &[u32], corners: usize) -> Index<Accessor> {
        let offset = self.indices.len();
        self.indices.reserve(4 * indices.len() + 4);
        // The largest value of a type is not an index: it would restart a strip.
        let component = if corners <= usize::from(u16::MAX) {
            indices.iter().for_each(|&i| self.indices.extend_from_slice(&(i as u16).to_le_bytes()));
            ComponentType::U16
        } else {
            indices.iter().for_each(|i| self.indices.extend_from_slice(&i.to_le_bytes()));
            ComponentType::U32
        };
        self.indices.resize(self.indices.len().next_multiple_of(4), 0);
        self.accessor(INDICES, offset, indices.len(), component, Type::Scalar, (None, None))
    }

    fn accessor(
        &mut self,
        view: u32,
        offset: usize,
        count: usize,
        component: ComponentType,
        shape: Type,
        (min, max): (Option<Value>, Option<Value>),
    ) -> Index<Accessor> {
        self.root.push(Accessor {
            buffer_view: Some(Index::new(view)),
            byte_offset: Some(USize64::from(offset)),
            count: USize64::from(count),
            component_type: Checked::Valid(GenericComponentType(component)),
            type_: Checked::Valid(shape),
            min,
            max,
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: None,
        })
    }

    fn material(&mut self, surface: Surface) -> Index<Material> {
        if let Some(&known) = self.materials.get(&surface) {
            return known;
        }
        let (name, [r, g, b], roughness) = look(surface);
        let linear = |byte: u8| linear(f64::from(byte) / 255.0) as f32;
        let pbr_metallic_roughness = PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor([linear(r), linear(g), linear(b), 1.0]),
            metallic_factor: StrengthFactor(0.0),
            roughness_factor: StrengthFactor(roughness),
            ..PbrMetallicRoughness::default()
        };
        let material = Material { name: Some(name.into()), pbr_metallic_roughness, ..Material::default() };
        let index = self.root.push(material);
        self.materials.insert(surface, index);
        index
    }

    fn finish(mut self, out: impl Write) -> Result<(), GlbError> {
        let parts =
            [std::mem::take(&mut self.positions), std::mem::take(&mut self.normals), std::mem::take(&mut self.indices)];
        let bytes = parts.iter().map(Vec::len).sum::<usize>();
        if bytes > 0 {
            self.describe_buffer(&parts, bytes);
        }
        let json = self.root.to_string().map_err(|error| GlbError::Json(error.to_string()))?;
        // Header, two chunk headers, and up to three bytes of padding each.
        if u32::try_from(bytes + json.len() + 12 + 16 + 6).is_err() {
            return Err(GlbError::TooLarge { bytes });
        }
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let bin = (bytes > 0).then(|| Cow::Owned(parts.concat()));
        let glb = Glb { header, json: Cow::Owned(json.into_bytes()), bin };
        glb.to_writer(out).map_err(|error| GlbError::Written(error.to_string()))
    }

    fn describe_buffer(&mut self, parts: &[Vec<u8>; 3], bytes: usize) {
        let buffer =
            Buffer { byte_length: USize64::from(bytes), name: None, uri: None, extensions: None, extras: None };
        let buffer = self.root.push(buffer);
        let mut offset = 0;
        for (view, part) in [POSITIONS, NORMALS, INDICES].into_iter().zip(parts) {
            let is_index = view == INDICES;
            self.root.push(View {
                buffer,
                byte_length: USize64::from(part.len()),
                byte_offset: Some(USize64::from(offset)),
                byte_stride: (!is_index).then_some(Stride(12)),
                target: Some(Checked::Valid(if is_index { Target::ElementArrayBuffer } else { Target::ArrayBuffer })),
                name: None,
                extensions: None,
                extras: None,
            });
            offset += part.len();
        }
    }
}

fn group_name(group: Group) -> &'static str {
    match group {
        Group::Terrain => "terrain",
        Group::Streets => "streets",
        Group::Green => "green",
        Group::Buildings => "buildings",
    }
}

/// The colour (sRGB) of what a surface is made of.
pub fn colour(surface: Surface) -> [u8; 3] {
    look(surface).1
}

/// Name, colour (sRGB) and roughness of a material.
fn look(surface: Surface) -> (&'static str, [u8; 3], f32) {
    match surface {
        Surface::Ground => ("ground", [0xc9, 0xc3, 0xb0], 1.0),
        Surface::Water => ("water", [0x7e, 0xa6, 0xba], 0.25),
        Surface::Park => ("park", [0x94, 0xae, 0x72], 1.0),
        Surface::Plaza => ("plaza", [0xd2, 0xc0, 0xa8], 0.9),
        Surface::Highway => ("street highway", [0x5a, 0x58, 0x58], 0.9),
        Surface::Major => ("street major", [0x66, 0x64, 0x62], 0.9),
        Surface::Minor => ("street minor", [0x72, 0x70, 0x6c], 0.9),
        Surface::Sidewalk => ("sidewalk", [0xb4, 0xb0, 0xa6], 0.95),
        Surface::Deck => ("bridge", [0x9a, 0x96, 0x8e], 0.9),
        Surface::Wall => ("wall", [0xdc, 0xd2, 0xc2], 0.9),
        Surface::Roof => ("roof", [0xa8, 0x8c, 0x7a], 0.95),
    }
}

/// A share of light from an sRGB share.
pub fn linear(share: f64) -> f64 {
    if share <= 0.040_45 { share / 12.92 } else { libm::pow((share + 0.055) / 1.055, 2.4) }
}

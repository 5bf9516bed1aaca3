//! The animated camera of a glTF 2.0 file (.gltf, .glb), as Blender and others write it.
//!
//! A camera is a node that looks along −z, with y upwards, in the frames of its parents; translations and rotations of each of
//! them may be animated. The path is sampled sixty times a second and at every key, by the file's own interpolations
//! (LINEAR, STEP, CUBICSPLINE; Khronos glTF 2.0 specification, appendix C). Lengths have no unit that means anything here.
//! Left out: scales that differ along the axes, the camera's field of view (the scene's own holds), matrices that are animated
//! in other ways, sparse accessors.

use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};

use barnard::data::TextTable;
use barnard::error::{Error, Result};
use barnard::glam::{DMat4, DQuat, DVec3, DVec4};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::animation::{Interpolation, Property, Sampler};
use gltf::json::validation::Checked;
use gltf::{Accessor, Document, Gltf, Node};
use percent_encoding::percent_decode_str;

use super::{Request, table};

/// Samples a second beside the keys.
const RATE: f64 = 60.0;
/// Nodes above a camera, at most: of more, nodes stand in a circle. Cameras that are looked at.
const DEEPEST: usize = 1000;
const MAX_CAMERAS: usize = 1000;
const COLUMNS: [&str; 8] = ["time [s]", "x", "y", "z", "orientation_x", "orientation_y", "orientation_z", "orientation_w"];

pub(super) fn read(request: &Request) -> Result<TextTable> {
    let wrong = |message: String| Error::file(request.path, message);
    // The library takes for granted that a file is longer than its own head.
    let length = request.bytes.get(8..12).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if request.bytes.starts_with(b"glTF") && length < 20 {
        return Err(wrong("is not a glTF file: its header is empty".into()));
    }
    let Gltf { document, mut blob } = Gltf::from_slice(request.bytes).map_err(|e| wrong(format!("is not a glTF file: {e}")))?;
    let targets = targets(&document).map_err(wrong)?;
    let way = animated_camera(&document, &targets).map_err(wrong)?;
    let mut buffers = GltfBuffers { request, blob: blob.take(), read: HashMap::new(), bytes: 0 };
    let channels = CameraChannels::of(&document, &targets, &way, &mut buffers)?;
    let (first, last) = channels.span();
    let count = ((last - first) * RATE).ceil();
    if count.is_nan() || count + channels.keys.len() as f64 > request.most_rows as f64 {
        return Err(wrong(format!("has a path of {} s, which exceeds the limit", last - first)));
    }
    let mut times: Vec<f64> = (0..count as usize).map(|i| first + i as f64 / RATE).chain(channels.keys.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| *a - *b < 1e-9);
    let row = |time: f64| {
        let (_, turn, place) =
            way.iter().fold(DMat4::IDENTITY, |world, node| world * channels.local(node, time)).to_scale_rotation_translation();
        (0, [time - first, place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w].to_vec())
    };
    Ok(table(&COLUMNS, times.into_iter().map(row)))
}

/// The nodes and properties that are animated, channel by channel.
///
/// # Errors
/// If a channel is of a node or property that there is not, which the library takes for granted.
fn targets(document: &Document) -> std::result::Result<Vec<Vec<usize>>, String> {
    let json = document.as_json();
    let node = |channel: &gltf::json::animation::Channel| {
        let node = channel.target.node.value();
        let sound = node < json.nodes.len() && matches!(channel.target.path, Checked::Valid(_));
        if sound { Ok(node) } else { Err(format!("is not a glTF file: a channel of node {node} has an unknown target")) }
    };
    json.animations.iter().map(|animation| animation.channels.iter().map(node).collect()).collect()
}

/// The nodes from the root down to the first camera of which one is animated.
///
/// # Errors
/// If there is none, or nodes stand in a circle.
fn animated_camera<'a>(document: &'a Document, targets: &[Vec<usize>]) -> std::result::Result<Vec<Node<'a>>, String> {
    let nodes = &document.as_json().nodes;
    let children = |(parent, node): (usize, &gltf::json::Node)| {
        node.children.iter().flatten().map(move |child| (child.value(), parent)).collect::<Vec<_>>()
    };
    let parents: HashMap<usize, usize> = nodes.iter().enumerate().flat_map(children).collect();
    let animated: HashSet<usize> = targets.iter().flatten().copied().collect();
    let way = |camera: usize| {
        let mut way = vec![camera];
        while let Some(parent) = way.last().and_then(|node| parents.get(node)) {
            if way.len() == DEEPEST {
                return Err(format!("has more than {DEEPEST} nodes above a camera, or a cycle"));
            }
            way.push(*parent);
        }
        Ok(way)
    };
    let cameras = nodes.iter().enumerate().filter(|(_, node)| node.camera.is_some()).map(|(index, _)| index);
    let ways = cameras.take(MAX_CAMERAS).map(way).collect::<std::result::Result<Vec<_>, String>>()?;
    let to_camera = ways.into_iter().find(|way| way.iter().any(|node| animated.contains(node)));
    let to_camera = to_camera.ok_or("has no animated camera")?;
    Ok(to_camera.into_iter().rev().filter_map(|index| document.nodes().nth(index)).collect())
}

/// Values of one property of a node at moments.
struct Keys {
    times: Vec<f64>,
    /// Three for each moment where the interpolation is cubic: the tangent before, the value, the tangent behind.
    values: Vec<DVec4>,
    interpolation: Interpolation,
}

/// Animated nodes above a camera, and the camera itself.
struct CameraChannels {
    /// Translations and rotations by their nodes.
    places: HashMap<usize, Keys>,
    turns: HashMap<usize, Keys>,
    /// All moments of keys.
    keys: Vec<f64>,
}

impl CameraChannels {
    fn of(document: &Document, targets: &[Vec<usize>], way: &[Node], buffers: &mut GltfBuffers) -> Result<Self> {
        let mut reader = Self { places: HashMap::new(), turns: HashMap::new(), keys: Vec::new() };
        let channels =
            document.animations().zip(targets).flat_map(|(animation, nodes)| animation.channels().zip(nodes).collect::<Vec<_>>());
        let above: HashSet<usize> = way.iter().map(Node::index).collect();
        for (channel, &node) in channels.filter(|(_, node)| above.contains(node)) {
            let (all, dims) = match channel.target().property() {
                Property::Translation => (&mut reader.places, 3),
                Property::Rotation => (&mut reader.turns, 4),
                Property::Scale | Property::MorphTargetWeights => continue,
            };
            // Where several animations move a node, the first one does.
            if let Entry::Vacant(free) = all.entry(node) {
                let keys = free.insert(Keys::of(&channel.sampler(), dims, buffers)?);
                reader.keys.extend(&keys.times);
            }
        }
        if reader.keys.is_empty() {
            return Err(Error::file(buffers.request.path, "animates only the scale of its camera"));
        }
        Ok(reader)
    }

    /// The first and the last moment of keys.
    fn span(&self) -> (f64, f64) {
        self.keys.iter().fold((f64::INFINITY, 0.0), |(first, last): (f64, f64), t| (first.min(*t), last.max(*t)))
    }

    /// Transform of a node relative to its parent at a moment.
    fn local(&self, node: &Node, time: f64) -> DMat4 {
        let (place, turn, scale) = node.transform().decomposed();
        let wide = |v: f32| f64::from(v);
        let place = self.places.get(&node.index()).map_or(DVec3::from(place.map(wide)), |keys| keys.vector(time).truncate());
        let turn = self.turns.get(&node.index()).map_or(DQuat::from_array(turn.map(wide)), |keys| keys.quaternion(time));
        DMat4::from_scale_rotation_translation(DVec3::from(scale.map(wide)), turn, place)
    }
}

impl Keys {
    fn of(sampler: &Sampler, dims: usize, buffers: &mut GltfBuffers) -> Result<Self> {
        let path = buffers.request.path;
        let mut numbers = |accessor: &Accessor, dims: usize| {
            let bytes = accessor.view().map(|view| buffers.of(&view.buffer())).transpose()?;
            floats(accessor, dims, bytes.unwrap_or_default()).map_err(|message| Error::file(path, message))
        };
        let times = numbers(&sampler.input(), 1)?;
        let flat = numbers(&sampler.output(), dims)?;
        let values: Vec<DVec4> = flat.chunks_exact(dims).map(|v| DVec4::new(v[0], v[1], v[2], v.get(3).copied().unwrap_or(0.0))).collect();
        let interpolation = sampler.interpolation();
        let each = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if times.is_empty() || values.len() != each * times.len() {
            return Err(Error::file(path, format!("has {} times with {} values, expected {each} per time", times.len(), values.len())));
        }
        if times[0] < 0.0 || times.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(Error::file(path, "has unsorted times"));
        }
        Ok(Self { times, values, interpolation })
    }

    /// The keys before and behind a moment, and how far it lies between them; the same one outside of all.
    fn between(&self, time: f64) -> (usize, usize, f64) {
        let after = self.times.partition_point(|t| *t <= time).min(self.times.len() - 1);
        let before = if self.times[after] <= time { after } else { after.saturating_sub(1) };
        let gap = self.times[after] - self.times[before];
        (before, after, if gap > 0.0 { ((time - self.times[before]) / gap).clamp(0.0, 1.0) } else { 0.0 })
    }

    /// The value at a moment, its components each for themselves.
    fn vector(&self, time: f64) -> DVec4 {
        let (a, b, u) = self.between(time);
        match self.interpolation {
            Interpolation::Step => self.values[a],
            Interpolation::Linear => self.values[a].lerp(self.values[b], u),
            Interpolation::CubicSpline => {
                let (value, gap) = (|key: usize| self.values[3 * key + 1], self.times[b] - self.times[a]);
                let (out, into) = (self.values[3 * a + 2] * gap, self.values[3 * b] * gap);
                let (u2, u3) = (u * u, u * u * u);
                value(a) * (2.0 * u3 - 3.0 * u2 + 1.0) + out * (u3 - 2.0 * u2 + u) + value(b) * (3.0 * u2 - 2.0 * u3) + into * (u3 - u2)
            }
        }
    }

    /// The rotation at a moment.
    fn quaternion(&self, time: f64) -> DQuat {
        let sound = |v: DVec4| if v.length() > 1e-9 { DQuat::from_vec4(v.normalize()) } else { DQuat::IDENTITY };
        match self.interpolation {
            Interpolation::Linear => {
                let (a, b, u) = self.between(time);
                sound(self.values[a]).slerp(sound(self.values[b]), u)
            }
            Interpolation::Step | Interpolation::CubicSpline => sound(self.vector(time)),
        }
    }
}

/// The buffers of a file, each read when it is asked for.
struct GltfBuffers<'a> {
    request: &'a Request<'a>,
    /// Binary chunk of a .glb.
    blob: Option<Vec<u8>>,
    read: HashMap<usize, Vec<u8>>,
    /// Bytes of all that were read.
    bytes: usize,
}

/// Most bytes of all buffers that a camera's path may take.
const MAX_BYTES: usize = 1 << 30;

impl GltfBuffers<'_> {
    fn of(&mut self, buffer: &gltf::Buffer) -> Result<&[u8]> {
        let wrong = |message: String| Error::file(self.request.path, message);
        let bytes_of_buffer = match self.read.entry(buffer.index()) {
            Entry::Occupied(known) => return Ok(known.into_mut()),
            Entry::Vacant(free) => free,
        };
        let bytes = match buffer.source() {
            gltf::buffer::Source::Bin => self.blob.take().unwrap_or_default(),
            gltf::buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => {
                    let words = data.split_once(";base64,").map_or("", |(_, words)| words);
                    STANDARD.decode(words).map_err(|e| wrong(format!("has an invalid base64 buffer: {e}")))?
                }
                None => (self.request.beside)(&percent_decode_str(uri).decode_utf8_lossy())?,
            },
        };
        self.bytes += bytes.len();
        if self.bytes > MAX_BYTES {
            return Err(wrong(format!("has buffers of more than {} MiB; export only the camera", MAX_BYTES >> 20)));
        }
        Ok(bytes_of_buffer.insert(bytes))
    }
}

/// The numbers of an accessor of vectors with a given number of components each, in the bytes of its buffer.
fn floats(accessor: &Accessor, dims: usize, buffer: &[u8]) -> std::result::Result<Vec<f64>, String> {
    const BYTES: usize = 4;
    let wanted = [Dimensions::Scalar, Dimensions::Vec2, Dimensions::Vec3, Dimensions::Vec4][dims - 1];
    if accessor.data_type() != DataType::F32 || accessor.dimensions() != wanted || accessor.sparse().is_some() {
        return Err(format!("has values of type {:?} {:?}; only dense floats are supported", accessor.data_type(), accessor.dimensions()));
    }
    let outside = || format!("has an accessor, number {}, outside of its buffer", accessor.index());
    let view = accessor.view().ok_or_else(outside)?;
    let end = view.offset().checked_add(view.length()).ok_or_else(outside)?;
    let bytes = buffer.get(view.offset()..end).ok_or_else(outside)?;
    let stride = view.stride().unwrap_or(dims * BYTES);
    if accessor.count() > bytes.len() {
        return Err(outside());
    }
    let value = |i: usize| {
        let start = i.checked_mul(stride).and_then(|at| at.checked_add(accessor.offset()));
        let values = start.and_then(|start| bytes.get(start..start.checked_add(dims * BYTES)?)).ok_or_else(outside)?;
        let number = |word: &[u8]| f64::from(f32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        let numbers: Vec<f64> = values.chunks_exact(BYTES).map(number).collect();
        if numbers.iter().all(|v| v.is_finite()) { Ok(numbers) } else { Err("has values that are not finite".to_owned()) }
    };
    let mut all = Vec::new();
    for i in 0..accessor.count() {
        all.extend(value(i)?);
    }
    Ok(all)
}

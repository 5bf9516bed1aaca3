//! OpenEXR: radiances in a layer of their own, a 32-bit float channel a band, wavelengths and certificate as attributes; and beside
//! them what a display shows, R, G and B in half precision, for programs that look at pictures.
//!
//! Radiances of nebulae, 1e-10 to 1e-6 W m⁻² sr⁻¹, are below what half precision and most viewers tell from black. R, G and B are
//! linear light by the scene's palette, without its stretch: 0 at its black, 1 at its white, brighter above. Layers of light are in
//! the same exposure, or radiances of all bands; their sum is the picture.

use std::io::Cursor;

use exr::meta::attribute::{Chromaticities, EnvironmentMap};
use exr::prelude::*;

use super::{Request, Writer};
use barnard::error::{Error, Result};
use barnard::image::{self, ColourSpace, FAR_AWAY, Layer, LayerChannels, LayerContent, PixelScale, Samples, Tone};
use barnard::memory;
use spectra::colour::{ACESCG_FROM_SRGB, transform};

pub(super) const WRITER: Writer = Writer {
    extension: "exr",
    is_picture: false,
    has_layers: true,
    summary: "OpenEXR with radiances in layer radiance (one float channel per band) and R, G, B for viewers; certificate in attributes",
    encode,
};

pub(super) const READER: super::Reader =
    super::Reader { extensions: &["exr"], summary: "OpenEXR image (to compare)", array: None, members: None, image: Some(decode) };

/// The attribute that lists the bands in the scene's order, a line each.
const ORDER: &str = "bands";

/// Prefix of a band's channel name.
const LAYER: &str = "radiance.";

/// How radiances become the linear colours of a file.
struct LinearColours {
    tone: Tone,
    colours: ColourSpace,
    single: bool,
    channels: LayerChannels,
}

impl LinearColours {
    fn of(picture: &image::Image, options: &image::SaveOptions) -> Self {
        let image::Output { colours, single, channels, .. } = options.output;
        Self { tone: options.display.tone(picture), colours, single, channels }
    }

    /// R, G and B of all pixels, linear: `black` is zero, and what lies as far above it as the picture's white does above its
    /// black is one.
    fn channels(&self, names: [String; 3], samples: &Samples, pixels: usize, black: f64) -> Vec<AnyChannel<FlatSamples>> {
        let scale = 1.0 / (self.tone.white - self.tone.black);
        let bands = samples.len() / pixels;
        let pixel = |i: usize| {
            let rgb = self.tone.palette.rgb((0..bands).map(|band| samples.at(band * pixels + i))).map(|v| (v - black) * scale);
            match self.colours {
                ColourSpace::Rec709 => rgb,
                ColourSpace::AcesCg => transform(&ACESCG_FROM_SRGB, rgb),
            }
        };
        let all: Vec<[f64; 3]> = (0..pixels).map(pixel).collect();
        let channel = |(colour, name): (usize, String)| self.channel(&name, all.iter().map(|rgb| rgb[colour]));
        names.into_iter().enumerate().map(channel).collect()
    }

    /// A channel of what is shown, in half or single precision.
    fn channel(&self, name: &str, values: impl Iterator<Item = f64>) -> AnyChannel<FlatSamples> {
        let largest = f64::from(f16::MAX);
        let samples = match self.single {
            true => FlatSamples::F32(values.map(|v| v as f32).collect()),
            false => FlatSamples::F16(values.map(|v| f16::from_f64(v.clamp(-largest, largest))).collect()),
        };
        AnyChannel::new(name, samples)
    }

    /// The channels of a layer.
    fn layer(&self, layer: &Layer, picture: &image::Image, bands: &[String]) -> Vec<AnyChannel<FlatSamples>> {
        let pixels = picture.width * picture.height;
        let single = |name: &str, number: usize| {
            let values = layer.channel(number, pixels).map(|v| v as f32).collect();
            AnyChannel::new(format!("{}.{name}", layer.name).as_str(), FlatSamples::F32(values))
        };
        match (layer.content, self.channels) {
            (LayerContent::Light, LayerChannels::Rgb) => {
                self.channels(["R", "G", "B"].map(|colour| format!("{}.{colour}", layer.name)), &layer.samples, pixels, 0.0)
            }
            (LayerContent::Light, LayerChannels::Bands) => bands.iter().enumerate().map(|(band, name)| single(name, band)).collect(),
            (LayerContent::Mask, _) => picture.radiances().enumerate().map(|(number, band)| single(&bands[band], number)).collect(),
            (LayerContent::Depth, _) => vec![single("Z", 0)],
            // The opacity is that of the picture, by which programs lay it over others.
            (LayerContent::OpticalDepth, _) => vec![single("V", 0), self.channel("A", layer.channel(1, pixels))],
        }
    }
}

/// Statements of the header: key and text.
fn notes(picture: &image::Image, exposure: &LinearColours, names: &[String]) -> Vec<(String, String)> {
    let mut notes = Vec::new();
    let mut note = |key: String, value: &str| notes.push((key, value.to_owned()));
    let tone = &exposure.tone;
    note("unit".into(), "W m-2 sr-1, of the channels in layer radiance");
    note(
        "RGB".into(),
        &format!(
            "linear light by the palette, {}, 0 at {:E} and 1 at {:E} W m-2 sr-1 (of balanced bands, if balanced)",
            exposure.colours.name(),
            tone.black,
            tone.white
        ),
    );
    if !picture.layers.is_empty() {
        let names: Vec<&str> = picture.layers.iter().map(|layer| layer.name.as_str()).collect();
        note("layers".into(), &names.join("\n"));
        let unit = match exposure.channels {
            LayerChannels::Rgb => format!("in the exposure of RGB without its black: {:E} W m-2 sr-1 are 1", tone.white - tone.black),
            LayerChannels::Bands => "W m-2 sr-1".to_owned(),
        };
        note("layers.unit".into(), &format!("light layers {unit}; depth.Z pc, {FAR_AWAY:E} without light; tau.V optical depth at V"));
    }
    // Channels are stored by name; this is the scene's order.
    note(ORDER.into(), &names.join("\n"));
    for keyword in picture.cards() {
        note(keyword.name.into(), &format!("{} / {}", keyword.value, keyword.comment));
    }
    if let Some((size, unit)) = picture.pixel.map(PixelScale::in_unit) {
        let what = if unit == "deg" { "angle of the central pixel" } else { "width of a pixel" };
        note("PIXSCALE".into(), &format!("{size:E} / [{unit}] {what}"));
    }
    for (key, value) in picture.statements() {
        note(key, &value);
    }
    for (number, (name, band)) in names.iter().zip(&picture.bands).enumerate() {
        if let Some(pivot) = band.pivot_um {
            note(format!("{name}.pivot"), &format!("{:.3} nm", pivot * 1e3));
        }
        if let Some(counting) = band.counting {
            note(format!("{name}.counting"), counting);
        }
        for keyword in picture.band_cards(number) {
            note(format!("{name}.{}", keyword.name), &format!("{} / {}", keyword.value, keyword.comment));
        }
        for (i, line) in picture.band_words(number).iter().enumerate() {
            note(format!("{name}.certificate.{i}"), line);
        }
    }
    notes
}

fn encode(picture: &image::Image, options: &image::SaveOptions) -> Result<Vec<u8>> {
    let size = picture.width * picture.height;
    let names = super::distinct_names(picture);
    let radiance = |band: usize| {
        let values: Vec<f32> = (band * size..(band + 1) * size).map(|i| picture.samples.at(i) as f32).collect();
        AnyChannel::new(format!("{LAYER}{}", names[band]).as_str(), FlatSamples::F32(values))
    };
    let exposure = LinearColours::of(picture, options);
    let tone = &exposure.tone;
    let shown = exposure.channels(["R", "G", "B"].map(str::to_owned), &picture.samples, size, tone.black);
    let layers = picture.layers.iter().flat_map(|layer| exposure.layer(layer, picture, &names));
    let mut attributes = LayerAttributes::named("Barnard");
    attributes.software_name = Some(Text::from(format!("Barnard {}", env!("CARGO_PKG_VERSION")).as_str()));
    attributes.environment_map = environment_map(picture);
    let space = match exposure.colours {
        ColourSpace::Rec709 => "lin_rec709_scene",
        ColourSpace::AcesCg => "lin_ap1_scene",
    };
    attributes.other.insert(Text::from("colorInteropID"), AttributeValue::Text(Text::from(space)));
    for (key, value) in notes(picture, &exposure, &names) {
        attributes.other.insert(Text::from(super::ascii(&key).as_str()), AttributeValue::Text(Text::from(lines(&value).as_str())));
    }
    let channels = AnyChannels::sort((0..picture.bands.len()).map(radiance).chain(shown).chain(layers).collect());
    let encoding = Encoding { compression: compression(options.output.compression), ..Encoding::SMALL_LOSSLESS };
    if let Some(part) = picture.part {
        attributes.layer_position = Vec2(part.column as i32, part.row as i32);
    }
    if let Some(view) = picture.view {
        let rows = |matrix: [[f64; 4]; 4]| matrix.as_flattened().iter().map(|v| *v as f32).collect::<Vec<f32>>().try_into().ok();
        attributes.world_to_camera = rows(view.world_to_camera);
        attributes.world_to_normalized_device = rows(view.world_to_screen);
    }
    if let Some(moment) = picture.moment {
        attributes.frames_per_second = Some(rate(moment.per_second));
        for (name, value) in [
            ("imageCounter", AttributeValue::I32(moment.frame.clamp(i32::MIN.into(), i32::MAX.into()) as i32)),
            ("frameTime", AttributeValue::F64(moment.time_s)),
        ] {
            attributes.other.insert(Text::from(name), value);
        }
    }
    let layer = exr::image::Layer::new((picture.width, picture.height), attributes, encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    let mut file = Image::from_layer(layer);
    if let Some(part) = picture.part {
        file.attributes.display_window = IntegerBounds::from_dimensions(part.whole);
    }
    file.attributes.chromaticities = Some(match exposure.colours {
        ColourSpace::Rec709 => REC_709,
        ColourSpace::AcesCg => AP1,
    });
    file.write().to_buffered(&mut bytes).map_err(|e| Error::Encoding { format: "exr", reason: e.to_string() })?;
    Ok(in_order(bytes.into_inner()))
}

/// Frames a second as a fraction: those of NTSC television by their name.
fn rate(per_second: f64) -> (i32, u32) {
    let ntsc = (per_second * 1001.0 / 1000.0).round();
    match (ntsc * 1000.0 / 1001.0 - per_second).abs() < 1e-3 && per_second.fract() != 0.0 {
        true => (ntsc as i32 * 1000, 1001),
        false if per_second.fract() == 0.0 && per_second < f64::from(i32::MAX) => (per_second as i32, 1),
        false => ((per_second * 1000.0).round().min(f64::from(i32::MAX)) as i32, 1000),
    }
}

/// The bytes of a file with the attributes of its header in the order of their names, since the encoder's is another each time: equal pictures
/// are equal bytes.
fn in_order(mut bytes: Vec<u8>) -> Vec<u8> {
    // Magic number and version.
    const START: usize = 8;
    let text = |from: usize| bytes[from..].iter().position(|byte| *byte == 0).map(|length| from + length + 1);
    let (mut at, mut attributes) = (START, Vec::new());
    while bytes.get(at).is_some_and(|byte| *byte != 0) {
        let size_at = text(at).and_then(text).filter(|size_at| size_at + 4 <= bytes.len());
        let Some(size_at) = size_at else { return bytes };
        let size = u32::from_le_bytes(std::array::from_fn(|i| bytes[size_at + i])) as usize;
        let end = size_at + 4 + size;
        let Some(attribute) = bytes.get(at..end) else { return bytes };
        attributes.push(attribute.to_vec());
        at = end;
    }
    attributes.sort();
    let header = attributes.concat();
    bytes[START..START + header.len()].copy_from_slice(&header);
    bytes
}

/// The primaries and the white of Rec. 709 and sRGB (ITU-R BT.709-6, 2015).
const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.30, 0.60), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.3290) };

/// The primaries AP1 and the white of ACES (S-2014-004).
const AP1: Chromaticities =
    Chromaticities { red: Vec2(0.713, 0.293), green: Vec2(0.165, 0.830), blue: Vec2(0.128, 0.044), white: Vec2(0.32168, 0.33767) };

fn compression(chosen: image::Compression) -> Compression {
    match chosen {
        image::Compression::None => Compression::Uncompressed,
        image::Compression::Rle => Compression::RLE,
        image::Compression::Zips => Compression::ZIP1,
        image::Compression::Zip => Compression::ZIP16,
        image::Compression::Piz => Compression::PIZ,
        image::Compression::Pxr24 => Compression::PXR24,
    }
}

/// Environment-map type of a full panorama.
fn environment_map(picture: &image::Image) -> Option<EnvironmentMap> {
    let (width, height) = (picture.width, picture.height);
    match picture.pixel? {
        PixelScale::PlateCarree(_) if picture.axis == (0.0, 0.0) && width == 2 * height => Some(EnvironmentMap::LatitudeLongitude),
        PixelScale::OnCube(_) if picture.views == (1, 6) => Some(EnvironmentMap::Cube),
        _ => None,
    }
}

/// Makes text Latin, as attributes of EXR are; lines stay lines.
fn lines(text: &str) -> String {
    text.lines().map(super::ascii).collect::<Vec<_>>().join("\n")
}

fn decode(request: &mut Request) -> Result<image::Image> {
    let (path, limit) = (request.path, request.memory_limit);
    let broken = |e: exr::error::Error| Error::file(path, format!("is not a readable OpenEXR image: {e}"));
    // The header's size is checked before pixels are decoded.
    let meta = MetaData::read_from_buffered(request.rewound()?, false).map_err(broken)?;
    let pixels: u64 = meta.headers.iter().map(|h| (h.layer_size.area() as u64).saturating_mul(h.channels.list.len() as u64)).sum();
    memory::check(&format!("the image of {}", path.display()), pixels.saturating_mul(4), limit)?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let file = reader.non_parallel().from_buffered(request.rewound()?).map_err(broken)?;
    let layer = file.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let order = match layer.attributes.other.get(&Text::from(ORDER)) {
        Some(AttributeValue::Text(text)) => text.to_string(),
        _ => String::new(),
    };
    let position = |name: &str| order.lines().position(|n| n == name).unwrap_or(usize::MAX);
    let named = |c: &AnyChannel<FlatSamples>| c.name.to_string();
    let label = |c: &AnyChannel<FlatSamples>| named(c).strip_prefix(LAYER).map_or_else(|| named(c), str::to_owned);
    // Where there are radiances, what a display shows is none.
    let has_layer = layer.channel_data.list.iter().any(|c| named(c).starts_with(LAYER));
    let mut channels: Vec<_> = layer.channel_data.list.iter().filter(|c| !has_layer || named(c).starts_with(LAYER)).collect();
    channels.sort_by_key(|c| position(&label(c)));
    let names = channels.iter().map(|c| label(c)).collect();
    let samples: Vec<f32> = channels.iter().flat_map(|c| c.sample_data.values_as_f32()).collect();
    if !order.is_empty() {
        // A part of one of our pictures stays a part, as in every other format.
        return Ok(image::Image::bare(width, height, names, image::Samples::Single(samples)));
    }
    let window = DataWindow { shown: file.attributes.display_window, first: layer.attributes.layer_position, size: (width, height) };
    let (size, samples) = window.fill(path, limit, samples)?;
    Ok(image::Image::bare(size.0, size.1, names, image::Samples::Single(samples)))
}

/// The pixels that a file stores, its data window, within those that it shows, its display window.
struct DataWindow {
    shown: IntegerBounds,
    first: Vec2<i32>,
    size: (usize, usize),
}

impl DataWindow {
    /// The channels of stored pixels as those of the display window: zero where nothing is stored, without what lies outside.
    fn fill(&self, path: &std::path::Path, limit: u64, samples: Vec<f32>) -> Result<((usize, usize), Vec<f32>)> {
        let (width, height) = (self.shown.size.width(), self.shown.size.height());
        let offset = self.first - self.shown.position;
        if (offset, self.size) == (Vec2(0, 0), (width, height)) {
            return Ok((self.size, samples));
        }
        let stored = self.size.0 * self.size.1;
        let pixels = (width as u64).saturating_mul(height as u64).saturating_mul((samples.len() / stored.max(1)) as u64);
        memory::check(&format!("the display window of {}", path.display()), pixels.saturating_mul(4), limit)?;
        let mut filled = Vec::with_capacity(pixels as usize);
        for channel in samples.chunks_exact(stored.max(1)) {
            for y in 0..height as i64 {
                let row = usize::try_from(y - i64::from(offset.1)).ok().filter(|row| *row < self.size.1);
                let at = |x: i64| {
                    let column = usize::try_from(x - i64::from(offset.0)).ok().filter(|column| *column < self.size.0)?;
                    Some(channel[row? * self.size.0 + column])
                };
                filled.extend((0..width as i64).map(|x| at(x).unwrap_or(0.0)));
            }
        }
        Ok(((width, height), filled))
    }
}

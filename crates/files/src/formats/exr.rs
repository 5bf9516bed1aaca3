//! OpenEXR: one 32-bit float channel a band, wavelengths and certificate as attributes.

use std::io::Cursor;

use exr::meta::attribute::EnvironmentMap;
use exr::prelude::*;

use super::{Request, Writer};
use barnard::error::{Error, Result};
use barnard::image::{self, PixelScale};
use barnard::memory;

pub(super) const WRITER: Writer =
    Writer { extension: "exr", summary: "OpenEXR, one float channel a band, certificate as attributes", encode };

pub(super) const READER: super::Reader =
    super::Reader { extensions: &["exr"], summary: "OpenEXR image (to compare)", array: None, members: None, image: Some(decode) };

/// The attribute that lists the bands in the scene's order, a line each.
const ORDER: &str = "bands";

fn encode(picture: &image::Image) -> Result<Vec<u8>> {
    let size = picture.width * picture.height;
    let names = super::distinct_names(picture);
    let channel = |band: usize| {
        let values: Vec<f32> = (band * size..(band + 1) * size).map(|i| picture.samples.at(i) as f32).collect();
        AnyChannel::new(names[band].as_str(), FlatSamples::F32(values))
    };
    let mut attributes = LayerAttributes::named("Barnard");
    attributes.software_name = Some(Text::from(format!("Barnard {}", env!("CARGO_PKG_VERSION")).as_str()));
    attributes.environment_map = environment_map(picture);
    let mut note = |key: String, value: &str| {
        attributes.other.insert(Text::from(super::ascii(&key).as_str()), AttributeValue::Text(Text::from(lines(value).as_str())));
    };
    note("unit".into(), "W m-2 sr-1");
    // Channels are stored by name; this is the scene's order.
    note(ORDER.into(), &names.join("\n"));
    note("DATE".into(), &super::now());
    for keyword in &picture.keywords {
        note(keyword.name.into(), &format!("{} / {}", keyword.value, keyword.comment));
    }
    if let Some((size, unit)) = picture.pixel.map(PixelScale::in_unit) {
        let what = if unit == "deg" { "angle of a pixel in the middle" } else { "width of a pixel" };
        note("PIXSCALE".into(), &format!("{size:E} / [{unit}] {what}"));
    }
    for (key, value) in &picture.notes {
        note(key.clone(), value);
    }
    for (name, band) in names.iter().zip(&picture.bands) {
        if let Some(pivot) = band.pivot_um {
            note(format!("{name}.pivot"), &format!("{:.3} nm", pivot * 1e3));
        }
        if let Some(counting) = band.counting {
            note(format!("{name}.counting"), counting);
        }
        for keyword in &band.keywords {
            note(format!("{name}.{}", keyword.name), &format!("{} / {}", keyword.value, keyword.comment));
        }
        for (i, line) in band.certificate.iter().enumerate() {
            note(format!("{name}.certificate.{i}"), line);
        }
    }
    let channels = AnyChannels::sort((0..picture.bands.len()).map(channel).collect());
    let layer = Layer::new((picture.width, picture.height), attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|e| Error::Encoding { format: "exr", reason: e.to_string() })?;
    Ok(bytes.into_inner())
}

/// What a picture of all around is as an environment map, where it is whole.
fn environment_map(picture: &image::Image) -> Option<EnvironmentMap> {
    let (width, height) = (picture.width, picture.height);
    match picture.pixel? {
        PixelScale::PlateCarree(_) if picture.axis == (0.0, 0.0) && width == 2 * height => Some(EnvironmentMap::LatitudeLongitude),
        PixelScale::OnCube(_) if picture.axis == (0.0, 0.0) && height == 6 * width => Some(EnvironmentMap::Cube),
        _ => None,
    }
}

/// Makes text Latin, as attributes of EXR are; lines stay lines.
fn lines(text: &str) -> String {
    text.lines().map(super::ascii).collect::<Vec<_>>().join("\n")
}

fn decode(request: &mut Request) -> Result<image::Image> {
    let (path, limit) = (request.path, request.memory_limit);
    let broken = |e: exr::error::Error| Error::file(path, format!("is no readable OpenEXR image: {e}"));
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
    let mut channels: Vec<_> = layer.channel_data.list.iter().collect();
    channels.sort_by_key(|c| position(&c.name.to_string()));
    let names = channels.iter().map(|c| c.name.to_string()).collect();
    let samples: Vec<f32> = channels.iter().flat_map(|c| c.sample_data.values_as_f32()).collect();
    Ok(image::Image::bare(width, height, names, image::Samples::Single(samples)))
}

//! Every row of the formats, written and read again.

use barnard::data::ArrayHeader;
use barnard::image::{ColourSpace, Image, Layer, LayerChannels, LayerContent, Output, PixelScale, Samples, SaveOptions};
use barnard::observation::{InUnit, Observation, RadianceUnit};
use barnard_files::SaveImage;
use barnard_files::formats::{READERS, UNIT_NOTE, WRITERS, read_array, read_image};
use spectra::colour::Palette;

/// A picture of two bands whose values tell their places.
fn image() -> Image {
    let values = (0..2 * 3 * 4).map(|i| 1e-7 * (1.0 + i as f32)).collect();
    Image::bare(4, 3, vec!["B".into(), "V".into()], Samples::Single(values))
}

/// Every format that is written can be written; where it is read as well, radiances come back to what it keeps of them.
#[test]
fn what_is_written_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let (written, options) = (image(), SaveOptions::grey(2));
    let mut read = 0;
    for writer in WRITERS {
        let path = folder.path().join("image").with_extension(writer.extension);
        written.save(&path, &options).unwrap();
        assert!(std::fs::metadata(&path).unwrap().len() > 40, ".{}", writer.extension);
        let readable = READERS.iter().any(|r| r.image.is_some() && r.extensions.contains(&writer.extension));
        match read_image(&path, 1 << 20) {
            Ok(back) => {
                let worst = (0..2).map(|band| back.relative_rmse(band, &written, band)).fold(0.0, f64::max);
                let swapped = back.relative_rmse(0, &written, 1);
                assert!(readable && worst < 1e-3 && swapped > 0.1, ".{}: {worst:e} {swapped:e}", writer.extension);
                read += 1;
            }
            Err(error) => assert!(!readable, ".{}: {error}", writer.extension),
        }
    }
    assert_eq!(read, WRITERS.iter().filter(|w| READERS.iter().any(|r| r.image.is_some() && r.extensions.contains(&w.extension))).count());
}

/// Every reader refuses what is no file of its format, by its name, and never panics: nothing, noise, and heads of files
/// that end early.
#[test]
fn readers_refuse_what_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    for reader in READERS {
        for extension in reader.extensions {
            let path = folder.path().join("broken").with_extension(extension);
            let mut whole = Vec::new();
            if WRITERS.iter().any(|w| w.extension == *extension) {
                image().save(&path, &SaveOptions::grey(2)).unwrap();
                whole = std::fs::read(&path).unwrap();
            }
            let noise: Vec<u8> = (0..4000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
            for bytes in [&[][..], &noise, &whole[..whole.len() / 3]] {
                std::fs::write(&path, bytes).unwrap();
                let whole = &mut |layout: &ArrayHeader| Ok(layout.whole());
                let array = read_array(std::io::Cursor::new(bytes.to_vec()), &path, None, whole, 1 << 20).unwrap_err().to_string();
                let image = read_image(&path, 1 << 20).unwrap_err().to_string();
                assert!(array.contains("broken") && image.contains("broken"), ".{extension}: {array}; {image}");
            }
        }
    }
}

/// Pictures of sixteen bits hold what eight cannot: colours as a display would show them, to 1 in 65535 in .tif and .png; those of
/// eight bits to one level, and JPEG to a few.
#[test]
fn pictures_have_the_bits_that_are_asked_for() {
    let (width, height) = (40, 30);
    let values = (0..width * height).map(|i| (i as f32 / (width * height) as f32).powi(2)).collect();
    let written = Image::bare(width, height, vec!["V".into()], Samples::Single(values));
    let mut options = SaveOptions::grey(1);
    options.display.white = barnard::image::Level::Radiance(1.0);
    let truth: Vec<f64> = options.display.picture(&written).into_iter().flatten().collect();
    let folder = tempfile::tempdir().unwrap();
    // Largest differences of a colour.
    let mut off = |name: &str, bits: u8| {
        options.display.bits = bits;
        let path = folder.path().join(name);
        written.save(&path, &options).unwrap();
        let (colours, levels): (Vec<f64>, usize) = if name.ends_with(".png") {
            let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
            let mut reader = decoder.read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut bytes).unwrap();
            match info.bit_depth {
                png::BitDepth::Sixteen => (bytes.chunks(2).map(|b| f64::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0).collect(), 65536),
                _ => (bytes.iter().map(|b| f64::from(*b) / 255.0).collect(), 256),
            }
        } else if name.ends_with(".jpg") {
            let bytes = std::io::Cursor::new(std::fs::read(&path).unwrap());
            let pixels = zune_jpeg::JpegDecoder::new(bytes).decode().unwrap();
            (pixels.iter().map(|v| f64::from(*v) / 255.0).collect(), 256)
        } else {
            let mut decoder = tiff::decoder::Decoder::new(std::fs::File::open(&path).unwrap()).unwrap();
            assert_eq!(decoder.colortype().unwrap(), tiff::ColorType::RGB(16));
            let tiff::decoder::DecodingResult::U16(pixels) = decoder.read_image().unwrap() else { panic!("other samples") };
            (pixels.iter().map(|v| f64::from(*v) / 65535.0).collect(), 65536)
        };
        assert_eq!(colours.len(), truth.len(), "{name}");
        (colours.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max), levels)
    };
    for (name, bits, most, levels) in
        [("a.png", 8, 1.0 / 255.0, 256), ("b.png", 16, 0.6 / 65535.0, 65536), ("c.tif", 8, 0.6 / 65535.0, 65536), ("d.jpg", 8, 0.03, 256)]
    {
        let (off, stored) = off(name, bits);
        assert!(off <= most && stored == levels, "{name}: {off:e}");
    }
    assert!(off("e.png", 8).0 > 10.0 / 65535.0);
}

/// An EXR shows what a display does to programs that know no bands: R, G and B in half precision, 1 at the white; radiances stand
/// in a layer of their own, whole.
#[test]
fn exr_files_have_layers() {
    use exr::prelude::*;
    let (written, mut options) = (image(), SaveOptions::grey(2));
    options.display.white = barnard::image::Level::Radiance(1.5e-6);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    written.save(&path, &options).unwrap();
    let file = read_first_flat_layer_from_file(&path).unwrap();
    let list = &file.layer_data.channel_data.list;
    let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "radiance.B", "radiance.V"]);
    let channel = |name: &str| &list.iter().find(|channel| channel.name.to_string() == name).unwrap().sample_data;
    let tone = options.display.tone(&written);
    for i in 0..12 {
        let rgb = tone.palette.rgb((0..2).map(|band| written.samples.at(12 * band + i)));
        for (name, value) in ["R", "G", "B"].into_iter().zip(rgb) {
            let stored = f64::from(channel(name).value_by_flat_index(i).to_f32());
            assert!((stored - value / 1.5e-6).abs() < 1e-3 * stored && matches!(channel(name), FlatSamples::F16(_)), "{name} {stored}");
        }
        assert_eq!(channel("radiance.V").value_by_flat_index(i).to_f32(), written.samples.at(12 + i) as f32);
    }
    assert!(file.attributes.chromaticities.is_some());
}

/// An EXR says which frame it is, where its camera sees what, and where a crop lies in the whole; equal pictures are equal bytes.
#[test]
fn exr_files_say_frame_view_and_window() {
    use barnard::image::{ImagePart, Moment, View};
    use exr::prelude::*;
    let rows = |first: f64| std::array::from_fn(|i| std::array::from_fn(|j| first + (4 * i + j) as f64));
    let written = barnard::image::Image {
        moment: Some(Moment { frame: 42, time_s: 1.75, per_second: 24000.0 / 1001.0 }),
        view: Some(View { world_to_camera: rows(0.0), world_to_screen: rows(100.0) }),
        part: Some(ImagePart { column: 7, row: 5, whole: (40, 30) }),
        ..image()
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let bytes: Vec<Vec<u8>> = (0..4)
        .map(|_| {
            written.save(&path, &SaveOptions::grey(2)).unwrap();
            std::fs::read(&path).unwrap()
        })
        .collect();
    assert!(bytes.iter().all(|byte| *byte == bytes[0]));
    let file = read_first_flat_layer_from_file(&path).unwrap();
    let (attributes, window) = (&file.layer_data.attributes, file.attributes.display_window);
    assert_eq!(attributes.frames_per_second, Some((24000, 1001)));
    assert_eq!(attributes.other.get(&Text::from("imageCounter")), Some(&AttributeValue::I32(42)));
    assert_eq!(attributes.other.get(&Text::from("frameTime")), Some(&AttributeValue::F64(1.75)));
    assert_eq!(attributes.other.get(&Text::from("colorInteropID")), Some(&AttributeValue::Text(Text::from("lin_rec709_scene"))));
    let (camera, screen) = (attributes.world_to_camera.unwrap(), attributes.world_to_normalized_device.unwrap());
    assert!((0..16).all(|i| camera[i] == i as f32 && screen[i] == 100.0 + i as f32));
    assert_eq!((attributes.layer_position, window), (Vec2(7, 5), IntegerBounds::from_dimensions((40, 30))));
}

/// A picture of two gases, how far their light comes from and what lies before it; one pixel is dark.
fn layered() -> Image {
    let picture = image();
    let share = |part: f32| -> Vec<f32> { (0..24).map(|i| part * picture.samples.at(i) as f32).collect() };
    let light = |name: &str, part| Layer { name: name.into(), content: LayerContent::Light, samples: Samples::Single(share(part)) };
    let mut moments = [vec![6.0; 12], vec![2.0; 12]].concat();
    (moments[5], moments[17]) = (0.0, 0.0);
    let depth = Layer { name: "depth".into(), content: LayerContent::Depth, samples: Samples::Single(moments) };
    let taken = [vec![0.5; 12], vec![0.393; 12]].concat();
    let tau = Layer { name: "tau".into(), content: LayerContent::OpticalDepth, samples: Samples::Single(taken) };
    Image { layers: vec![light("emission.Ha", 0.25), light("scattered", 0.75), depth, tau], ..picture }
}

/// Layers are channels whose names compositing programs part at dots; those of light add up to R, G and B in their exposure, in
/// the primaries that the file names, and every way to pack a file keeps them.
#[test]
fn layers_are_channels_of_exr_files() {
    use exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.exr");
    let (written, mut options) = (layered(), SaveOptions::grey(2));
    options.display.white = barnard::image::Level::Radiance(1.5e-6);
    options.display.palette = Palette { columns: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
    for (_, compression) in <barnard::image::Compression as barnard::properties::Choices>::ROWS {
        for (single, colours) in [(false, ColourSpace::Rec709), (true, ColourSpace::AcesCg)] {
            options.output = Output { single, colours, compression: *compression, ..Output::default() };
            written.save(&path, &options).unwrap();
            let file = read_first_flat_layer_from_file(&path).unwrap();
            let list = &file.layer_data.channel_data.list;
            let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
            let light = ["emission.Ha.B", "emission.Ha.G", "emission.Ha.R", "radiance.B", "radiance.V"];
            let rest = ["scattered.B", "scattered.G", "scattered.R", "tau.V"];
            assert_eq!(names, [&["A", "B", "G", "R", "depth.Z"][..], &light, &rest].concat());
            let channel = |name: &str| &list.iter().find(|channel| channel.name.to_string() == name).unwrap().sample_data;
            let at = |name: &str, i: usize| f64::from(channel(name).value_by_flat_index(i).to_f32());
            // 24 bits of a float are 16 of its fraction.
            let tolerance = if single && *compression != barnard::image::Compression::Pxr24 { 1e-6 } else { 2e-3 };
            for i in 0..12 {
                for colour in ["R", "G", "B"] {
                    let sum = at(&format!("emission.Ha.{colour}"), i) + at(&format!("scattered.{colour}"), i);
                    assert!((sum - at(colour, i)).abs() <= tolerance * at(colour, i).abs().max(1e-3), "{colour} {sum} {}", at(colour, i));
                }
                let wanted = match colours {
                    ColourSpace::Rec709 => written.samples.at(i) / 1.5e-6,
                    // The first row of the matrix from Rec. 709 to AP1 (colour-science.org: 0.613097, 0.339523).
                    ColourSpace::AcesCg => (0.613_097 * written.samples.at(i) + 0.339_523 * written.samples.at(12 + i)) / 1.5e-6,
                };
                assert!((at("R", i) / wanted - 1.0).abs() < 2e-3, "{} {wanted}", at("R", i));
                let depth = if i == 5 { 1e10 } else { 3.0 };
                assert!((at("depth.Z", i) / depth - 1.0).abs() < 1e-4 && (at("tau.V", i) - 0.5).abs() < 1e-4);
                assert!((at("A", i) - 0.393).abs() < 1e-3);
            }
            assert_eq!(matches!(channel("scattered.G"), FlatSamples::F32(_)), single);
            assert!(matches!(channel("depth.Z"), FlatSamples::F32(_)));
            let red = file.attributes.chromaticities.unwrap().red;
            assert_eq!(red.0, if colours == ColourSpace::AcesCg { 0.713 } else { 0.64 });
        }
    }
    // Bands in place of colours, and none of it is taken for a band when the file is read again.
    options.output = Output { channels: LayerChannels::Bands, ..Output::default() };
    written.save(&path, &options).unwrap();
    let file = read_first_flat_layer_from_file(&path).unwrap();
    let channel = file.layer_data.channel_data.list.iter().find(|channel| channel.name.to_string() == "scattered.V").unwrap();
    let (value, whole) = (channel.sample_data.value_by_flat_index(7).to_f32(), written.samples.at(19) as f32);
    assert!((value / (0.75 * whole) - 1.0).abs() < 1e-6 && matches!(channel.sample_data, FlatSamples::F32(_)));
    let back = read_image(&path, 1 << 20).unwrap();
    assert_eq!(back.bands.iter().map(|band| band.name.as_str()).collect::<Vec<_>>(), ["B", "V"]);
}

/// A FITS file has a layer's channels as HDUs behind the bands; who reads the image reads the bands.
#[test]
fn layers_are_hdus_of_fits_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("layers.fits");
    layered().save(&path, &SaveOptions::grey(2)).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let cards: Vec<&str> = bytes.chunks(80).filter_map(|card| std::str::from_utf8(card).ok()).collect();
    let names: Vec<&str> = cards.iter().filter(|c| c.starts_with("EXTNAME")).map(|c| c.split('\'').nth(1).unwrap().trim()).collect();
    let light = ["emission.Ha.B", "emission.Ha.V", "scattered.B", "scattered.V"];
    assert_eq!(names, [&["B", "V"][..], &light, &["depth", "tau", "opacity"]].concat());
    let back = read_image(&path, 1 << 20).unwrap();
    assert_eq!((back.bands.len(), back.relative_rmse(1, &image(), 1)), (2, 0.0));
}

/// A FITS file holds the unit that was asked for, standard errors beside their radiances in it; a file of another unit says so.
#[test]
fn fits_has_the_unit_of_the_observation() {
    let folder = tempfile::tempdir().unwrap();
    let names = vec!["V".into(), "V_error".into()];
    let bare = Image::bare(1, 2, names, Samples::Double(vec![1e-6, 2e-6, 1e-8, 4e-8]));
    let path = folder.path().join("image.fits");
    let saved = |unit: RadianceUnit, in_unit: InUnit| {
        let mut image = Image {
            observation: Some(Observation { unit, ..Observation::default() }),
            pixel: Some(PixelScale::Angle(0.5)),
            ..bare.clone()
        };
        image.bands[0].in_unit = Some(in_unit);
        image.save(&path, &SaveOptions::grey(2)).unwrap();
        let back = read_image(&path, 1 << 20).unwrap();
        let note = back.notes.iter().find(|(key, _)| key == UNIT_NOTE).unwrap().1.clone();
        (note, [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(band, row)| back.at(band, row, 0)))
    };
    assert_eq!(saved(RadianceUnit::MegaJansky, InUnit::Times(4.0)), ("MJy/sr".into(), [4e-6, 8e-6, 4e-8, 1.6e-7]));
    let (unit, values) = saved(RadianceUnit::Ab, InUnit::Magnitudes { zero: 1e-4 });
    let wanted = [5.0, 5.0 - 2.5 * 2f64.log10(), 0.010_857_362, 0.021_714_724];
    assert!(unit == "mag arcsec-2 AB" && values.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-8), "{unit} {values:?}");
    let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
    assert!(["CTYPE1  = 'RA---TAN'", "CTYPE2  = 'DEC--TAN'", "RADESYS = 'ICRS", "PC1_1"].iter().all(|card| text.contains(card)));
}

//! Every row of the formats, written and read again.

use barnard::data::Layout;
use barnard::image::{Image, Samples};
use barnard_files::SaveImage;
use barnard_files::formats::{READERS, WRITERS, read_array, read_image};

/// A picture of two bands whose values tell their places.
fn image() -> Image {
    let values = (0..2 * 3 * 4).map(|i| 1e-7 * (1.0 + i as f32)).collect();
    Image::bare(4, 3, vec!["B".into(), "V".into()], Samples::Single(values))
}

/// Every format that is written can be written; where it is read as well, radiances come back to what it keeps of them.
#[test]
fn what_is_written_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let written = image();
    let mut read = 0;
    for writer in WRITERS {
        let path = folder.path().join("image").with_extension(writer.extension);
        written.save(&path).unwrap();
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
                image().save(&path).unwrap();
                whole = std::fs::read(&path).unwrap();
            }
            let noise: Vec<u8> = (0..4000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
            for bytes in [&[][..], &noise, &whole[..whole.len() / 3]] {
                std::fs::write(&path, bytes).unwrap();
                let whole = &mut |layout: &Layout| Ok(layout.whole());
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
    let mut written = Image::bare(width, height, vec!["V".into()], Samples::Single(values));
    written.display.white = barnard::image::Level::Radiance(1.0);
    let truth: Vec<f64> = written.display.picture(&written).into_iter().flatten().collect();
    let folder = tempfile::tempdir().unwrap();
    // Largest differences of a colour.
    let mut off = |name: &str, bits: u8| {
        written.display.bits = bits;
        let path = folder.path().join(name);
        written.save(&path).unwrap();
        let (colours, levels): (Vec<f64>, usize) = if name.ends_with(".png") {
            let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
            let mut reader = decoder.read_info().unwrap();
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut bytes).unwrap();
            match info.bit_depth {
                png::BitDepth::Sixteen => (bytes.chunks(2).map(|b| f64::from(u16::from_be_bytes([b[0], b[1]])) / 65535.0).collect(), 65536),
                _ => (bytes.iter().map(|b| f64::from(*b) / 255.0).collect(), 256),
            }
        } else {
            let format = if name.ends_with(".jpg") { image::ImageFormat::Jpeg } else { image::ImageFormat::Tiff };
            let picture = image::load_from_memory_with_format(&std::fs::read(&path).unwrap(), format).unwrap();
            match picture {
                image::DynamicImage::ImageRgb16(own) => (own.into_raw().into_iter().map(|v| f64::from(v) / 65535.0).collect(), 65536),
                other => (other.to_rgb8().into_raw().into_iter().map(|v| f64::from(v) / 255.0).collect(), 256),
            }
        };
        assert_eq!(colours.len(), truth.len(), "{name}");
        (colours.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max), levels)
    };
    for (name, bits, most, levels) in
        [("a.png", 8, 1.0 / 255.0, 256), ("b.png", 16, 0.6 / 65535.0, 65536), ("c.tif", 8, 0.6 / 65535.0, 65536), ("d.jpg", 8, 0.03, 256)]
    {
        let (off, own) = off(name, bits);
        assert!(off <= most && own == levels, "{name}: {off:e}");
    }
    assert!(off("e.png", 8).0 > 10.0 / 65535.0);
}

/// An EXR shows what a display does to programs that know no bands: R, G and B in half precision, 1 at the white; radiances stand
/// in a layer of their own, whole.
#[test]
fn exr_files_have_layers() {
    use exr::prelude::*;
    let mut written = image();
    written.display.white = barnard::image::Level::Radiance(1.5e-6);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    written.save(&path).unwrap();
    let file = read_first_flat_layer_from_file(&path).unwrap();
    let list = &file.layer_data.channel_data.list;
    let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "radiance.B", "radiance.V"]);
    let of = |name: &str| &list.iter().find(|channel| channel.name.to_string() == name).unwrap().sample_data;
    let tone = written.display.tone(&written);
    for i in 0..12 {
        let rgb = tone.palette.rgb((0..2).map(|band| written.samples.at(12 * band + i)));
        for (name, value) in ["R", "G", "B"].into_iter().zip(rgb) {
            let own = f64::from(of(name).value_by_flat_index(i).to_f32());
            assert!((own - value / 1.5e-6).abs() < 1e-3 * own && matches!(of(name), FlatSamples::F16(_)), "{name} {own}");
        }
        assert_eq!(of("radiance.V").value_by_flat_index(i).to_f32(), written.samples.at(12 + i) as f32);
    }
    assert!(file.attributes.chromaticities.is_some());
}

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

//! Images made of images: both eyes beside each other, and the mean of moments.

use crate::camera::{Arrangement, Camera};
use crate::error::{Error, Result};
use crate::image::{Image, Layer, Samples};
use crate::keywords;

fn check_alike(a: &Image, b: &Image) -> Result<()> {
    if (a.width, a.height, a.bands.len()) == (b.width, b.height, b.bands.len()) {
        return Ok(());
    }
    Err(Error::conflict("images to combine differ in size or bands", "keep both constant over the exposure"))
}

/// The images of the left and the right eye as one, which says of itself what the left one does.
///
/// # Errors
/// If they differ in size or bands.
pub fn joined(arrangement: Arrangement, left: Image, right: &Image) -> Result<Image> {
    check_alike(&left, right)?;
    let (width, height, bands) = (left.width, left.height, left.bands.len());
    let image = match arrangement {
        Arrangement::OverUnder => Image { height: 2 * height, views: (left.views.0, 2 * left.views.1), ..left },
        Arrangement::SideBySide => Image { width: 2 * width, views: (2 * left.views.0, left.views.1), ..left },
    };
    let (columns, rows) = (image.width, image.height);
    // Band by band, row by row: which eye, and where in its image.
    let from = |i: usize| {
        let (band, row, column) = (i / (columns * rows), i / columns % rows, i % columns);
        let is_right = row >= height || column >= width;
        (is_right, (band * height + row % height) * width + column % width)
    };
    let samples = Samples::gathered(&image.samples, &right.samples, bands * columns * rows, from);
    let layer = |(left, right): (&Layer, &Layer)| {
        let count = left.samples.len() + right.samples.len();
        Layer { samples: Samples::gathered(&left.samples, &right.samples, count, from), ..left.clone() }
    };
    let layers = image.layers.iter().zip(&right.layers).map(layer).collect();
    let mut image = Image { samples, layers, pixel: None, view: None, points: Vec::new(), ..image };
    // A place of it is one of the sky for one of the eyes alone.
    let words = if arrangement == Arrangement::OverUnder { "left eye above right" } else { "left eye beside right" };
    image.notes.push(("stereo".into(), words.into()));
    Ok(image)
}

/// The images of the left and the right eye that are one, of a camera with two.
pub fn parted(arrangement: Arrangement, image: &Image, camera: &Camera) -> [Image; 2] {
    let (columns, rows) = image.views;
    let (width, height, views) = match arrangement {
        Arrangement::OverUnder => (image.width, image.height / 2, (columns, rows / 2)),
        Arrangement::SideBySide => (image.width / 2, image.height, (columns / 2, rows)),
    };
    let pixels = width * height;
    let eyes = camera.eyes().map_or([None, None], |eyes| eyes.map(Some));
    let mut number = 0..2usize;
    eyes.map(|eye| {
        let (is_right, eye) = (number.next() == Some(1), eye.as_ref().unwrap_or(camera));
        let (row, column) = match arrangement {
            Arrangement::OverUnder => (if is_right { height } else { 0 }, 0),
            Arrangement::SideBySide => (0, if is_right { width } else { 0 }),
        };
        let from = |i: usize| ((i / pixels * image.height) + row + i % pixels / width) * image.width + column + i % width;
        let part = |samples: &Samples| Samples::gathered(samples, samples, samples.len() / 2, |i| (false, from(i)));
        let layers = image.layers.iter().map(|layer| Layer { samples: part(&layer.samples), ..layer.clone() }).collect();
        let samples = part(&image.samples);
        let mut mean = Image {
            width,
            height,
            samples,
            views,
            layers,
            pixel: Some(eye.pixel_scale()),
            axis: eye.axis(),
            view: eye.view(),
            points: Vec::new(),
            ..image.clone()
        };
        // Where this eye stands; in an image of all around both stand around the camera.
        for (name, value) in [("CAMX", eye.position.x), ("CAMY", eye.position.y), ("CAMZ", eye.position.z)] {
            mean.keywords
                .iter_mut()
                .filter(|keyword| keyword.name == name)
                .for_each(|keyword| keyword.value = keywords::Value::Number(value));
        }
        mean.keywords.push(keywords::text("EYE", if is_right { "right" } else { "left" }, "eye of the image"));
        mean
    })
}

/// The mean of pictures of one size through one set of bands, as one that was exposed to all of them says of itself what the
/// first does; none where there is none.
///
/// # Errors
/// Errors of the pictures, and pictures that differ in size or bands.
pub fn mean<E: From<Error>>(images: impl IntoIterator<Item = std::result::Result<Image, E>>) -> std::result::Result<Option<Image>, E> {
    let mut images = images.into_iter();
    let Some(mut sum) = images.next().transpose()? else { return Ok(None) };
    let mut count = 1.0;
    for image in images {
        let image = image?;
        check_alike(&sum, &image)?;
        sum.samples.add_all(&image.samples);
        for layer in image.layers {
            // A light that shines at some moments has a layer at those.
            match sum.layers.iter_mut().find(|known| known.name == layer.name) {
                Some(known) => known.samples.add_all(&layer.samples),
                None => sum.layers.push(layer),
            }
        }
        sum.points.extend(image.points);
        count += 1.0;
    }
    let all = std::iter::once(&mut sum.samples).chain(sum.layers.iter_mut().map(|layer| &mut layer.samples));
    all.for_each(|samples| samples.scale(1.0 / count));
    sum.points.iter_mut().flat_map(|point| &mut point.flux).for_each(|flux| *flux /= count);
    Ok(Some(sum))
}

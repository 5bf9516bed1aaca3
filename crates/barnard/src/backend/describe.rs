//! What every image says of itself.

use crate::camera::Camera;
use crate::image::{Band, Image, Samples};
use crate::keywords;
use crate::scene::Scene;

/// An image of `scene` as `camera` sees it, bands × height × width, its bands and scene described.
pub fn describe(scene: &Scene, camera: &Camera, samples: Samples) -> Image {
    let band = |b: &spectra::passband::Passband| Band {
        name: b.name().to_owned(),
        pivot_um: Some(b.pivot().0),
        counting: Some(b.counting().name()),
        width_um: Some(b.integrate(|_| 1.0)),
        certificate: Vec::new(),
        keywords: keywords::of_passband(b),
    };
    let notes = vec![
        ("scene".into(), scene.name.clone()),
        ("generator".into(), format!("Barnard {}", env!("CARGO_PKG_VERSION"))),
        (
            "quantity".into(),
            "band radiance, integral of R I_lambda d lambda [W m-2 sr-1]; photon-counting bands have R = T lambda/pivot".into(),
        ),
    ];
    Image {
        width: camera.width,
        height: camera.height,
        bands: scene.bands.iter().map(band).collect(),
        samples,
        pixel: Some(camera.pixel_scale()),
        notes,
        display: scene.display.clone(),
        keywords: keywords::of_scene(scene, camera),
    }
}

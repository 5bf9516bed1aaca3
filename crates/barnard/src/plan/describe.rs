//! What every image says of itself.

use crate::image::{Band, Image, Samples};
use crate::keywords;
use crate::scene::Scene;

/// An image of `scene` with these samples, its bands and scene described.
pub fn describe(scene: &Scene, samples: Samples) -> Image {
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
        width: scene.camera.width,
        height: scene.camera.height,
        bands: scene.bands.iter().map(band).collect(),
        samples,
        pixel: Some(scene.camera.pixel_scale()),
        notes,
        keywords: keywords::of_scene(scene),
    }
}

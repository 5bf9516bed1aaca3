//! Description stored in every image.

use spectra::passband::Passband;
use spectra::sed::{MagnitudeSystem, zero_point};

use crate::camera::panorama::PanoramaLayout;
use crate::camera::{Camera, Projection};
use crate::image::{Band, Image, Plane, Report, Samples};
use crate::keywords::{Keyword, integer, number, text};
use crate::points;
use crate::scene::Scene;

/// An image of `scene` as `camera` sees it, bands × height × width, its bands and scene described.
pub fn describe(scene: &Scene, camera: &Camera, samples: Samples) -> Image {
    let band = |b: &spectra::passband::Passband| Band {
        name: b.name().to_owned(),
        plane: Plane::Radiance,
        pivot_um: Some(b.pivot().0),
        counting: Some(b.counting().name()),
        width_um: Some(b.integrate(|_| 1.0)),
        in_unit: scene.in_unit(b, camera).ok().flatten(),
        keywords: of_passband(b),
    };
    let mut notes = vec![
        ("scene".into(), scene.name.clone()),
        ("generator".into(), format!("Barnard {}", env!("CARGO_PKG_VERSION"))),
        (
            "quantity".into(),
            "band radiance, integral of R I_lambda d lambda [W m-2 sr-1]; photon-counting bands have R = T lambda/pivot".into(),
        ),
    ];
    notes.extend(scene.dust.as_ref().and_then(|dust| dust.albedo.note(&dust.extinction.name)));
    notes.extend(left_out(scene).map(|note| ("left out".into(), note)));
    notes.extend(points::catalogue_note(scene, camera).map(|note| ("catalogue".into(), note)));
    Image {
        width: camera.width,
        height: camera.height,
        bands: scene.bands.iter().map(band).collect(),
        spectral: scene.spectrograph.map(|spectrograph| spectrograph.axis),
        samples,
        views: views(camera),
        pixel: Some(camera.pixel_scale()),
        axis: camera.axis(),
        part: camera.part,
        circle: camera.circle(),
        view: camera.view(),
        points: Vec::new(),
        moment: None,
        observation: scene.observation,
        report: Report::default(),
        notes,
        layers: Vec::new(),
        keywords: of_scene(scene, camera),
    }
}

/// From where on passbands see heated dust, and lines of molecular hydrogen and iron \[µm\].
const WARM_DUST_UM: f64 = 3.0;
const MOLECULES_UM: f64 = 1.2;

/// Emission of dust and gas in a scene's passbands that Barnard does not model; none where there is nothing.
pub fn left_out(scene: &Scene) -> Option<String> {
    let reaches = |um: f64| scene.bands.iter().any(|band| band.support_um().1 > um);
    let of_dust = scene.dust.is_some() && reaches(WARM_DUST_UM);
    let of_gas = scene.ionised().is_some() && reaches(MOLECULES_UM);
    let parts = [(of_dust, "thermal emission of dust and PAHs"), (of_gas, "lines of H2 and [Fe II]")];
    let parts: Vec<&str> = parts.into_iter().filter(|(is_seen, _)| *is_seen).map(|(_, what)| what).collect();
    (!parts.is_empty()).then(|| format!("{}, visible in these passbands, are not modelled", parts.join(" and ")))
}

/// The faces of a whole cube are views of their own.
fn views(camera: &Camera) -> (usize, usize) {
    let is_cube = matches!(camera.projection, Projection::Panorama { layout: PanoramaLayout::Cube, .. });
    if is_cube && camera.axis() == (0.0, 0.0) && camera.height == 6 * camera.width { (1, 6) } else { (1, 1) }
}

/// Header entries of `scene` for any picture of `camera`: name, digest, camera and dust.
fn of_scene(scene: &Scene, camera: &Camera) -> Vec<Keyword> {
    let mut keywords = vec![text("OBJECT", &*scene.name, "name of the scene")];
    keywords.extend(scene.provenance.iter().map(|from| text("SCENESHA", from.digest(), "SHA-256")));
    let (projection, field) = match camera.projection {
        Projection::Perspective { half_width } => {
            let ends = [camera.offset.0 + 1.0, camera.offset.0 - 1.0].map(|x| (half_width * x).atan().to_degrees());
            ("perspective", number("CAMFOV", ends[0] - ends[1], "[deg] horizontal field of view"))
        }
        Projection::Panorama { layout: PanoramaLayout::Dome { half_aperture, tilt }, .. } => {
            keywords.extend(number("CAMTILT", tilt.to_degrees(), "[deg] of the dome's axis from up towards the target"));
            ("fisheye", number("CAMFOV", (2.0 * half_aperture).to_degrees(), "[deg] across the circle"))
        }
        Projection::Panorama { layout: PanoramaLayout::Sphere, .. } => ("equirectangular", None),
        Projection::Panorama { layout: PanoramaLayout::Cube, .. } => ("cubemap", None),
        Projection::Orthographic { half_width_pc } => ("orthographic", number("CAMWIDTH", 2.0 * half_width_pc, "[pc] width of the image")),
    };
    keywords.push(text("CAMERA", projection, "projection of the camera"));
    keywords.extend(field);
    let (place, view) = (camera.position, camera.forward);
    let nebula = scene.densities().map(|f| f.bounds()).reduce(|a, b| a.union(&b));
    let distance = nebula.map_or(f64::NAN, |b| (0.5 * (b.low + b.high) - place).length());
    let numbers = [
        ("CAMX", place.x, "[pc] position of the camera"),
        ("CAMY", place.y, "[pc]"),
        ("CAMZ", place.z, "[pc]"),
        ("VIEWX", view.x, "viewing direction, unit vector"),
        ("VIEWY", view.y, ""),
        ("VIEWZ", view.z, ""),
        ("DISTANCE", distance, "[pc] from the camera to the centre of the nebula"),
    ];
    keywords.extend(numbers.into_iter().filter_map(|(name, value, comment)| number(name, value, comment)));
    keywords.push(integer("SUPERSMP", camera.supersampling, "rays per pixel edge"));
    if let Some(dust) = &scene.dust {
        keywords.push(text("DUSTLAW", &*dust.extinction.name, "extinction law"));
        keywords.extend(dust.extinction.r_v.and_then(|r_v| number("R_V", r_v, "A(V)/E(B-V) of the extinction law")));
    }
    keywords
}

/// Passband properties for conversions to magnitudes and flux densities.
fn of_passband(band: &Passband) -> Vec<Keyword> {
    const ANGSTROMS: f64 = 1e4;
    let width = band.integrate(|_| 1.0) * ANGSTROMS;
    // m = −2.5 lg(flux / W m⁻²) + zero point.
    let zero = |system: MagnitudeSystem| zero_point(band, system).map_or(f64::NAN, |flux| 2.5 * flux.log10());
    let rows = [
        ("PHOTPLAM", band.pivot().0 * ANGSTROMS, "[Angstrom] pivot wavelength"),
        ("PHOTFLAM", 1.0 / width, "[Angstrom-1] band radiance to mean F_lambda"),
        ("ZPVEGA", zero(MagnitudeSystem::Vega), "[mag] Vega magnitude of a flux of 1 W m-2"),
        ("ZPAB", zero(MagnitudeSystem::Ab), "[mag] AB magnitude of a flux of 1 W m-2"),
    ];
    rows.into_iter().filter_map(|(name, value, comment)| number(name, value, comment)).collect()
}

//! Range of plates: wavelengths and amounts of dust, and the scene whose march reaches them.

use spectra::passband::{Counting, Window, window};
use spectra::rule::Settings;
use spectra::units::Wavelength;

use super::binds_dust;
use crate::error::{Error, Result};
use crate::light::law;
use crate::scene::{Method, Scene};

/// Reach of plates beyond the passbands of their scene, relative to the wavelength.
const BEYOND: f64 = 0.1;

/// Range of plates beyond the spectra of their scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// The shortest wavelength and the longest \[µm\]; none: those of the scene's passbands and a tenth beyond.
    pub range_um: Option<(f64, f64)>,
    /// The least amount of dust and the largest, as parts of the scene's.
    pub dust: (f64, f64),
}

impl Default for Reach {
    /// The scene's own dust, and what lies around its passbands.
    fn default() -> Self {
        Self { range_um: None, dust: (1.0, 1.0) }
    }
}

/// The wavelengths that plates of a scene serve \[µm\].
pub(super) fn range(scene: &Scene, asked: Option<(f64, f64)>) -> Result<(f64, f64)> {
    let ends = scene.bands.iter().map(|band| band.support_um());
    let (low, high) = ends.fold((f64::INFINITY, 0.0f64), |(low, high), (a, b)| (low.min(a), high.max(b)));
    let Some((from, to)) = asked else {
        let (first, last) = law(scene)?.range_um();
        return Ok(((low * (1.0 - BEYOND)).max(first.min(low)), (high * (1.0 + BEYOND)).min(last.max(high))));
    };
    if !(from > 0.0 && to > from && to.is_finite()) {
        let value = format!("{} to {} nm", from * 1e3, to * 1e3);
        return Err(Error::out_of_range("range of plates", value, "from a shorter to a longer wavelength"));
    }
    if let Some(dust) = &scene.dust {
        dust.extinction.check("the range of plates", from, to)?;
    }
    Ok((low.min(from), high.max(to)))
}

/// By how much nodes reach beyond the extinctions that are asked for, as a part of them.
const ROOM: f64 = 2e-3;
/// Most by which the amount of dust may change.
const MOST_DUST: f64 = 100.0;

/// The amounts of dust that plates of a scene reach, as parts of its own.
pub(super) fn amounts(scene: &Scene, (least, most): (f64, f64)) -> Result<(f64, f64)> {
    let value = || format!("{least} to {most}");
    if !(least > 0.0 && least <= 1.0 && (1.0..=MOST_DUST).contains(&most)) {
        let allowed = format!("a factor above 0 and up to 1, and one from 1 to {MOST_DUST}");
        return Err(Error::out_of_range("dust range of plates", value(), allowed));
    }
    if (least, most) != (1.0, 1.0) && binds_dust(scene) {
        return Err(Error::unsupported(
            format!("a dust range of {}", value()),
            "a plate of multiple scattering, or of a phase function that depends on wavelength,",
            "leave it out",
        ));
    }
    // A law that turns back between two places at which it was looked at goes a little farther. Nodes that are wavelengths are its own.
    let room = if binds_dust(scene) { 0.0 } else { ROOM };
    Ok((least * (1.0 - room), most * (1.0 + room)))
}

/// The scene whose march brings plates of light that scatters once at most: with a passband of the whole range, and common nodes.
pub(super) fn one_scattering(scene: &Scene, (low, high): (f64, f64), amounts: (f64, f64)) -> Result<Scene> {
    let shape = Window::TopHat { centre: Wavelength(0.5 * (low + high)), width: Wavelength(high - low) };
    let mut bands = scene.bands.clone();
    bands.push(window("the range of plates", Counting::Energy, shape)?);
    let mut method =
        Method { bounces: 1, settings: Settings { amounts, ..Settings::default() }, ..scene.method.clone() }.with_name("common_nodes")?;
    method.exact_stars = None;
    scene.as_lights().with_bands(bands).with_method(method).build()
}

/// Largest number of stars.
const MOST_STARS: usize = 256;

/// Rejects scenes that plates do not support.
pub(super) fn check(scene: &Scene) -> Result<()> {
    if scene.camera.stereo.is_some() {
        return Err(Error::unsupported("a stereo camera", "a set of plates", "remove [camera.stereo]"));
    }
    if scene.stars.len() > MOST_STARS {
        let feature = format!("{} stars with a plate each", scene.stars.len());
        return Err(Error::unsupported(feature, "a set of plates", format!("use at most {MOST_STARS} stars")));
    }
    Ok(())
}

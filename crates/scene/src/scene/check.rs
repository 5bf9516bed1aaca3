//! Checks of a scene as a whole.

use std::sync::Arc;

use spectra::passband::Passband;
use spectra::spectrum::Spectrum;

use super::{Scene, observation};
use crate::camera::{Camera, Projection};
use crate::detail::Detail;
use crate::error::{Error, Result};
use crate::image::PixelScale;
use crate::instrument::Instrument;
use crate::memory;
use crate::observation::InUnit;
use crate::properties::Place;

impl Scene {
    /// Refuses an image that would take more than `memory_limit` bytes, sixteen for each value, whatever its layers are.
    ///
    /// # Errors
    /// If it would.
    pub fn check_image(&self, memory_limit: u64) -> Result<()> {
        memory::check("the image", self.image_bytes(self.bands.len()), memory_limit)
    }

    /// Memory of an image with `values` numbers per pixel \[bytes\].
    pub fn image_bytes(&self, values: usize) -> u64 {
        // Both eyes, and both together.
        let images = if self.camera.stereo.is_some() { 4 } else { 1 };
        let pixels = (self.camera.width as u64).saturating_mul(self.camera.height as u64).saturating_mul(images);
        pixels.saturating_mul(16 * values as u64)
    }

    /// Checks that the scene can be rendered: every number is one that its object can have, and spectra and laws reach
    /// over every passband. Everything that renders a scene asks this first.
    ///
    /// # Errors
    /// If something is wrong, with its place such as `star[2].position` and what would be right.
    pub fn check(&self) -> Result<()> {
        at("", "camera", self.camera.check())?;
        self.bookmarks.iter().try_for_each(|(name, camera)| at("bookmark", name, camera.check()))?;
        self.check_bands()?;
        if let Some(dust) = &self.dust {
            at("", "dust", dust.check())?;
        }
        self.species.iter().try_for_each(|gas| at("", "emission", gas.check()))?;
        self.stars.iter().enumerate().try_for_each(|(i, star)| at(&format!("star[{i}]"), "position", star.check()))?;
        at("", "background", self.background.check())?;
        at("", "detail", self.detail.as_ref().map_or(Ok(()), Detail::check))?;
        let dust = self.dust.iter().map(|dust| ("dust", &dust.density));
        for (key, density) in dust.chain(self.species.iter().map(|gas| ("emission", &gas.density))) {
            at("", key, density.check())?;
        }
        at("", "method", self.method.check())?;
        at("", "display", self.display.check())?;
        if let Some(observation) = &self.observation {
            let mut cameras = std::iter::once(&self.camera).chain(self.bookmarks.values());
            at("", "observation", cameras.try_for_each(|camera| observation::check(observation, camera)))?;
            let convert = |band| self.in_unit(band, &self.camera).map(|_| ());
            self.bands.iter().try_for_each(|band| at("observation", "unit", convert(band)))?;
        }
        let parallel = |camera: &Camera| matches!(camera.projection, Projection::Orthographic { .. });
        if self.background.has_stars() && std::iter::once(&self.camera).chain(self.bookmarks.values()).any(parallel) {
            return Err(placed_error(
                "",
                "background",
                "stars at infinity require a [camera], and bookmarks, whose rays start at one point; use a kind such as \"perspective\"",
            ));
        }
        Ok(())
    }

    /// Checks that there are passbands, each with a name of its own and a colour, and that laws and spectra reach over
    /// all of them.
    fn check_bands(&self) -> Result<()> {
        if self.bands.is_empty() {
            return Err(placed_error("", "bands", "the scene has no passbands; write bands = \"johnson\""));
        }
        for (i, band) in self.bands.iter().enumerate() {
            if self.bands[..i].iter().any(|b| b.name() == band.name()) {
                let message = format!("two passbands have the name \"{}\"; rename one", band.name());
                return Err(placed_error("", "bands", message));
            }
            let (low, high) = band.support_um();
            let what = format!("passband {}", band.name());
            if let Some(dust) = &self.dust {
                at("", "bands", dust.extinction.check(&what, low, high))?;
            }
            for spectrum in self.spectra() {
                at("", "bands", spectrum.check(&what, low, high))?;
            }
        }
        let (columns, bands) = (self.display.palette.columns.len(), self.bands.len());
        if columns != bands {
            let message = format!("the palette has colours for {columns} bands, the scene has {bands}");
            return Err(placed_error("display", "palette", message));
        }
        Ok(())
    }

    /// How band radiances through a passband become the unit of the observation, as a camera sees them; none where there is no observation.
    ///
    /// # Errors
    /// If Vega is unknown in the passband, or electrons are requested without an instrument.
    pub fn in_unit(&self, band: &Passband, camera: &Camera) -> Result<Option<InUnit>> {
        let Some(observation) = self.observation else { return Ok(None) };
        let pixel_rad = match (camera.pixel_scale(), observation.distance_pc) {
            (PixelScale::Length(pc), Some(distance)) => pc / distance,
            (pixel, _) => pixel.in_unit().0.to_radians(),
        };
        let electrons =
            |instrument: &Arc<Instrument>| instrument.electrons(band.pivot().0) * instrument.pixel_rad.unwrap_or(pixel_rad).powi(2);
        observation.unit.of(band, self.instrument.as_ref().map(electrons)).map(Some)
    }

    /// Every spectrum in the scene.
    fn spectra(&self) -> impl Iterator<Item = &Spectrum> {
        let stars = self.stars.iter().map(|s| &s.spectrum);
        let catalogue = self.background.catalogue.iter().flat_map(|placed| placed.catalogue.classes.iter().map(|class| &class.spectrum));
        stars.chain(self.species.iter().map(|e| &e.spectrum)).chain(self.background.spectrum.iter()).chain(catalogue)
    }
}

fn placed_error(path: &str, key: &str, message: impl Into<String>) -> Error {
    Error::Scene { message: message.into(), place: Place { origin: None, path: path.into(), key: key.into() } }
}

/// Adds a place to what was found about one object.
pub(super) fn at<T, E: Into<Error>>(path: &str, key: &str, result: std::result::Result<T, E>) -> Result<T> {
    result.map_err(|error| match error.into() {
        error @ (Error::Memory { .. } | Error::Interrupted) => error,
        error => placed_error(path, key, error.to_string()),
    })
}

//! Pictures of plates.

use super::mixture;
use super::{Mixture, Plates};
use crate::backend::describe;
use crate::control::Control;
use crate::error::Error;
use crate::error::Result;
use crate::geometry::Ray;
use crate::image::BandCertificates;
use crate::image::Image;
use crate::image::PointSource;
use crate::image::Report;
use crate::image::Samples;
use crate::light::lights;
use crate::points::Sources;
use crate::points::points;
use crate::scene::Scene;
use spectra::rule::Certificate;

impl Plates {
    /// Adds the extended light of a mixture to `picture`, bands × height × width [W m⁻² sr⁻¹], which has as many bands as the
    /// mixture's scene.
    ///
    /// # Errors
    /// If the picture has another size.
    pub fn add(&self, mixture: &Mixture, picture: &mut [f32]) -> Result<()> {
        let pixels = self.0.size[0] * self.0.size[1];
        if picture.len() != pixels * mixture.parts.len() {
            let wanted = format!("{} bands of {} x {} pixels", mixture.parts.len(), self.0.size[0], self.0.size[1]);
            return Err(Error::mismatch("picture of plates", wanted, format!("{} values", picture.len())));
        }
        mixture::add(&self.0.plates, &mixture.shares, pixels, picture);
        Ok(())
    }

    /// The picture of a scene that differs from theirs in spectra alone, with its errors.
    ///
    /// # Errors
    /// Errors of [`mixture`](Self::mixture), and on interruption by the user.
    pub fn expose(&self, scene: &Scene, control: &Control) -> Result<Image> {
        let (mixture, lights) = (self.mixture(scene)?, lights(scene)?);
        let mut image = self.pictured(scene, &mixture, control)?;
        let certificates = scene.bands.iter().enumerate().map(|(number, band)| {
            let named = |(light, certificate): (usize, Certificate)| (lights[light].name.clone(), certificate);
            BandCertificates { band: band.name().to_owned(), lights: self.certificates(&mixture, number).into_iter().map(named).collect() }
        });
        image.report = Report {
            backend: Some("plates".into()),
            accuracy: Some(self.0.accuracy),
            depth: Some(self.0.depth * mixture.amount),
            certificates: certificates.collect(),
            notes: self.0.notes.clone(),
            ..Report::default()
        };
        Ok(image)
    }

    /// Variant of a mixture of the scene, without its errors, for looks that pass by.
    ///
    /// # Errors
    /// If the scene has other stars of a field, values are no numbers, and on interruption by the user.
    pub fn pictured(&self, scene: &Scene, mixture: &Mixture, control: &Control) -> Result<Image> {
        let mut light = vec![0.0; scene.bands.len() * self.0.size[0] * self.0.size[1]];
        self.add(mixture, &mut light)?;
        self.finished(scene, mixture, Samples::Single(light), control)
    }

    /// Variant in double precision, for programs that take differences of pictures: stored numbers are those of the plates, and what is
    /// made of them is smooth in spectra and in the amount of dust.
    ///
    /// # Errors
    /// Errors of [`pictured`](Self::pictured).
    pub fn pictured_in_double(&self, scene: &Scene, mixture: &Mixture, control: &Control) -> Result<Image> {
        let pixels = self.0.size[0] * self.0.size[1];
        let mut light = vec![0.0; scene.bands.len() * pixels];
        mixture::add_in_double(&self.0.plates, &mixture.shares, pixels, &mut light);
        self.finished(scene, mixture, Samples::Double(light), control)
    }

    /// The picture of extended light, unresolved sources added.
    fn finished(&self, scene: &Scene, mixture: &Mixture, mut samples: Samples, control: &Control) -> Result<Image> {
        let points = self.draw(scene, mixture, &mut samples, control)?;
        let image = Image { points, ..describe(scene, &scene.camera, samples) };
        image.check()?;
        Ok(image)
    }

    /// Draws the unresolved sources.
    fn draw(&self, scene: &Scene, mixture: &Mixture, samples: &mut Samples, control: &Control) -> Result<Vec<PointSource>> {
        let lights = lights(scene)?;
        let depths = &self.0.depths;
        if points(Sources::All, scene, &scene.camera, &lights)?.len() != depths.len() {
            return Err(Error::conflict("the plates have other field or catalogue stars", "make new plates of this scene"));
        }
        let fluxes = |number: usize, light: usize, _: &Ray, _: f64| {
            let depth = depths[number] * mixture.amount;
            let left: Vec<f64> = mixture.nodes.iter().map(|node| (-node.k * depth).exp()).collect();
            mixture.points[light].iter().map(|weights| weights.iter().zip(&left).map(|(w, left)| w * left).sum()).collect()
        };
        crate::points::draw(Sources::All, scene, &scene.camera, &lights, fluxes, control, |i, value| samples.add(i, value))
    }
}

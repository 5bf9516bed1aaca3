//! The light of all stars in one field: what `propagation` marches in place of star depths.
//!
//! A voxel holds Σ_ℓ q_i(τ_ℓ) P_ℓ/(4π r_ℓ²) as element × polynomial, eq. (18) of docs/method.md; see
//! `spectra::propagation`. 1/r² is the mean over the voxel, so that no star stands in a pole; what trilinear
//! interpolation makes of it near a star is part of the spatial error that the pilots measure. Directions are lost:
//! light is scattered evenly.

use glam::DVec3;
use rayon::prelude::*;
use spectra::basis::Criterion;
use spectra::polynomial::Fit;
use spectra::propagation::Propagation;
use spectra::rule::{Certificate, Form, Source};
use spectra::sed::PowerLaw;
use spectra::spectrum::Spectrum;
use spectra::units::Wavelength;

use crate::control::{Control, Stage};
use crate::error::{Error, Result};
use crate::field::Lattice;
use crate::light::{Route, factor, law};
use crate::memory;
use crate::plan::SpatialPlan;
use crate::plan::draft::Draft;
use crate::plan::inverse_square::inverse_square_of_voxel;
use crate::plan::spectral::support_um;
use crate::volume::{Channel, MAX_CHANNELS, Volume};

/// Starlight as a few polynomials a voxel.
#[derive(Debug)]
pub struct LightField {
    /// The basis, its products and the polynomials.
    pub propagation: Propagation,
    /// Element × polynomial, eight channels in each volume.
    pub volumes: Vec<Volume>,
    /// ∫ R k ω Q_j P dλ/(4π) [band][element × polynomial].
    pub resolution: Vec<Vec<f64>>,
    /// True if the scene's phase function was left out, since the field scatters evenly.
    pub isotropic_instead: bool,
    /// The number of each star among the lights.
    lights: Vec<usize>,
    /// The error of each star for depths up to those of the plan [band][star].
    certificates: Vec<Vec<Certificate>>,
    /// The optical depth up to which the certificates hold [1].
    depth: f64,
}

impl LightField {
    /// The light of all stars of a draft; none where there is no dust, or none of them shines through a band.
    pub(crate) fn new(draft: &Draft, control: &Control) -> Result<Option<Self>> {
        let Draft { scene, options, lights, space, spectral, .. } = draft;
        let Some(dust) = &space.dust else { return Ok(None) };
        let scattered = lights.iter().enumerate().filter_map(|(i, l)| match l.route {
            Route::Scattered { star } => Some((i, star)),
            _ => None,
        });
        let (numbers, stars): (Vec<usize>, Vec<usize>) = scattered.unzip();
        let projections = spectral.bands.iter().filter_map(|b| match &b.rule.form {
            Form::Projection(projection) => Some(projection),
            _ => None,
        });
        let Some(projection) = projections.max_by_key(|p| p.basis.size()).filter(|_| !stars.is_empty()) else { return Ok(None) };
        let rule = &scene.method.settings;
        if rule.criterion == Criterion::Filter && scene.bands.len() > 1 {
            let message = "method \"propagation\" uses one basis for all passbands, but criterion = \"filter\" one per passband; use \"mean\" or \"largest\", or a single passband";
            return Err(Error::Method(message.into()));
        }
        let continua: Vec<_> = numbers.iter().map(|light| |lambda: f64| lights[*light].spectrum.continuum(lambda)).collect();
        let spectra: Vec<&dyn Fn(f64) -> f64> = continua.iter().map(|c| c as &dyn Fn(f64) -> f64).collect();
        let propagation = Propagation::new(projection, &spectra, support_um(scene), rule.degree, spectral.accuracy)?;
        if propagation.span.is_empty() {
            return Ok(None);
        }
        let law = law(scene)?;
        let resolution = |band| {
            let flat = PowerLaw { reference: Wavelength(1.0), exponent: 0.0 };
            let flat = Spectrum::continuous(1.0, std::sync::Arc::new(flat));
            let response = Source::new("response", band, &flat, &**law, factor(lights[numbers[0]].route, scene.dust.as_ref())).measure;
            propagation.resolution(&response).iter().map(|r| r / spectra::constants::SPHERE).collect()
        };
        let resolution = scene.bands.iter().map(resolution).collect();
        let voxels = Volume::zeroed(dust.lattice(), Vec::new()).lattice.cells() as u64;
        let bytes = space.bytes() + 4 * voxels * propagation.channels() as u64;
        memory::check("star depths and the light field of propagation", bytes, options.memory_limit)?;
        let volumes = deposited(&propagation, space, &stars, dust.lattice(), control)?;
        let isotropic_instead = spectral.phase.is_some();
        let depth = spectral.depth;
        let mut field = Self { propagation, volumes, resolution, isotropic_instead, lights: numbers, certificates: Vec::new(), depth };
        for (b, band) in spectral.bands.iter().enumerate() {
            control.check()?;
            field.certificates.push(field.certified(b, &band.sources, depth));
        }
        Ok(Some(field))
    }

    /// Element × polynomial at a place.
    pub fn at(&self, p: DVec3) -> Vec<f64> {
        self.volumes.iter().flat_map(|v| (0..v.channels.len()).map(move |c| v.at(c, p))).collect()
    }

    /// The error of each light of the field through a band, for depths up to `depth`.
    pub fn certify(&self, band: usize, sources: &[Source], depth: f64) -> Vec<(usize, Certificate)> {
        let certificates = if depth <= self.depth { self.certificates[band].clone() } else { self.certified(band, sources, depth) };
        self.lights.iter().copied().zip(certificates).collect()
    }

    fn certified(&self, band: usize, sources: &[Source], depth: f64) -> Vec<Certificate> {
        let resolution: Vec<f64> = self.resolution[band].iter().map(|r| r * spectra::constants::SPHERE).collect();
        let of_star = |(star, light): (usize, &usize)| self.propagation.certificate(star, &resolution, &sources[*light].measure, depth);
        self.lights.par_iter().enumerate().map(of_star).collect()
    }

    /// The polynomial of each light.
    pub fn fits(&self) -> impl Iterator<Item = (usize, &Fit)> {
        self.lights.iter().copied().zip(&self.propagation.fits)
    }

    /// The bytes that the field takes.
    pub fn bytes(&self) -> u64 {
        self.volumes.iter().map(Volume::bytes).sum()
    }
}

/// Voxels on the dust's lattice, into which each star's light is put by its depths in `space`.
fn deposited(propagation: &Propagation, space: &SpatialPlan, stars: &[usize], lattice: &Lattice, control: &Control) -> Result<Vec<Volume>> {
    let channels: Vec<Channel> = (0..propagation.channels()).map(Channel::Light).collect();
    let mut volumes: Vec<Volume> = channels.chunks(MAX_CHANNELS).map(|chunk| Volume::zeroed(lattice, chunk.to_vec())).collect();
    let lattice = volumes.first().map_or_else(|| lattice.clone(), |v| v.lattice.clone());
    let depths = stars.iter().map(|star| space.star_channel(*star));
    let depths = depths.collect::<Option<Vec<_>>>().ok_or_else(|| Error::Star("a star has no depths".into()))?;
    let voxel = lattice.voxel_pc();
    let [nx, ny, nz] = lattice.dims;
    // The same plane of all volumes goes to one thread.
    let mut planes: Vec<Vec<&mut [f32]>> = (0..nz).map(|_| Vec::new()).collect();
    for volume in &mut volumes {
        let plane = nx * ny * volume.channels.len();
        volume.single_mut().chunks_exact_mut(plane).zip(&mut planes).for_each(|(part, planes)| planes.push(part));
    }
    let done = std::sync::atomic::AtomicU64::new(0);
    planes.into_par_iter().enumerate().try_for_each(|(z, mut parts)| {
        control.check()?;
        let mut light = vec![0.0; propagation.channels()];
        for i in 0..nx * ny {
            let centre = lattice.centre(i % nx, i / nx, z);
            light.fill(0.0);
            for (s, (star, (volume, slot))) in stars.iter().zip(&depths).enumerate() {
                let depth = volume.at(*slot, centre);
                propagation.deposit(s, depth, inverse_square_of_voxel(centre - space.stars[*star], voxel), &mut light);
            }
            for (part, light) in parts.iter_mut().zip(light.chunks(MAX_CHANNELS)) {
                part[i * light.len()..][..light.len()].iter_mut().zip(light).for_each(|(v, l)| *v = *l as f32);
            }
        }
        let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        control.report(Stage::Light, count, nz as u64);
        Ok::<(), Error>(())
    })?;
    Ok(volumes)
}

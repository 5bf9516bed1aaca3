//! A solved field of scattered light, whoever looks at it, and all that it was solved from.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::fingerprint::{Digest, Fingerprint};

use super::direct_sources::DirectSources;
use super::eye_source::EyeSource;
use super::far_field::{FarField, Scattering};
use super::harmonics::harmonics;
use super::lanes::{EightLanes, WIDTH};
use super::moments::Moments;
use super::reduction::Reduction;
use super::refinement::Level;
use super::term::{Term, scattering};
use super::view::Viewpoint;
use crate::control::Control;
use crate::error::Result;
use crate::field::{self, Grid, Lattice};
use crate::plan::many_lights::near_field_kernel::{NearFieldKernel, Profile};
use crate::plan::{ManyLights, PhaseTable};
use crate::stored::Precision;

/// A field of scattered light, independent of the eye.
#[derive(Debug)]
pub struct Field {
    /// All terms, eight by eight.
    pub parts: Vec<EightTerms>,
    /// Light that was scattered before, in ever smaller cells; one level at least.
    pub levels: Vec<Level>,
    /// The terms that are solved, of which all are sums.
    pub reduction: Arc<Reduction>,
    /// The radiance in units of which moments are stored: radiances are so small that faint ones would not be numbers.
    pub unit: f32,
    /// Stars whose first light is part of it, and how that is scattered.
    pub many_lights: Option<Arc<ManyLights>>,
    pub phase: Option<PhaseTable>,
    /// The kernels around them, within which their light is marched.
    pub kernels: Vec<NearFieldKernel>,
}

/// Eight terms of the field.
#[derive(Debug)]
pub struct EightTerms {
    pub terms: Vec<Term>,
    /// The most that the gathered stars near a ray may add to each term.
    pub near: EightLanes,
    /// The weights that the gathered stars send, without k ω, in parts of the unit.
    pub sent: Vec<EightLanes>,
}

/// Light that was scattered before, and what it was found from.
#[derive(Debug)]
pub struct Solved {
    pub origin: FieldOrigin,
    pub moments: Moments,
    /// Orders that were swept, what the series behind them stands for, and whether they went as one.
    pub sweeps: usize,
    pub series: f64,
    pub settled: bool,
    /// The name of what swept them, and why it was not what should have.
    pub by: Arc<str>,
}

impl Solved {
    /// S towards the eye in each cell, Σ_lm Y_lm(n) ω p_l L_lm, in units of the field.
    pub fn towards(&self, view: Viewpoint) -> Vec<EightLanes> {
        let (lattice, scattered) = (&self.origin.lattice, scattering(&self.origin.terms));
        let of_cell = |cell: usize| {
            let [x, y, z] = lattice.place(cell);
            let values = harmonics(view.towards(lattice.centre(x, y, z)));
            let mut light = [0.0; WIDTH];
            for ((y, moment), scattered) in values.into_iter().zip(self.moments.cell(cell)).zip(&scattered) {
                (0..WIDTH).for_each(|t| light[t] += y as f32 * scattered[t] * moment[t]);
            }
            light
        };
        (0..lattice.cells()).into_par_iter().map(of_cell).collect()
    }
}

/// Everything that the light of eight terms depends on.
#[derive(Debug)]
pub struct FieldOrigin {
    pub lattice: Lattice,
    pub sigma: Vec<f32>,
    pub dust: Arc<Grid>,
    /// The places of all stars, how finely their depths are known, and the kernels around the gathered ones.
    pub places: Vec<DVec3>,
    pub star_factor: usize,
    pub precision: Precision,
    pub kernels: Vec<NearFieldKernel>,
    pub terms: Vec<Term>,
    pub direct_sources: DirectSources,
    pub directions: [usize; 2],
    pub harmonics: usize,
    pub bounces: usize,
}

impl FieldOrigin {
    /// Fingerprint of it, and of whether a device sweeps, whose rounding differs.
    pub fn fingerprint(&self, has_device: bool) -> Fingerprint {
        let Self {
            lattice,
            sigma,
            dust,
            places,
            star_factor,
            precision,
            kernels,
            terms,
            direct_sources: DirectSources { stars, many_lights, glow, around, unit },
            directions,
            harmonics,
            bounces,
        } = self;
        let mut digest = Digest::new("multiple scattering");
        digest.plain(&has_device).plain(lattice).singles(sigma).part(field::fingerprint(&**dust));
        for place in places {
            digest.numbers(&place.to_array());
        }
        digest.plain(&(star_factor, precision, directions, harmonics, bounces)).plain(kernels).plain(terms);
        digest.plain(stars).singles(many_lights.as_flattened()).plain(&glow.is_some());
        digest.singles(glow.as_deref().unwrap_or_default().as_flattened()).singles(around).singles(&[*unit]).finish()
    }
}

impl PartialEq for FieldOrigin {
    fn eq(&self, other: &Self) -> bool {
        let numbers = |o: &Self| (o.star_factor, o.precision, o.directions, o.harmonics, o.bounces);
        numbers(self) == numbers(other)
            && self.lattice == other.lattice
            && self.terms == other.terms
            && self.places == other.places
            && self.kernels == other.kernels
            && self.direct_sources == other.direct_sources
            && self.sigma == other.sigma
            && (Arc::ptr_eq(&self.dust, &other.dust) || self.dust == other.dust)
    }
}

impl Field {
    /// The finest level, in whose cells the field is.
    pub fn finest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// The level before, where that is coarser.
    pub fn coarser(&self) -> Option<&Level> {
        let before = self.levels.len().checked_sub(2).map(|level| &self.levels[level]);
        before.filter(|level| level.cells.lattice.dims != self.finest().cells.lattice.dims)
    }

    /// S of the solved terms towards the eye, in the finest cells.
    pub fn towards(&self, view: Viewpoint) -> EyeSource {
        let finest = self.finest().towards(view);
        match self.coarser() {
            Some(coarser) => finest.extrapolated(&coarser.towards(view)),
            None => finest,
        }
    }

    /// The gathered stars' light, scattered once, in each cell as one eye sees it, part by part; nothing where there
    /// are no such stars.
    pub fn far_field(&self, view: Viewpoint, control: &Control) -> Result<Vec<Moments>> {
        let Some(many_lights) = &self.many_lights else { return Ok(Vec::new()) };
        let terms = self.parts.iter().map(|part| part.terms.len()).sum();
        let of_part = |(p, part): (usize, &EightTerms)| {
            let four = |value: fn(&Term) -> f64| std::array::from_fn(|t| part.terms.get(t).map_or(0.0, |term| value(term) as f32));
            let (k, albedo) = (four(|term| term.k), four(|term| term.albedo));
            let far_field = FarField { many_lights, sent: &part.sent, k: &k, kernels: &self.kernels };
            let scattering = Scattering { view, phase: self.phase.as_ref(), first: p * WIDTH, terms, albedo };
            far_field.seen(&self.finest().cells, &scattering, control)
        };
        self.parts.iter().enumerate().map(of_part).collect()
    }

    /// Depths from each gathered star towards the eye, as far as kernels go.
    pub fn profiles(&self, view: Viewpoint) -> Vec<Profile> {
        self.many_lights.as_ref().map_or_else(Vec::new, |many_lights| many_lights.profiles(&self.kernels, |place| view.towards(place)))
    }
}

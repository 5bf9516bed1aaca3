//! Light that was scattered before, and all that it was solved from.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::fingerprint::{Digest, Fingerprint};

use super::closure::Closure;
use super::direct_sources::DirectSources;
use super::harmonics::harmonics;
use super::lanes::{EightLanes, WIDTH};
use super::moments::Moments;
use super::term::{Term, scattering};
use super::view::Viewpoint;
use crate::field::{self, Grid, Lattice};
use crate::plan::many_lights::near_field_kernel::NearFieldKernel;
use crate::stored::Precision;

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
    /// S towards the eye in each cell, Σ_lm Y_lm(n) ω p_l L_lm and what [`Closure`] adds, in units of the field.
    pub fn towards(&self, view: Viewpoint) -> Vec<EightLanes> {
        let (lattice, scattered) = (&self.origin.lattice, scattering(&self.origin.terms));
        let closure = Closure::new(&self.origin.terms, self.origin.harmonics);
        let of_cell = |cell: usize| {
            let [x, y, z] = lattice.place(cell);
            let (direction, moments) = (view.towards(lattice.centre(x, y, z)), self.moments.cell(cell));
            let mut light = closure.above(direction.as_vec3().to_array(), moments);
            for ((y, moment), scattered) in harmonics(direction).into_iter().zip(moments).zip(&scattered) {
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

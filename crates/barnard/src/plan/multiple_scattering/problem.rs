//! Problem of multiple scattering: a draft of a plan, and its passbands' nodes as media.

use spectra::rule::Node;

use super::cells::SweepCells;
use super::fineness::Fineness;
use super::harmonics::{ALL_DEGREES, DEGREE, count, legendre_moments};
use super::lanes::WIDTH;
use super::moments::Moments;
use super::processor::Sweepers;
use super::term::Term;
use crate::error::{Error, Result};
use crate::field::{Grid, Lattice};
use crate::light::Route;
use crate::memory;
use crate::plan::BandPlan;
use crate::plan::draft::Draft;

/// Fewest cells along the longest edge that are worth it.
const MIN: usize = 12;
/// Rows of moments that are made beside those of each term.
const SCRATCH: usize = 3;
/// Moments of the phase function that are none.
const NEGLIGIBLE: f64 = 0.02;

/// The problem that a field is the solution of.
pub struct Problem<'a> {
    pub draft: &'a Draft<'a>,
    /// The dust that scatters light.
    pub dust: &'a Grid,
    /// The nodes of all passbands.
    pub terms: Vec<Term>,
    /// The strongest weight of any light: all light is in units of this radiance.
    pub unit: f32,
    pub sweepers: Sweepers<'a>,
}

/// The cells that there is memory for.
pub struct Fitting {
    /// Most cells along an edge.
    pub cells: usize,
    /// The bytes of all that is made in them.
    pub bytes: u64,
}

impl<'a> Problem<'a> {
    /// The problem of a draft; none where light scatters once and no stars are gathered, or nothing scatters.
    ///
    /// # Errors
    /// For rules that have no nodes.
    pub fn new(draft: &'a Draft) -> Result<Option<Self>> {
        let gathers = draft.scene.method.bounces > 1 || draft.space.many_lights.is_some();
        let (Some(dust), Some(scattering), true) = (&draft.space.dust, &draft.scene.dust, gathers) else { return Ok(None) };
        let term = |node: &Node| Term {
            k: node.k,
            lambda_um: node.lambda_um,
            albedo: scattering.albedo.at(node.lambda_um),
            legendre: stable(legendre_moments(&*scattering.phase, node.lambda_um)),
        };
        let nodes = draft.spectral.bands.iter().map(nodes).collect::<Result<Vec<_>>>()?;
        let terms = nodes.into_iter().flatten().map(term).collect();
        Ok(Some(Self { draft, dust, terms, unit: unit(draft), sweepers: Sweepers::new(draft.options.sweeper.as_deref()) }))
    }

    /// True if light scatters more than once.
    pub fn scatters_again(&self) -> bool {
        self.draft.scene.method.bounces > 1
    }

    /// As many cells as `fineness` says, or as the memory limit allows, for a number of terms that are solved.
    ///
    /// # Errors
    /// If even the fewest do not fit.
    pub fn fitting(&self, fineness: Fineness, solved: usize) -> Result<Fitting> {
        let Draft { options, space, .. } = self.draft;
        let harmonics = count(self.kept_degree(fineness));
        // Of each cell: all solved orders, what is made of eight terms while they are swept, the aggregated stars' light, and
        // what the march reads.
        let sweeping = 4 * (2 * solved.min(WIDTH) + SCRATCH) as u64 * harmonics as u64;
        let orders = if self.scatters_again() { Moments::bytes(solved.div_ceil(WIDTH) + 1, harmonics) + sweeping } else { 0 };
        let parts = self.terms.len().div_ceil(WIDTH);
        let gathered = if space.many_lights.is_some() { Moments::bytes(2 * parts, 1) } else { 0 };
        let glow = if space.gas().is_empty() { 0 } else { Moments::bytes(1, 1) };
        let of_cell = orders + gathered + glow + 4 * self.terms.len() as u64;
        let bytes_of = |edge: usize| of_cell.saturating_mul(self.lattice(edge).cells() as u64);
        let limit = options.memory_limit;
        let mut edge = fineness.cells;
        while bytes_of(edge) > limit.saturating_sub(space.bytes()) && edge > MIN {
            edge = (3 * edge / 4).max(MIN);
        }
        let bytes = bytes_of(edge);
        memory::check("the multiple-scattering field", space.bytes() + bytes, limit)?;
        Ok(Fitting { cells: edge, bytes })
    }

    /// Cells of the dust, at most `most` along an edge.
    pub fn cells(&self, most: usize) -> SweepCells {
        SweepCells::new(self.dust, self.draft.space.gas(), most)
    }

    /// The lattice of those cells.
    pub fn lattice(&self, most: usize) -> Lattice {
        SweepCells::lattice(self.dust, self.draft.space.gas(), most)
    }

    /// The highest degree that any phase function still has something of: moments of the light above it scatter into
    /// nothing.
    pub fn kept_degree(&self, fineness: Fineness) -> usize {
        // What so few directions tell apart.
        let most = fineness.degree.min(if fineness.directions[1] > 2 { DEGREE } else { 2 });
        let has = |l: usize| self.terms.iter().any(|term| term.legendre[l].abs() > NEGLIGIBLE);
        (0..=most).rev().find(|l| has(*l)).unwrap_or(0)
    }
}

/// The strongest weight of any extended light of a draft.
fn unit(draft: &Draft) -> f32 {
    let weights = |light| draft.spectral.bands.iter().flat_map(move |b: &BandPlan| b.rule.form.decay().weights(light)).copied();
    let extended = draft.lights.iter().enumerate().filter(|(_, l)| !matches!(l.route, Route::Direct { .. } | Route::FieldStar { .. }));
    let unit = extended.flat_map(|(light, _)| weights(light)).fold(f64::MIN_POSITIVE, |most, w| most.max(w.abs()));
    (unit as f32).max(f32::MIN_POSITIVE)
}

/// Moments of a phase function that do not grow when they scatter: nine directions a face make up to a tenth too much
/// of harmonics above the second degree.
fn stable(mut legendre: [f64; ALL_DEGREES + 1]) -> [f64; ALL_DEGREES + 1] {
    legendre.iter_mut().skip(3).for_each(|p| *p = p.clamp(-0.9, 0.9));
    legendre
}

/// The nodes of a passband.
///
/// # Errors
/// For rules that have none.
pub fn nodes(band: &BandPlan) -> Result<&[Node]> {
    band.nodes().ok_or_else(|| Error::OneBounce("this spectral method".into(), "a method of nodes such as band_quadrature"))
}

//! Problem of multiple scattering: a draft of a plan, and its passbands' nodes as media.

use spectra::rule::Node;

use super::Fineness;
use super::cells::SweepCells;
use super::harmonics::{DEGREE, count, legendre_moments};
use super::lanes::WIDTH;
use super::moments::Moments;
use super::processor::Sweepers;
use super::term::Term;
use crate::error::{Error, Result};
use crate::field::Grid;
use crate::memory;
use crate::plan::BandPlan;
use crate::plan::draft::Draft;

/// Fewest cells along the longest edge that are worth it.
const MIN: usize = 12;
/// Moments of the phase function that are none.
const NEGLIGIBLE: f64 = 0.02;

/// The problem that a field is the solution of.
pub struct Problem<'a> {
    pub draft: &'a Draft<'a>,
    /// The dust that scatters light.
    pub dust: &'a Grid,
    /// The nodes of all passbands.
    pub terms: Vec<Term>,
    pub sweepers: Sweepers<'a>,
}

/// The cells that there is memory for.
pub struct Fitting {
    pub cells: SweepCells,
    /// The bytes of all that is made in them.
    pub bytes: u64,
    /// True if they are fewer than they should be, to keep to the memory limit.
    pub coarser: bool,
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
        Ok(Some(Self { draft, dust, terms, sweepers: Sweepers::new(draft.options.sweeper.as_deref()) }))
    }

    /// True if light scatters more than once.
    pub fn scatters_again(&self) -> bool {
        self.draft.scene.method.bounces > 1
    }

    /// As many cells as `fineness` says, or as the memory limit lets be.
    ///
    /// # Errors
    /// If even the fewest do not fit.
    pub fn fitting(&self, fineness: Fineness) -> Result<Fitting> {
        let Draft { options, space, .. } = self.draft;
        let harmonics = count(self.kept_degree(fineness));
        let parts = self.terms.len().div_ceil(WIDTH) as u64;
        // All orders of each part, two orders of one where it is swept, what the march reads, and that as it is
        // gathered.
        let orders = if self.scatters_again() { 2 + parts } else { 0 };
        let gathered = if space.many_lights.is_some() { 2 * parts } else { 0 };
        let bytes_of = |cells: &SweepCells| {
            let count = cells.lattice.cells();
            let field = Moments::bytes(count, harmonics).saturating_mul(orders).saturating_add(4 * (count * self.terms.len()) as u64);
            let glow = if space.gas().is_empty() { 0 } else { Moments::bytes(count, 1) };
            // A quarter more for the halves beside it.
            (field + glow) / 4 * 5 + Moments::bytes(count, 1) * gathered
        };
        let limit = options.memory_limit;
        let mut edge = fineness.cells;
        let mut cells = self.cells(edge);
        while bytes_of(&cells) > limit.saturating_sub(space.bytes()) && edge > MIN {
            edge = (3 * edge / 4).max(MIN);
            cells = self.cells(edge);
        }
        let bytes = bytes_of(&cells);
        memory::check("the multiple-scattering field", space.bytes() + bytes, limit)?;
        Ok(Fitting { cells, bytes, coarser: edge < fineness.cells })
    }

    /// Cells of the dust, at most `most` along an edge.
    pub fn cells(&self, most: usize) -> SweepCells {
        SweepCells::new(self.dust, self.draft.space.gas(), most)
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

/// Moments of a phase function that do not grow when they scatter: nine directions a face make up to a tenth too much
/// of harmonics above the second degree.
fn stable(mut legendre: [f64; DEGREE + 1]) -> [f64; DEGREE + 1] {
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

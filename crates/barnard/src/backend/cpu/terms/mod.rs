//! How terms fall with optical depth, for sixteen rays: the forms of `spectra::rule` in f32, one file each.
//!
//! A term t of light s adds base · ⟨D_st⟩ in a segment, base being scattering or emission times the term's weight, ⟨D⟩
//! the mean of its decay over the segment's depths.

mod analytic;
mod common_nodes;
mod lookup;
mod nodes;
mod preintegrated;
mod projection;
mod sampled;

use spectra::rule::Form;
use spectra::simd;

use crate::packet::{LANES, Lane, lanes};
use crate::plan::{Plan, Weights};

pub use analytic::AnalyticTerms;
pub use common_nodes::CommonTerms;
pub use lookup::LookupTerms;
pub use nodes::NodeTerms;
pub use preintegrated::PreintegratedTerms;
pub use projection::{CoordinateTable, ProjectionTerms};
pub use sampled::{Drawn, SampledTerms};

/// Depths of a segment on each ray: linear between middle − half and middle + half [1].
pub struct DepthSpan {
    /// The mean of the depths at both ends.
    pub middle: Lane,
    /// Half the difference of the depths at both ends.
    pub half: Lane,
}

/// Factor of the decay of each term.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub enum Bases<'a> {
    /// Common factor of all terms, multiplied by their weights.
    Weighted(&'a Lane, &'a [f32]),
    /// A base for each term.
    Each(&'a [Lane]),
    /// A base for each of some terms, and which these are.
    Some(&'a [Lane], &'a [bool]),
}

impl Bases<'_> {
    /// The base of a term; none where it adds nothing.
    #[inline(always)]
    fn of(self, term: usize) -> Option<Lane> {
        match self {
            Bases::Weighted(_, weights) if weights[term] == 0.0 => None,
            Bases::Weighted(base, weights) => Some(lanes!(|lane| base[lane] * weights[term])),
            Bases::Some(_, terms) if !terms[term] => None,
            Bases::Each(bases) | Bases::Some(bases, _) => Some(bases[term]),
        }
    }
}

/// The terms of all bands, in one form.
#[derive(Debug)]
#[non_exhaustive]
pub enum Terms {
    /// Exponentials at nodes in k.
    Nodes(NodeTerms),
    /// Exponentials at nodes in k that all bands share.
    CommonNodes(CommonTerms),
    /// Tables of ln F over depth.
    Lookup(LookupTerms),
    /// Closed forms by exponential integrals.
    Analytic(AnalyticTerms),
    /// Coordinates in a common basis.
    Projection(ProjectionTerms),
    /// Intervals of λ, each with a table over a segment.
    Preintegrated(PreintegratedTerms),
    /// Wavelengths drawn at random for each ray.
    Sampled(SampledTerms),
}

impl Terms {
    /// The terms of `plan`, whose bands are all solved by one rule.
    pub fn new(plan: &Plan, weights: &Weights) -> Self {
        match plan.spectral.bands.first().map(|b| &b.rule.form) {
            Some(Form::Nodes(_)) | None => Terms::Nodes(NodeTerms::new(plan)),
            Some(Form::CommonNodes(_)) => Terms::CommonNodes(CommonTerms::new(plan, weights)),
            Some(Form::Lookup(_)) => Terms::Lookup(LookupTerms::new(plan)),
            Some(Form::Analytic(_)) => Terms::Analytic(AnalyticTerms::new(plan)),
            Some(Form::Projection(_)) => Terms::Projection(ProjectionTerms::new(plan)),
            Some(Form::Preintegrated(_)) => Terms::Preintegrated(PreintegratedTerms::new(plan)),
            Some(Form::Sampled(_)) => Terms::Sampled(SampledTerms::new(plan)),
        }
    }

    /// The exponentials of the terms, where they are that.
    pub fn exponentials(&self) -> Option<&NodeTerms> {
        match self {
            Terms::Nodes(nodes) => Some(nodes),
            Terms::CommonNodes(common) => Some(&common.nodes),
            _ => None,
        }
    }

    /// Number of sums per ray for a number of terms.
    pub fn sums(&self, terms: usize) -> usize {
        match self {
            Terms::CommonNodes(common) => common.sums(),
            _ => terms,
        }
    }

    /// Offset of the sums of a light.
    #[inline(always)]
    pub fn start(&self, light: usize) -> usize {
        match self {
            Terms::CommonNodes(common) => common.start(light),
            _ => 0,
        }
    }

    /// Whether terms fall alike for all lights and have one sum, so that lights behind the same depth may be added first.
    pub fn are_shared(&self) -> bool {
        matches!(self, Terms::Nodes(_) | Terms::Projection(_))
    }

    /// Draws the wavelengths of a packet's rays, whose numbers in the image seed them; nothing for rules without
    /// chance.
    pub fn draw(&self, numbers: &[u64; LANES]) -> Drawn {
        match self {
            Terms::Sampled(sampled) => sampled.draw(numbers),
            _ => Drawn::default(),
        }
    }

    /// Adds base · ⟨D⟩ to the sum of every term of `light` that has a base.
    pub fn accumulate(&self, light: usize, drawn: &Drawn, span: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        accumulate(self, light, drawn, span, bases, sum);
    }

    /// D of one term at one depth of one ray [1].
    pub fn at(&self, light: usize, drawn: &Drawn, lane: usize, term: usize, depth: f32) -> f32 {
        match self {
            Terms::Nodes(nodes) => nodes.at(term, depth),
            Terms::CommonNodes(common) => common.nodes.at(term, depth),
            Terms::Lookup(lookup) => lookup.at(light, term, depth),
            Terms::Analytic(analytic) => analytic.at(light, term, depth),
            Terms::Projection(projection) => projection.at(term, depth),
            Terms::Preintegrated(preintegrated) => preintegrated.at(term, depth),
            Terms::Sampled(_) => drawn.at(light, lane, term, depth),
        }
    }
}

simd! {
    fn accumulate(terms: &Terms, light: usize, drawn: &Drawn, span: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        match terms {
            Terms::Nodes(nodes) => nodes.accumulate(span, bases, sum),
            Terms::CommonNodes(common) => common.accumulate(light, span, bases, sum),
            Terms::Lookup(lookup) => lookup.accumulate(light, span, bases, sum),
            Terms::Analytic(analytic) => analytic.accumulate(light, span, bases, sum),
            Terms::Projection(projection) => projection.accumulate(span, bases, sum),
            Terms::Preintegrated(preintegrated) => preintegrated.accumulate(light, span, bases, sum),
            Terms::Sampled(_) => drawn.accumulate(light, span, bases, sum),
        }
    }
}

//! Error of the aggregated starlight on cells and kernels, relative to that of each star with exact depths
//! and the phase function itself, at places in the dust.

use glam::DVec3;
use rayon::prelude::*;

use super::cells::SweepCells;
use super::eye_source::trilinear;
use super::field::Field as ScatteredField;
use super::lanes::WIDTH;
use super::moments::Moments;
use super::view::Viewpoint;
use crate::control::Control;
use crate::error::Result;
use crate::field::Field;
use crate::phase::Phase;
use crate::plan::draft::Draft;
use crate::plan::many_lights::near_field_kernel::{PROFILE, Profile, depth_within};
use crate::plan::{ManyLights, SpatialPlan};
use crate::random::Counter;

/// Places that are looked at, fewer where there are more stars than `DEPTHS` together allow, and how many at least.
const PLACES: usize = 256;
const DEPTHS: usize = 500_000;
const MIN: usize = 24;
const SEED: u64 = 0x6361_6c6d;

/// A place in the dust.
struct SpotCheck {
    place: DVec3,
    /// The extinction σ at V there [pc⁻¹].
    sigma: f64,
    /// Exact depths at V from the gathered stars, in their order [1].
    depths: Vec<f64>,
}

/// Sums of differences and of what is exact.
#[derive(Debug, Clone, Copy)]
struct Deviation {
    wrong: f64,
    all: f64,
}

impl Deviation {
    /// The sum of all differences over that of all exact values; none where nothing was compared.
    fn part(deviations: &[Self]) -> Option<f64> {
        let sum = |quantity: fn(&Self) -> f64| deviations.iter().map(quantity).sum::<f64>();
        let all = sum(|d| d.all);
        (all > 0.0).then(|| sum(|d| d.wrong) / all)
    }
}

/// The first light of the gathered stars as the march has it, towards one eye.
pub struct FirstLight<'a> {
    pub field: &'a ScatteredField,
    /// The far field in cells, part by part.
    pub far: &'a [Moments],
    /// Depths towards the eye near each star.
    pub near: &'a [Profile],
    pub view: Viewpoint,
}

/// The mean difference of `light` from the exact one, in parts of its mean; none where nothing was compared.
///
/// # Errors
/// On interruption by the user.
pub fn error(light: &FirstLight, draft: &Draft, control: &Control) -> Result<Option<f64>> {
    let (Some(many_lights), Some(dust)) = (&light.field.many_lights, &draft.scene.dust) else { return Ok(None) };
    let spot_checks = spot_checks(many_lights, &draft.space, &light.field.finest().cells, control)?;
    let deviations: Vec<Deviation> = spot_checks.par_iter().map(|check| check.deviation(light, many_lights, &*dust.phase)).collect();
    Ok(Deviation::part(&deviations))
}

/// Places by chance, as often as there is dust.
fn spot_checks(many_lights: &ManyLights, space: &SpatialPlan, cells: &SweepCells, control: &Control) -> Result<Vec<SpotCheck>> {
    let Some(dust) = &space.dust else { return Ok(Vec::new()) };
    let mut sum = 0.0;
    let cumulated: Vec<f64> = cells
        .sigma
        .iter()
        .map(|sigma| {
            sum += f64::from(*sigma);
            sum
        })
        .collect();
    let count = (DEPTHS / many_lights.stars.len().max(1)).clamp(MIN, PLACES);
    let spot_check = |i: usize| -> Result<Option<SpotCheck>> {
        control.check()?;
        let mut chance = Counter::new(SEED, i as u64);
        let at = chance.uniform() * sum;
        let cell = cumulated.partition_point(|c| *c <= at).min(cumulated.len() - 1);
        let [x, y, z] = cells.lattice.place(cell);
        let within = DVec3::new(chance.uniform(), chance.uniform(), chance.uniform()) - 0.5;
        let place = cells.lattice.centre(x, y, z) + within * cells.lattice.voxel_pc();
        let sigma = dust.at(place);
        let depths = || many_lights.places.iter().map(|star| space.depth(*star, place)).collect();
        Ok((sigma > 0.0).then(|| SpotCheck { place, sigma, depths: depths() }))
    };
    let spot_checks: Vec<Option<SpotCheck>> = (0..count).into_par_iter().map(spot_check).collect::<Result<_>>()?;
    Ok(spot_checks.into_iter().flatten().collect())
}

impl SpotCheck {
    /// Source functions towards the eye, those of the march against the exact ones, of all terms.
    fn deviation(&self, light: &FirstLight, many_lights: &ManyLights, phase: &dyn Phase) -> Deviation {
        let mut deviation = Deviation { wrong: 0.0, all: 0.0 };
        let FirstLight { field, far, near: profiles, view } = light;
        for (part, far) in field.parts.iter().zip(*far) {
            let mut found = trilinear(&field.finest().cells.lattice, &far.data, self.place).map(f64::from);
            let mut exact = [0.0; WIDTH];
            for (star, sent) in part.sent.iter().enumerate() {
                let offset = self.place - many_lights.places[star];
                let square = offset.length_squared().max(f64::MIN_POSITIVE);
                let cosine = offset.normalize_or(DVec3::Z).dot(view.towards(self.place));
                let kernel = &field.kernels[star];
                let step = PROFILE as f64 / kernel.ahead_pc;
                let mean = 0.5 * (many_lights.sigma[star] + self.sigma as f32);
                let depth = f64::from(depth_within(&profiles[star], step as f32, mean, square.sqrt() as f32, cosine as f32));
                let near = kernel.share(square, cosine);
                for (t, term) in part.terms.iter().enumerate() {
                    let scattered = f64::from(sent[t]) * term.albedo * phase.at(cosine, term.lambda_um) / square;
                    exact[t] += scattered * (-term.k * self.depths[star]).exp();
                    if near > 0.0 {
                        found[t] += near * scattered * (-term.k * depth).exp();
                    }
                }
            }
            let unit = f64::from(field.unit);
            deviation.wrong += unit * found.iter().zip(&exact).map(|(f, e)| (f - e).abs()).sum::<f64>();
            deviation.all += unit * exact.iter().sum::<f64>();
        }
        deviation
    }
}

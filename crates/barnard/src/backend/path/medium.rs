//! Free flights through dust.
//!
//! Collisions are drawn at the rate of the majorant μ and are real with the chance σ/(σ + |μ − σ|); where σ passes μ,
//! the weight (σ + |μ − σ|)/μ and its sign keep the mean right (Galtier et al. 2013, JQSRT 125, 57). Transmittances are
//! products of 1 − σ/μ at such collisions (ratio tracking, Novák, Selle & Jarosz 2014). Depths are at V: wavelength λ
//! sees k(λ) times as much.

use super::majorant::Majorant;
use super::sampled_wavelengths::CARRIED;
use crate::backend::seen_detail::SeenDetail;
use crate::control::Control;
use crate::error::Result;
use crate::field::Field;
use crate::geometry::Ray;
use crate::random::Counter;
use crate::scene::Dust;

/// Dust with its majorant.
pub struct Medium<'a> {
    /// The dust itself.
    pub dust: &'a Dust,
    majorant: Majorant,
    /// Its detail below the voxel size, as seen by the eyes.
    detail: Option<&'a SeenDetail>,
}

/// A leg of a path.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    /// Direction of flight.
    pub ray: Ray,
    /// True if it begins at the eye, which sees detail; light between two scatterings, and that of stars, does not.
    pub from_eye: bool,
}

impl Leg {
    /// The density that is seen at a distance \[pc\].
    pub fn density(&self, density: &dyn Field, detail: Option<&SeenDetail>, t: f64) -> f64 {
        let seen = detail.filter(|_| self.from_eye);
        density.at(seen.map_or_else(|| self.ray.at(t), |detail| detail.place(&self.ray, t, &density.bounds())))
    }
}

/// One flight of a path through the dust.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    /// The distance of the collision [pc]; none where the path left the medium.
    pub collision: Option<f64>,
    /// ∫μ dt up to there [1, at V].
    pub bound_depth: f64,
    /// Collisions on the way, null ones and the last.
    pub tentative: i32,
    /// The factor by which the flight changes the path's weight.
    pub weight: f64,
}

/// Transmittances below this are ended by chance.
const FAINT: f64 = 0.1;

/// A length in units of the mean free path.
fn exponential(random: &mut Counter) -> f64 {
    -(1.0 - random.uniform()).ln()
}

impl<'a> Medium<'a> {
    /// Prepares flights through `dust`.
    ///
    /// # Errors
    /// If it has no bound, and on interruption by the user.
    pub fn new(dust: &'a Dust, detail: Option<&'a SeenDetail>, control: &Control) -> Result<Self> {
        Ok(Self { dust, majorant: Majorant::new(&*dust.density, control)?, detail })
    }

    /// Extinction at V at a distance along a leg [pc⁻¹].
    pub fn sigma(&self, leg: &Leg, t: f64) -> f64 {
        self.dust.sigma_v_per_pc * leg.density(&*self.dust.density, self.detail, t).max(0.0)
    }

    /// The bounds along a leg, of extinction at V [pc⁻¹].
    fn cells(&self, leg: &Leg, far: f64) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let most = self.dust.sigma_v_per_pc;
        self.majorant.cells(&leg.ray, far).map(move |(start, end, bound)| (start, end, most * bound))
    }

    /// Flies along `leg` at the wavelength of `k` until it collides or leaves.
    pub fn fly(&self, leg: &Leg, k: f64, random: &mut Counter) -> Flight {
        let mut flight = Flight { collision: None, bound_depth: 0.0, tentative: 0, weight: 1.0 };
        let mut left = exponential(random) / k;
        for (mut t, end, bound) in self.cells(leg, f64::INFINITY) {
            while bound * (end - t) > left {
                t += left / bound;
                flight.bound_depth += left;
                flight.tentative += 1;
                left = exponential(random) / k;
                let sigma = self.sigma(leg, t);
                let null = bound - sigma;
                let all = sigma + null.abs();
                if random.uniform() * all < sigma {
                    flight.weight *= all / bound;
                    flight.collision = Some(t);
                    return flight;
                }
                flight.weight *= null.signum() * all / bound;
            }
            left -= bound * (end - t);
            flight.bound_depth += bound * (end - t);
        }
        flight
    }

    /// Estimates e^(−k τ) up to `far` at several wavelengths at once, without bias.
    pub fn transmittances(&self, leg: &Leg, far: f64, k: &[f64; CARRIED], random: &mut Counter) -> [f64; CARRIED] {
        let fastest = k.iter().copied().fold(0.0, f64::max);
        let mut through = [1.0; CARRIED];
        let mut left = exponential(random) / fastest;
        for (mut t, end, bound) in self.cells(leg, far) {
            while bound * (end - t) > left {
                t += left / bound;
                left = exponential(random) / fastest;
                let part = self.sigma(leg, t) / (fastest * bound);
                through.iter_mut().zip(k).for_each(|(through, k)| *through *= 1.0 - k * part);
                // What hardly comes through is ended by chance; the rest counts more.
                let largest = through.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
                if largest < FAINT {
                    if random.uniform() * FAINT >= largest {
                        return [0.0; CARRIED];
                    }
                    through.iter_mut().for_each(|t| *t *= FAINT / largest);
                }
            }
            left -= bound * (end - t);
        }
        through
    }

    /// Start and end of the dust along a ray [pc].
    pub fn extent(&self, ray: &Ray) -> Option<(f64, f64)> {
        self.dust.density.bounds().clip(ray)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::field::{Grid, Lattice};
    use crate::fixtures;
    use crate::geometry::Bounds;

    fn dust() -> Dust {
        let lattice = Lattice { dims: [12; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let density = Grid::sampled(lattice, |p| (4.0 * p.x * p.y - p.z).sin().max(0.0));
        fixtures::dust(density, "inverse_wavelength", 5.0)
    }

    /// Flights leave, and transmittances are, e^(−k τ) in the mean, by bounds that hold and by bounds that are exceeded
    /// fourfold.
    #[test]
    fn free_flights_are_unbiased() {
        let dust = dust();
        let ray = Ray::between(DVec3::new(-2.0, 0.4, -0.9), DVec3::new(0.3, -0.2, 0.1)).0;
        let leg = Leg { ray, from_eye: false };
        let k = [0.7, 1.0, 1.3, 2.0];
        let tau = dust.sigma_v_per_pc * dust.density.grid().unwrap().column(ray.at(0.0), ray.at(10.0), f64::INFINITY);
        assert!((0.5..3.0).contains(&tau), "{tau}");
        for tightness in [1.0, 0.25] {
            let mut medium = Medium::new(&dust, None, &Control::default()).unwrap();
            medium.majorant = medium.majorant.scaled(tightness);
            let (mut escaped, mut through) = (super::super::Estimate::default(), [super::super::Estimate::default(); CARRIED]);
            for i in 0..40_000 {
                let mut random = Counter::nested(3, 1, i);
                let flight = medium.fly(&leg, 1.3, &mut random);
                escaped.add(if flight.collision.is_none() { flight.weight } else { 0.0 });
                let drawn = medium.transmittances(&leg, f64::INFINITY, &k, &mut random);
                through.iter_mut().zip(drawn).for_each(|(t, d)| t.add(d));
            }
            for (estimate, k) in through.iter().zip(k).chain([(&escaped, 1.3)]) {
                let truth = (-k * tau).exp();
                assert!((estimate.mean - truth).abs() < 4.0 * estimate.error(), "{k}, {tightness}: {estimate:?} {truth}");
                assert!(
                    estimate.error() < 0.2 * truth && (estimate.mean - 1.2 * truth).abs() > estimate.error(),
                    "{k}: {estimate:?} {truth}"
                );
            }
        }
    }
}

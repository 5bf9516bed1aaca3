//! Gas that moves: its lines are seen at other wavelengths.
//!
//! Light of gas that recedes with velocity v along the line of sight has λ = λ₀ (1 + v/c). A species becomes several of rest, one for
//! each of the velocities v₀, v₀ + Δ, ..., of densities
//!
//!   n_k(x) = n(x) max(0, 1 − |v(x) − v_k|/Δ),
//!
//! so that gas between two velocities shines in both, nearer to the nearer, and no light is lost: mean wavelengths are exact, and lines
//! are wider by at most Δ/2 (r.m.s. Δ √(u(1 − u)), u the part of the way between). What is slower than the first or faster than the last
//! shines with it. Continua stay where they are.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use spectra::units::Velocity;

use super::species::{Emission, Motion};
use crate::camera::{Camera, Projection};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::field::{Field, Grid, Lattice};
use crate::memory;

/// Most velocities: each is a density of its own.
const MAX_VELOCITIES: usize = 256;
/// Fewest and most voxels along the longest edge at which a function's density is sampled, by its features.
const VOXELS: (usize, usize) = (64, 192);
/// Places along each edge at which a function's velocities are looked up.
const PLACES: usize = 64;

/// From where gas is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Observer {
    Near(DVec3),
    Far(DVec3),
}

/// The component of a velocity away from whoever looks.
#[derive(Debug, Clone)]
struct Receding {
    motion: Motion,
    observer: Observer,
}

impl Receding {
    fn at(&self, p: DVec3) -> f64 {
        let velocity = DVec3::from(self.motion.components.each_ref().map(|component| component.at(p)));
        let away = match self.observer {
            Observer::Near(eye) => (p - eye).normalize_or_zero(),
            Observer::Far(forward) => forward,
        };
        velocity.dot(away)
    }
}

/// Velocities in equal steps.
#[derive(Debug, Clone, Copy, PartialEq)]
struct VelocitySteps {
    first: f64,
    step: f64,
    count: usize,
}

impl VelocitySteps {
    /// Those that a range needs.
    fn over((low, high): (f64, f64), step: f64) -> Result<Self> {
        let count = ((high - low) / step).ceil() + 1.0;
        if !(step > 0.0 && count <= MAX_VELOCITIES as f64) {
            let value = format!("{} for velocities of {low:.3} to {high:.3} km/s", Velocity(step));
            let least = Velocity((high - low) / (MAX_VELOCITIES - 2) as f64);
            return Err(Error::out_of_range("velocity_step", value, format!("at least {least}, for at most {MAX_VELOCITIES} steps")));
        }
        let count = count as usize;
        Ok(Self { first: 0.5 * (low + high) - 0.5 * (count - 1) as f64 * step, step, count })
    }

    fn at(&self, number: usize) -> f64 {
        self.first + number as f64 * self.step
    }

    /// The lower of the two that a velocity lies between, and the part of the way to the next.
    fn place(&self, velocity: f64) -> (usize, f64) {
        let place = ((velocity - self.first) / self.step).clamp(0.0, (self.count - 1) as f64);
        let lower = (place as usize).min(self.count.saturating_sub(2));
        (lower, if self.count == 1 { 0.0 } else { place - lower as f64 })
    }
}

impl Emission {
    /// The species as a camera sees it: several if the gas moves and has lines, one for each velocity.
    ///
    /// # Errors
    /// If velocities are no numbers or too many, their grids would take more than `memory_limit` bytes, or on interruption by the user.
    pub(super) fn shifted(&self, camera: &Camera, memory_limit: u64, control: &Control) -> Result<Vec<Self>> {
        let Self { name, density, spectrum, motion } = self;
        let Some(motion) = motion.as_ref().filter(|_| !spectrum.lines().is_empty()) else {
            return Ok(vec![Self { motion: None, ..self.clone() }]);
        };
        let observer = match camera.projection {
            Projection::Orthographic { .. } => Observer::Far(camera.forward),
            Projection::Perspective { .. } | Projection::Panorama { .. } => Observer::Near(camera.position),
        };
        let receding = Arc::new(Receding { motion: motion.clone(), observer });
        let steps = VelocitySteps::over(range(&**density, &receding)?, motion.step)?;
        let fields = match density.grid() {
            Some(grid) => sliced(grid, &receding, steps, memory_limit)?,
            // A function is sampled once, not for each velocity.
            None => {
                let finest = (density.bounds().size().max_element() / density.feature_pc()).ceil() as usize;
                let lattice = Lattice::along(density.bounds(), finest.clamp(VOXELS.0, VOXELS.1));
                sliced(&Grid::from_function(density, lattice, 1.0, None, control)?, &receding, steps, memory_limit)?
            }
        };
        let species = fields.into_iter().enumerate().filter_map(|(number, density)| {
            let velocity = steps.at(number);
            let name = format!("{name} at {velocity:+.1} km/s");
            Some(Self { name, density: density?, spectrum: spectrum.clone().shifted(Velocity(velocity)), motion: None })
        });
        Ok(species.collect())
    }
}

/// The slowest and the fastest of gas along the line of sight, where there is any.
fn range(density: &dyn Field, receding: &Receding) -> Result<(f64, f64)> {
    let bounds = density.bounds();
    let dims = density.grid().map_or([PLACES; 3], |grid| grid.lattice().dims);
    let lattice = Lattice { dims, bounds: density.grid().map_or(bounds, |grid| grid.lattice().bounds) };
    let of_plane = |z: usize| {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for (x, y) in (0..dims[1]).flat_map(|y| (0..dims[0]).map(move |x| (x, y))) {
            let p = lattice.centre(x, y, z);
            if density.at(p) > 0.0 {
                let velocity = receding.at(p);
                if !velocity.is_finite() {
                    return Err(Error::out_of_range("velocity of gas", format!("{velocity} at {p:.3} pc"), "finite wherever there is gas"));
                }
                range = (range.0.min(velocity), range.1.max(velocity));
            }
        }
        Ok(range)
    };
    let planes: Vec<(f64, f64)> = (0..dims[2]).into_par_iter().map(of_plane).collect::<Result<_>>()?;
    let all = planes
        .into_iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |all, plane_range| (all.0.min(plane_range.0), all.1.max(plane_range.1)));
    Ok(if all.0 > all.1 { (0.0, 0.0) } else { all })
}

/// The grids of all velocities; none where there is no gas of one.
fn sliced(grid: &Grid, receding: &Receding, steps: VelocitySteps, memory_limit: u64) -> Result<Vec<Option<Arc<dyn Field>>>> {
    let (lattice, values) = (grid.lattice(), grid.values());
    let bytes = 4 * lattice.cells() as u64 * steps.count as u64;
    memory::check(&format!("gas of {} velocities", steps.count), bytes, memory_limit)?;
    let places: Vec<(u16, f32)> = (0..lattice.cells())
        .into_par_iter()
        .map(|i| {
            let [x, y, z] = lattice.place(i);
            let velocity = if values[i] > 0.0 { receding.at(lattice.centre(x, y, z)) } else { steps.first };
            let (lower, part) = steps.place(velocity);
            (lower as u16, part as f32)
        })
        .collect();
    let slice = |number: usize| {
        let share = |(value, (lower, part)): (&f32, &(u16, f32))| match number {
            _ if number == usize::from(*lower) => value * (1.0 - part),
            _ if number == usize::from(*lower) + 1 => value * part,
            _ => 0.0,
        };
        let slice_values: Vec<f32> = values.par_iter().zip(&places).map(share).collect();
        let is_empty = slice_values.par_iter().all(|value| *value == 0.0);
        Ok((!is_empty)
            .then(|| Grid::new(lattice.dims, lattice.bounds, slice_values))
            .transpose()?
            .map(|slice| Arc::new(slice.with_front_of(grid)) as Arc<dyn Field>))
    };
    (0..steps.count).map(slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Sphere;
    use crate::geometry::Bounds;
    use spectra::spectrum::{Line, Spectrum};

    /// A field that is a function of place everywhere.
    #[derive(Debug)]
    struct Linear(DVec3);
    impl Field for Linear {
        fn at(&self, p: DVec3) -> f64 {
            self.0.dot(p)
        }
        fn bounds(&self) -> Bounds {
            Bounds::cube(DVec3::ZERO, 1e9)
        }
    }

    fn expansion(km_s_pc: f64, step: f64) -> Motion {
        Motion { components: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| Arc::new(Linear(km_s_pc * axis)) as Arc<dyn Field>), step }
    }

    fn ball(as_grid: bool) -> Emission {
        let spectrum = Spectrum::of_lines(vec![Line { lambda_um: 0.5, strength: 1.0 }]);
        let sphere = Sphere::new(DVec3::ZERO, 1.0).unwrap();
        if !as_grid {
            return Emission::new(sphere, spectrum);
        }
        let lattice = Lattice { dims: [32; 3], bounds: Bounds::cube(DVec3::ZERO, 1.0) };
        let values = (0..lattice.cells())
            .map(|i| {
                let [x, y, z] = lattice.place(i);
                sphere.at(lattice.centre(x, y, z)) as f32
            })
            .collect();
        Emission::new(Grid::new(lattice.dims, lattice.bounds, values).unwrap(), spectrum)
    }

    /// Everywhere all parts together are the gas, their mean velocity is its own, and a part shines where it belongs.
    #[test]
    fn parts_are_the_whole() {
        let camera = Camera::look_at(DVec3::new(0.0, 0.0, 1e4), DVec3::ZERO).with_orthographic_pc(3.0);
        for as_grid in [false, true] {
            let whole = ball(as_grid);
            let parts = whole.clone().with_motion(expansion(20.0, 3.0)).shifted(&camera, 1 << 30, &Control::default()).unwrap();
            assert!((14..=16).contains(&parts.len()), "{}", parts.len());
            // A function that is sampled has soft edges, and neighbours between centres of voxels.
            let (inner, most) = if as_grid { (0..32, 2) } else { (2..30, 4) };
            for i in inner {
                // Centres of voxels, where grids are their values.
                let p = DVec3::new(0.031_25, 0.093_75, (f64::from(i) + 0.5) / 16.0 - 1.0);
                let densities: Vec<f64> = parts.iter().map(|part| part.density.at(p)).collect();
                let (sum, density) = (densities.iter().sum::<f64>(), whole.density.at(p));
                assert!((sum - density).abs() < 1e-6, "{i}: {sum} {density}");
                // The camera looks down z: what is near it comes closer.
                let shift = |part: &Emission| (part.spectrum.lines()[0].lambda_um / 0.5 - 1.0) * 299_792.458;
                let mean = parts.iter().zip(&densities).map(|(part, density)| density * shift(part)).sum::<f64>();
                assert!((mean - density * -20.0 * p.z).abs() < 1e-4 * density.max(1e-9), "{i}: {mean}");
                assert!(densities.iter().filter(|density| **density > 0.0).count() <= most);
            }
        }
        // From near by, away is away from the eye: gas at rest in a frame that recedes from it does so on all sides.
        let near = Camera::look_at(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO);
        let away = ball(true).with_motion(expansion(1.0, 0.5)).shifted(&near, 1 << 30, &Control::default()).unwrap();
        assert!(away.len() > 3);
    }

    #[test]
    fn too_many_velocities_are_refused() {
        let camera = Camera::look_at(DVec3::new(0.0, 0.0, 1e4), DVec3::ZERO).with_orthographic_pc(3.0);
        let message = ball(true).with_motion(expansion(1e4, 1.0)).shifted(&camera, 1 << 40, &Control::default()).unwrap_err().to_string();
        assert!(message.contains("velocity_step") && message.contains("at least"), "{message}");
        assert!(
            ball(true)
                .with_motion(expansion(20.0, 1.0))
                .shifted(&camera, 1 << 20, &Control::default())
                .unwrap_err()
                .to_string()
                .contains("velocities")
        );
        assert!(ball(true).with_motion(expansion(f64::NAN, 1.0)).shifted(&camera, 1 << 30, &Control::default()).is_err());
        // Gas at rest stays one species, and a continuum has no lines to move.
        assert_eq!(ball(true).with_motion(expansion(0.0, 1.0)).shifted(&camera, 1 << 30, &Control::default()).unwrap().len(), 1);
    }

    /// Steps that are not above zero, or too many, are refused.
    #[test]
    fn steps_are_above_zero() {
        for step in [0.0, -0.1, -5.0, f64::NAN, 1e-9] {
            assert!(VelocitySteps::over((0.0, 1.0), step).is_err(), "{step}");
        }
        assert_eq!(VelocitySteps::over((0.0, 1.0), 0.5).unwrap().count, 3);
        assert_eq!(VelocitySteps::over((2.0, 2.0), 0.5).unwrap().count, 1);
    }
}

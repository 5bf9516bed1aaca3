//! A dense clump beside a star, in hydrogen of one temperature.

use glam::DVec3;
use ionisation::balance::{Diffuse, Gas, GasState};
use ionisation::cloud::{Cloud, Quantity, Settings, Star};
use ionisation::light::IonisingLight;

use super::chance::{Follow, Source, neutral};

/// The half of an edge \[pc\].
pub const HALF_PC: f64 = 2.0;
/// The temperature of the gas \[K\].
const TEMPERATURE: f64 = 8000.0;
/// The star, and the radius of the clump in the middle \[pc\].
const STAR: Source = Source { place: DVec3::new(-1.3, 0.02, 0.03), temperature: 40_000.0, photons: 4e48 };
const RADIUS_PC: f64 = 0.35;

/// The clump.
pub struct Clump {
    edge: usize,
    hydrogen: Vec<f32>,
}

impl Clump {
    /// 30 nuclei in a cm³, and 3000 in the clump, on so many voxels along an edge.
    pub fn new(edge: usize) -> Self {
        let clump = Self { edge, hydrogen: Vec::new() };
        let density = |i: usize| if clump.place(i).length() < RADIUS_PC { 3000.0 } else { 30.0 };
        Self { hydrogen: (0..edge.pow(3)).map(density).collect(), ..clump }
    }

    /// The middle of a voxel \[pc\].
    fn place(&self, voxel: usize) -> DVec3 {
        let at = [voxel % self.edge, voxel / self.edge % self.edge, voxel / self.edge / self.edge].map(|i| i as f64);
        (DVec3::from(at) + 0.5) * (2.0 * HALF_PC / self.edge as f64) - HALF_PC
    }

    fn cloud(&self) -> Cloud<'_> {
        let voxel = DVec3::splat(2.0 * HALF_PC / self.edge as f64);
        let abundances = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        Cloud { dims: [self.edge; 3], low: DVec3::splat(-HALF_PC), voxel, hydrogen: &self.hydrogen, abundances, dust_cm2: 0.0 }
    }

    /// Neutral parts as beams find them.
    pub fn by_beams(&self, diffuse: Diffuse) -> Vec<f64> {
        let light = IonisingLight::blackbody(STAR.temperature, STAR.photons);
        let ionised = |_: &Gas, state: &GasState| state.fractions[0][1];
        let settings = Settings { diffuse, isothermal: Some(TEMPERATURE), ..Settings::default() };
        let star = Star { place: STAR.place, light: &light };
        let asked = [Quantity { most: 1.0, value: &ionised }];
        let found = self.cloud().ionised(&[star], &settings, &asked, &|_, _| true).expect("a cloud");
        found.quantities[0].iter().map(|part| 1.0 - f64::from(*part)).collect()
    }

    /// Neutral parts as photons find them.
    pub fn by_chance(&self, is_diffuse: bool, photons: u64) -> Vec<f64> {
        let first = self.by_beams(Diffuse::OnTheSpot);
        neutral(&self.cloud(), &STAR, &Follow { temperature: TEMPERATURE, is_diffuse, photons, rounds: 30 }, first)
    }

    /// The ionised part of the gas that is well beside the clump and its shadow, and of that in the shadow.
    pub fn ionised(&self, neutral: &[f64]) -> [f64; 2] {
        let (mut ions, mut nuclei) = ([0.0; 2], [0.0; 2]);
        for (voxel, neutral) in neutral.iter().enumerate() {
            let hydrogen = f64::from(self.hydrogen[voxel]);
            for (region, is_there) in [self.is_lit(voxel), self.is_in_shadow(voxel)].into_iter().enumerate() {
                let share = if is_there { hydrogen } else { 0.0 };
                (ions[region], nuclei[region]) = (ions[region] + share * (1.0 - neutral), nuclei[region] + share);
            }
        }
        std::array::from_fn(|region| ions[region] / nuclei[region])
    }

    fn is_in_shadow(&self, voxel: usize) -> bool {
        let (along, beside) = self.beside_axis(voxel);
        along > STAR.place.length() + RADIUS_PC + 0.1 && beside < RADIUS_PC * along / STAR.place.length()
    }

    fn is_lit(&self, voxel: usize) -> bool {
        let (along, beside) = self.beside_axis(voxel);
        let is_beside_clump = self.place(voxel).length() > 1.5 * RADIUS_PC;
        is_beside_clump && (along < 0.0 || beside > 1.5 * RADIUS_PC * along / STAR.place.length())
    }

    /// Position of a voxel along the axis from the star through the clump, and its distance from that axis \[pc\].
    fn beside_axis(&self, voxel: usize) -> (f64, f64) {
        let (way, axis) = (self.place(voxel) - STAR.place, -STAR.place.normalize());
        let along = way.dot(axis);
        (along, (way - along * axis).length())
    }
}

//! How plates are made: one march of all lights where light scatters once, otherwise one of each light by itself.

use std::sync::Arc;

use rayon::prelude::*;
use spectra::components::Components;
use spectra::passband::{Counting, Passband, Window, window};
use spectra::rule::{Node, Rounding};
use spectra::sed::BlackBody;
use spectra::spectrum::Spectrum;
use spectra::units::{Temperature, Wavelength};

use super::{LEVELS, Plate, SHARE, phases};
use crate::backend::RenderStats;
use crate::backend::cpu::{self, Combined, combined};
use crate::control::Control;
use crate::error::Result;
use crate::light::{Route, law};
use crate::memory;
use crate::plan::{Options, Plan, Planner};
use crate::scene::{Background, Emission, Method, Scene, SceneSpec, Star};

/// The width of a passband that stands for one wavelength, as a part of it.
const NARROW: f64 = 1e-5;
/// Pixels that components are made of at first, those that are added where they are not enough, and how often.
const FIRST_PIXELS: usize = 2048;
const MORE_PIXELS: usize = 64;
const TRIES: usize = 6;

/// Inputs of plates.
pub(super) struct Work<'a> {
    pub scene: &'a Scene,
    pub nodes: &'a [Node],
    pub options: &'a Options,
    pub control: &'a Control,
}

impl Work<'_> {
    fn pixels(&self) -> usize {
        self.scene.camera.width * self.scene.camera.height
    }

    /// The error that components may have.
    fn accuracy(&self) -> f64 {
        SHARE * self.scene.method.accuracy
    }

    /// Rejects plates beyond the memory limit: working numbers per pixel, and stored ones of some lights.
    fn check(&self, singles: usize, lights: usize, components: usize) -> Result<()> {
        let of_pixel = 4 * singles + lights * (4 + 2 * components);
        memory::check("the plates", (self.pixels() * of_pixel) as u64, self.options.memory_limit)
    }

    /// Plates of lights that scatter once at most, all by one march of a plan whose passbands share their nodes.
    pub fn once(&self, plan: &Plan, lights: &[usize]) -> Result<(Vec<Plate>, RenderStats)> {
        let k: Vec<f64> = self.nodes.iter().map(|node| node.k).collect();
        let at_nodes = |phase: &super::PhaseFactor| self.nodes.iter().map(|node| phase(node.lambda_um)).collect();
        let factors: Vec<Vec<f64>> = phases(self.scene).iter().map(at_nodes).collect();
        let components = Components::of_exponentials(&k, plan.spectral().depth, &factors, self.accuracy());
        let rows = rows(&components);
        self.check(lights.len() * rows.len(), lights.len(), components.axes.len())?;
        let Combined { data, stats } = combined(plan, lights, &rows, self.control)?;
        let planes = data.chunks_exact(rows.len() * self.pixels());
        let plate = |(light, data): (&usize, &[f32])| {
            let route = plan.lights()[*light].route;
            stored(route, data, components.clone(), plan.rounding(route, stats.storage))
        };
        Ok((lights.iter().zip(planes).map(plate).collect(), stats))
    }

    /// Plates of lights that scatter more than once, each marched by itself at the wavelengths of all nodes.
    pub fn again(&self, plan: &Plan, lights: &[usize]) -> Result<(Vec<Plate>, RenderStats)> {
        let mut stats = RenderStats { depth: 0.0, ..RenderStats::of_rays(0) };
        let mut plates = Vec::new();
        self.check(2 * self.nodes.len(), lights.len(), self.nodes.len() / 2)?;
        for (number, light) in lights.iter().enumerate() {
            let route = plan.lights()[*light].route;
            let part = |i: usize| i as f64 / lights.len() as f64;
            let control = self.control.part(part(number), part(number + 1));
            let (left, found) = self.at_nodes(route, &control)?;
            let components = self.components(&left);
            let mut data = vec![0.0; (1 + components.axes.len()) * self.pixels()];
            for (row, out) in rows(&components).iter().zip(data.chunks_exact_mut(self.pixels())) {
                for (weight, node) in row.iter().zip(left.chunks_exact(self.pixels())) {
                    out.iter_mut().zip(node).for_each(|(out, value)| *out += weight * value);
                }
            }
            plates.push(stored(route, &data, components, plan.rounding(route, found.storage)));
            stats = stats.and(found);
        }
        Ok((plates, stats))
    }

    /// Transmitted light per node and pixel (node × pixel), relative to its emission at the wavelength.
    fn at_nodes(&self, route: Route, control: &Control) -> Result<(Vec<f32>, RenderStats)> {
        let (first, last) = law(self.scene)?.range_um();
        let narrow = |node: &Node| {
            let width = NARROW * node.lambda_um;
            let centre = node.lambda_um.clamp(first + width, last - width);
            let shape = Window::TopHat { centre: Wavelength(centre), width: Wavelength(width) };
            window(&format!("{:.6} um", node.lambda_um), Counting::Energy, shape)
        };
        let bands: Vec<Passband> = self.nodes.iter().map(narrow).collect::<spectra::Result<_>>()?;
        let method = Method { settings: Method::default().settings, exact_stars: None, ..self.scene.method.clone() };
        let light = alone(self.scene, route).with_bands(bands).with_method(method.with_name("fixed_wavelength")?).build()?;
        let plan = Planner::new(self.options).plan(&light, None, &control.part(0.0, 0.7))?;
        let (mut data, stats) = cpu::radiance(&plan, &control.part(0.7, 1.0))?;
        for (band, node) in plan.spectral().bands.iter().zip(data.chunks_exact_mut(self.pixels())) {
            let sent = band.sources[0].measure.total() as f32;
            node.iter_mut().for_each(|value| *value = if sent > 0.0 { *value / sent } else { 0.0 });
        }
        Ok((data, stats))
    }

    /// The components of a picture at all nodes: of some pixels, and of those in which they were not enough.
    fn components(&self, left: &[f32]) -> Components {
        let pixels = self.pixels();
        let bright: Vec<usize> = (0..pixels).filter(|pixel| left[*pixel] > 0.0).collect();
        let parts = |pixel: usize| -> Vec<f64> {
            let first = f64::from(left[pixel]);
            left[pixel..].iter().step_by(pixels).map(|value| f64::from(*value) / first).collect()
        };
        let mut chosen: Vec<Vec<f64>> =
            bright.iter().step_by(bright.len().div_ceil(FIRST_PIXELS).max(1)).map(|pixel| parts(*pixel)).collect();
        if chosen.is_empty() {
            chosen.push(vec![0.0; self.nodes.len()]);
        }
        for _ in 0..TRIES {
            let mut components = Components::of(&chosen, self.accuracy());
            let found = |pixel: &usize| {
                let parts = parts(*pixel);
                let coordinates = components.coordinates(&parts);
                (components.error_of(&parts, &coordinates), *pixel, coordinates)
            };
            let mut found: Vec<(f64, usize, Vec<f64>)> = bright.par_iter().map(found).collect();
            found.sort_by(|a, b| b.0.total_cmp(&a.0));
            for (_, _, coordinates) in &found {
                components.include(coordinates);
            }
            components.error = found.first().map_or(0.0, |worst| worst.0);
            if components.error <= self.accuracy() {
                return components;
            }
            chosen.extend(found.iter().take(MORE_PIXELS).map(|(_, pixel, _)| parts(*pixel)));
        }
        // As many as there are nodes are exact.
        let mut components = Components::of(&chosen, 0.0);
        bright.iter().for_each(|pixel| components.include(&components.coordinates(&parts(*pixel))));
        components
    }
}

/// Combinations of nodes that are stored: G(k_0), and G(k_0) times each coordinate.
fn rows(components: &Components) -> Vec<Vec<f32>> {
    let first: Vec<f32> = (0..components.mean.len()).map(|j| if j == 0 { 1.0 } else { 0.0 }).collect();
    let of_axis = |(t, axis): (usize, &Vec<f64>)| {
        let mut row: Vec<f32> = axis.iter().map(|v| *v as f32).collect();
        row[0] = (axis[0] - components.origin(t)) as f32;
        row
    };
    std::iter::once(first).chain(components.axes.iter().enumerate().map(of_axis)).collect()
}

/// A plate of combinations × pixels.
fn stored(route: Route, data: &[f32], components: Components, rounding: Rounding) -> Plate {
    let pixels = data.len() / (1 + components.axes.len());
    let level = data[..pixels].to_vec();
    let of_component = |([low, high], coordinates): (&[f64; 2], &[f32])| {
        let (low, scale) = (*low as f32, if high > low { LEVELS / (high - low) as f32 } else { 0.0 });
        let number = |(radiance, level): (&f32, &f32)| {
            let coordinate = if *level > 0.0 { radiance / level } else { 0.0 };
            ((coordinate - low) * scale + 0.5).clamp(0.0, LEVELS) as u16
        };
        coordinates.iter().zip(&level).map(number).collect()
    };
    let coordinates = components.ranges.iter().zip(data[pixels..].chunks_exact(pixels)).map(of_component).collect();
    Plate { route, components, level, coordinates, rounding }
}

/// The scene with one light, which shines at all wavelengths: whatever it sends is divided out again.
fn alone(scene: &Scene, route: Route) -> SceneSpec {
    let spectrum = Spectrum::continuous(1.0, Arc::new(BlackBody(Temperature(6000.0))));
    let mut spec = scene.as_lights();
    let (stars, species) = (std::mem::take(&mut spec.stars), std::mem::take(&mut spec.emission));
    spec.background = Background::default();
    match route {
        Route::Scattered { star } | Route::Direct { star } => spec.stars.push(Star { spectrum, ..stars[star].clone() }.hidden()),
        Route::Emitted { species: number } => spec.emission.push(Emission { spectrum, ..species[number].clone() }),
        Route::Background | Route::FieldStar { .. } => spec.background.spectrum = Some(spectrum),
    }
    spec
}

//! Plates: a picture kept light by light, so that spectra change without a march.
//!
//! A picture is linear in the light of each star, each species of gas and the background, and hangs on wavelength through the
//! extinction k alone. A plate holds what one light leaves in each pixel behind its depths at any k, G(k) = ∫ e^(−a k) dμ(a):
//! G(k_0) at the least extinction of a range in single precision, and its [`Components`], of sixteen bits each. The picture of any spectrum
//! through any passband in the range is a sum of few numbers of each pixel, eq. (27) of docs/method.md:
//!
//!   I_b = Σ_s G_s(k_0) (m·w_bs + Σ_t c_st (v_t·w_bs)),    w_bsj = ∫ R_b S_s k ω L_j(k) dλ
//!
//! Luminosities, temperatures and lines of stars and gas may change, passbands, albedo, and the extinction law where the phase
//! function is that of all wavelengths. So may the amount of dust there: f times the dust is f times the extinction, G(f k) for G(k), and
//! f times the light that it scatters. What is bound is the [`Geometry`]. Where light scatters more than once, albedo, law and amount are
//! bound as well, and each light is marched by itself at the wavelengths of all nodes.

mod certificates;
mod exposure;
mod geometry;
mod march;
mod mixture;
mod reach;

use std::sync::Arc;

use spectra::components::Components;
use spectra::rule::{CommonNodes, Node, Rounding, Source};

pub use self::geometry::{Geometry, Trait, binds_dust};
use self::march::Work;
use self::mixture::Share;
pub use self::reach::Reach;
use self::reach::{amounts, check, one_scattering, range};
use crate::backend::end_of_space;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::light::{Light, Route, law, lights};
use crate::phase::Phase;
use crate::plan::{Choices, Options, Planned, Planner, Quality, source};
use crate::points::{Sources, points};
use crate::scene::Scene;

/// The part of the accuracy that components may cost.
const SHARE: f64 = 0.2;
/// The largest stored number of a coordinate.
const LEVELS: f32 = 65535.0;
/// Largest number of nodes.
const MOST_NODES: usize = 512;
/// Steps of angle at which a phase function is asked.
const ANGLES: usize = 24;
/// Light of one source in each pixel at any extinction.
#[derive(Debug, Clone, PartialEq)]
pub struct Plate {
    /// The way that the light takes.
    pub route: Route,
    /// The components of what its light leaves at the nodes.
    pub components: Components,
    /// G(k_0) of each pixel, in the unit of the light's [geometry](Light): what a spectral factor of one comes to.
    pub level: Vec<f32>,
    /// The coordinates of each pixel, component × pixel, in 65535 steps of their range.
    pub coordinates: Vec<Vec<u16>>,
    /// Arithmetic error of the light.
    pub rounding: Rounding,
}

/// All that plates hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Pixels along a row and a column.
    pub size: [usize; 2],
    /// Extinctions in equal steps, ascending: the range that plates serve.
    pub nodes: Vec<Node>,
    /// The shortest wavelength and the longest that they are made for \[µm\].
    pub range_um: (f64, f64),
    /// True if light scatters more than once, so that what is left at the nodes is no sum of exponentials.
    pub scatters_again: bool,
    /// A plate for each light that is not seen as points.
    pub plates: Vec<Plate>,
    /// The optical depth in front of each unresolved source, in the order of [`points`].
    pub depths: Vec<f64>,
    /// Scene data that may not change.
    pub geometry: Geometry,
    /// The amount of dust that was marched, as the optical depth at V of a parsec of density one \[pc⁻¹\]; zero without dust.
    pub dust_per_pc: f64,
    /// The accuracy that was asked for \[1\].
    pub accuracy: f64,
    /// The largest optical depth that rays met \[1\].
    pub depth: f64,
    /// Notes of the march, each with its topic.
    pub notes: Vec<(String, String)>,
}

/// Picture stored per light, to change spectra without another march.
///
/// # Examples
/// ```
/// use barnard::field::Fbm;
/// use barnard::plates::Reach;
/// use barnard::prelude::*;
///
/// let camera = Camera::look_at(dvec3(0.0, 0.0, 5.0), DVec3::ZERO).with_size(8, 8);
/// let dust = Dust::new(Fbm::new(3), Extinction::by_name("draine03_rv31")?, Scale::mag_per_pc(4.0)).with_albedo(0.6);
/// let star = |kelvin| Star::blackbody(Temperature(kelvin), Luminosity::suns(2000.0)).with_position(dvec3(0.1, 0.2, -0.5));
/// let scene = SceneSpec::new(camera).with_bands(passband::set("johnson")?).with_dust(dust).with_star(star(15_000.0)).build()?;
/// let control = Control::default();
/// let plates = Plates::new(&scene, Reach::default(), None, &Options::default(), &control)?;
/// let hotter = scene.edited(|spec| spec.stars = vec![star(30_000.0)])?;
/// let hotter = plates.expose(&hotter, &control)?;
/// assert!(hotter.band(0).any(|v| v > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Plates(Arc<Record>);

/// Weights of plates and unresolved sources in the bands, for the spectra of one scene.
pub struct Mixture {
    /// The amount of dust, as a part of that of the plates.
    amount: f64,
    /// The nodes of the plates for that amount: what each has of extinction as the scene has it.
    nodes: Vec<Node>,
    /// Plate × band.
    shares: Vec<Vec<Share>>,
    /// Light × band: the weights at the nodes of lights that are seen as points, none of others.
    points: Vec<Vec<Vec<f64>>>,
    /// Band × light.
    parts: Vec<Vec<PlateLight>>,
    phases: Vec<PhaseFactor>,
}

/// A light in a band: its number, its plate where it has one, what it sends, and its weights at the nodes.
struct PlateLight {
    light: usize,
    plate: Option<usize>,
    source: Source,
    weights: Vec<f64>,
}

/// A phase function under one angle.
type PhaseFactor = Box<dyn Fn(f64) -> f64 + Send + Sync>;

impl Plates {
    /// Plates of `scene` with the requested reach. What holds of `before`, a plan of the same scene, is taken from it.
    ///
    /// # Errors
    /// Errors of [`Planner::plan`]; an empty range, or one beyond the extinction law; too many stars; other amounts of dust requested with
    /// multiple scattering or a phase function that depends on wavelength.
    pub fn new(scene: &Scene, reach: Reach, before: Option<&Planned>, options: &Options, control: &Control) -> Result<Self> {
        Ok(Self::planned(scene, reach, before, None, options, control)?.0)
    }

    /// Variant with the plan that they were marched by, which may hold to [choices](Choices) that are made already.
    ///
    /// # Errors
    /// Errors of [`new`](Self::new).
    pub fn planned(
        scene: &Scene,
        reach: Reach,
        before: Option<&Planned>,
        choices: Option<&Choices>,
        options: &Options,
        control: &Control,
    ) -> Result<(Self, Planned)> {
        scene.check()?;
        check(scene)?;
        let range_um = range(scene, reach.range_um)?;
        let marched = one_scattering(scene, range_um, amounts(scene, reach.dust)?)?;
        let (of_plan, of_march) = (control.part(0.0, 0.3), control.part(0.3, 1.0));
        let quality = choices.map_or(Quality::Full, |choices| Quality::Chosen(Box::new(choices.clone())));
        let plan = Planner::new(options).with_quality(quality).plan(marched, before, &of_plan)?;
        let nodes = plan.spectral().common_nodes().unwrap_or_default().to_vec();
        if nodes.len() > MOST_NODES {
            let problem =
                format!("an optical depth of {:.0} needs {} nodes, plates have at most {MOST_NODES}", plan.spectral().depth, nodes.len());
            return Err(Error::conflict(problem, "use a narrower range or a larger accuracy"));
        }
        let extended: Vec<usize> = (0..plan.lights().len()).filter(|light| is_extended(plan.lights()[*light].route)).collect();
        let work = Work { scene, nodes: &nodes, options, control: &of_march };
        let (plates, stats) = if scene.method.bounces == 1 { work.once(&plan, &extended)? } else { work.again(&plan, &extended)? };
        let far = end_of_space(&plan);
        let depth = |point: &crate::points::Point| {
            let ray = point.ray(&scene.camera);
            plan.space().depth(ray.origin, ray.at(point.length.min(far)))
        };
        let depths = points(Sources::All, scene, &scene.camera, plan.lights())?.iter().map(depth).collect();
        let plates = Self::of(Record {
            size: [scene.camera.width, scene.camera.height],
            range_um,
            scatters_again: scene.method.bounces > 1,
            plates,
            depths,
            geometry: Geometry::of(scene, &nodes)?,
            dust_per_pc: dust_per_pc(scene),
            accuracy: scene.method.accuracy,
            depth: stats.depth.max(0.0),
            notes: plan.report("plates", &stats).statements(),
            nodes,
        })?;
        Ok((plates, plan))
    }

    /// Plates of what they hold, as files do.
    ///
    /// # Errors
    /// If sizes do not go together, or numbers cannot be.
    pub fn of(record: Record) -> Result<Self> {
        let Record { size, nodes, plates, .. } = &record;
        let wrong = |what: &str| Err(Error::conflict(format!("plates have {what}"), "write them again with `barnard plates`"));
        let pixels = size[0].saturating_mul(size[1]);
        let ascends = |pair: &[Node]| pair[1].k > pair[0].k;
        if nodes.len() < 6 || !nodes.windows(2).all(ascends) || !nodes.iter().all(|node| node.lambda_um > 0.0) {
            return wrong("unsorted nodes");
        }
        let (first, step) = (nodes[0].k, nodes[1].k - nodes[0].k);
        let in_step = |(j, node): (usize, &Node)| (node.k - first - j as f64 * step).abs() < 1e-6 * (1.0 + node.k);
        if !nodes.iter().enumerate().all(in_step) {
            return wrong("nodes of unequal steps");
        }
        let of_nodes = |row: &Vec<f64>| row.len() == nodes.len() && row.iter().all(|v| v.is_finite());
        let sound = |components: &Components| {
            let is_range = |[low, high]: &[f64; 2]| high >= low && (high - low).is_finite();
            of_nodes(&components.mean)
                && components.axes.iter().all(of_nodes)
                && components.ranges.len() == components.axes.len()
                && components.ranges.iter().all(is_range)
                && components.error >= 0.0
        };
        if !plates.iter().all(|plate| sound(&plate.components)) {
            return wrong("invalid components");
        }
        let fits = |plate: &Plate| {
            plate.level.len() == pixels
                && plate.coordinates.len() == plate.components.axes.len()
                && plate.coordinates.iter().all(|coordinate| coordinate.len() == pixels)
                && is_extended(plate.route)
        };
        if !plates.iter().all(fits) {
            return wrong("mismatched sizes");
        }
        let is_depth = |depth: &f64| *depth >= 0.0;
        let is_number = |level: f64| is_depth(&level) && level.is_finite();
        if !(record.range_um.0 > 0.0 && record.range_um.1 > record.range_um.0 && record.range_um.1.is_finite()) {
            return wrong("an invalid wavelength range");
        }
        if !(is_number(record.depth) && is_number(record.dust_per_pc) && record.accuracy > 0.0 && record.depths.iter().all(is_depth)) {
            return wrong("invalid depths or accuracy");
        }
        Ok(Self(Arc::new(record)))
    }

    /// Contents.
    pub fn record(&self) -> &Record {
        &self.0
    }

    /// The bytes that they take.
    pub fn bytes(&self) -> u64 {
        let of_plate = |plate: &Plate| 4 * plate.level.len() + 2 * plate.coordinates.iter().map(Vec::len).sum::<usize>();
        self.0.plates.iter().map(of_plate).sum::<usize>() as u64
    }

    /// The wavelengths that they serve, from the shortest to the longest \[µm\].
    pub fn range_um(&self) -> (f64, f64) {
        self.0.range_um
    }

    /// Refuses a scene that has another geometry than the one that they were made of.
    ///
    /// # Errors
    /// Says what of it is another.
    pub fn check(&self, scene: &Scene) -> Result<()> {
        check(scene)?;
        self.0.geometry.check(&Geometry::of(scene, &self.0.nodes)?)
    }

    /// Weights of the plates in the bands of a scene.
    ///
    /// # Errors
    /// Errors of [`check`](Self::check), if a light shines at wavelengths that the plates do not serve, and if the
    /// scene has a light that they do not hold.
    pub fn mixture(&self, scene: &Scene) -> Result<Mixture> {
        scene.check()?;
        self.check(scene)?;
        let plates = &self.0.plates;
        let amount = self.amount(scene)?;
        let nodes: Vec<Node> = self.0.nodes.iter().map(|node| Node { k: node.k / amount, ..*node }).collect();
        let (lights, law) = (lights(scene)?, law(scene)?);
        let mut parts: Vec<Vec<PlateLight>> = Vec::new();
        for band in &scene.bands {
            let part = |(light, light_row): (usize, &Light)| {
                let source = source(scene, light_row, band, &law);
                let weights = CommonNodes::weights_of(&nodes, &source.measure).map_err(|error| {
                    match CommonNodes::weights_of(&self.0.nodes, &source.measure).is_err() {
                        true => {
                            let problem = format!("{} in {}: {error}", light_row.name, band.name());
                            Error::conflict(problem, "stay within the wavelength range of the plates, or make plates with a wider --range")
                        }
                        false => {
                            let problem = format!("the plates do not cover {amount:.4} times their amount of dust in {}", band.name());
                            Error::conflict(problem, "make plates with a wider --dust")
                        }
                    }
                })?;
                let plate = plates.iter().position(|plate| plate.route == light_row.route);
                if plate.is_none() && is_extended(light_row.route) {
                    return Err(Error::conflict(format!("the plates have no {}", light_row.name), "make new plates of this scene"));
                }
                Ok(PlateLight { light, plate, source, weights })
            };
            parts.push(lights.iter().enumerate().map(part).collect::<Result<_>>()?);
        }
        let dark = vec![0.0; nodes.len()];
        let share = |plate: usize, parts: &[PlateLight]| {
            let part = parts.iter().find(|part| part.plate == Some(plate));
            stored_share(&plates[plate].components, part.map_or(&dark, |part| &part.weights), times(amount, plates[plate].route))
        };
        let shares = (0..plates.len()).map(|plate| parts.iter().map(|part| share(plate, part)).collect()).collect();
        let of_points = |light: usize| match is_extended(lights[light].route) {
            true => Vec::new(),
            false => parts.iter().map(|band_parts| band_parts[light].weights.clone()).collect(),
        };
        let points = (0..lights.len()).map(of_points).collect();
        Ok(Mixture { amount, nodes, shares, points, parts, phases: phases(scene) })
    }

    /// The amount of dust of a scene, as a part of theirs.
    fn amount(&self, scene: &Scene) -> Result<f64> {
        let (plates_dust, theirs) = (self.0.dust_per_pc, dust_per_pc(scene));
        match plates_dust == theirs {
            true => Ok(1.0),
            false if plates_dust > 0.0 && theirs > 0.0 => Ok(theirs / plates_dust),
            false => {
                let problem = format!("the dust scale is {theirs} pc-1, that of the plates {plates_dust} pc-1");
                Err(Error::conflict(problem, "use a scale above zero in both, or make new plates"))
            }
        }
    }
}

/// Factor of a light for a factor of the dust.
fn times(amount: f64, route: Route) -> f64 {
    if matches!(route, Route::Scattered { .. }) { amount } else { 1.0 }
}

/// Weights of stored numbers for a light with these weights and a given factor.
fn stored_share(components: &Components, weights: &[f64], times: f64) -> Share {
    let (of_mean, shares) = components.shares(&weights.iter().map(|w| w * times).collect::<Vec<f64>>());
    let low: f64 = shares.iter().zip(&components.ranges).map(|(share, [low, _])| share * low).sum();
    let step = |(share, [low, high]): (&f64, &[f64; 2])| share * (high - low) / f64::from(LEVELS);
    Share { of_mean: of_mean + low, of_coordinate: shares.iter().zip(&components.ranges).map(step).collect() }
}

/// The phase function under many angles, where it changes with wavelength.
fn phases(scene: &Scene) -> Vec<PhaseFactor> {
    let phase = scene.dust.as_ref().map(|dust| dust.phase.clone()).filter(|phase| phase.is_spectral());
    let under = |phase: &Arc<dyn Phase>, i: usize| {
        let (phase, cosine) = (phase.clone(), (std::f64::consts::PI * i as f64 / ANGLES as f64).cos());
        Box::new(move |lambda| phase.at(cosine, lambda)) as PhaseFactor
    };
    phase.iter().flat_map(|phase| (0..=ANGLES).map(|i| under(phase, i))).collect()
}

/// True if a light is seen in all pixels, and not as a point.
fn is_extended(route: Route) -> bool {
    matches!(route, Route::Scattered { .. } | Route::Emitted { .. } | Route::Background)
}

/// The amount of dust of a scene, as the optical depth at V of a parsec of density one \[pc⁻¹\]; zero without dust.
pub fn dust_per_pc(scene: &Scene) -> f64 {
    scene.dust.as_ref().map_or(0.0, |dust| dust.sigma_v_per_pc)
}

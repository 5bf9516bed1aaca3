//! Plans: the numbers a scene comes to, made once in f64. The fast back ends read only this.
//!
//! [`Space`] holds what the places of things decide (density, star depths, empty space, step), [`Spectral`] what spectra decide (nodes, weights,
//! phase tables). A changed spectrum keeps the space, a changed camera keeps both.

mod bricks;
mod closed_form;
pub mod cone;
pub mod crowd;
mod describe;
mod diffuse;
mod light_field;
pub mod near;
mod pilot;
mod planes;
mod probe;
pub mod pyramid;
mod sampled_pixels;
pub mod segment;
mod space;
mod spectral;
pub mod star_depth;
mod volume;
mod walk;
mod weights;
pub mod window;

use std::sync::Arc;

pub use bricks::Bricks;
pub use closed_form::{ClosedForm, End};
pub use crowd::Crowd;
pub use describe::describe;
pub use diffuse::{Diffuse, Doubt, Fineness, Gathered, ordinates};
pub use light_field::LightField;
pub use pilot::Spatial;
pub use probe::Probe;
pub use space::{Space, sample_functions};
pub use spectral::{BandPlan, PHASE_RANGE, PhaseTable, Spectral};
pub use volume::{Channel, MAX_CHANNELS, Volume};
pub use weights::{Emitter, Scatterer, Weights, weights as weights_of};

use spectra::rule::{self, Certificate, Rounding};

use crate::backend::cpu::Findings;
use crate::camera::Camera;
use crate::control::Control;
use crate::error::Result;
use crate::keywords::{self, Keyword};
use crate::light::{Light, Path};
use crate::scene::{Method, MethodEntry, Scene, StarDepth};

/// What a user may decide beside the scene.
#[derive(Debug, Clone)]
pub struct Options {
    /// Spectral rule and accuracy.
    pub method: Method,
    /// Most bytes a plan may take.
    pub memory_limit: u64,
    /// What sweeps light that is scattered more than once; the processor where it is not said.
    pub sweeper: Option<Arc<dyn ordinates::Sweeper>>,
}

impl Options {
    /// On the processor alone.
    pub fn new(method: Method, memory_limit: u64) -> Self {
        Self { method, memory_limit, sweeper: None }
    }
}

/// Everything a fast back end needs; a copy shares all that is large.
#[derive(Debug, Clone)]
pub struct Plan {
    /// From pixels to rays.
    pub camera: Camera,
    /// The lights, in the order of all tables.
    pub lights: Arc<Vec<Light>>,
    /// What places decide.
    pub space: Arc<Space>,
    /// What spectra decide.
    pub spectral: Arc<Spectral>,
    /// Steps along a ray.
    pub stepping: Stepping,
    /// Samples of a star depth that is marched again at every sample of a ray instead of being read: the deck's double integration.
    pub star_march: Option<usize>,
    /// The light of all stars together, which is marched in place of star depths.
    pub light_field: Option<Arc<LightField>>,
    /// Light that was scattered before it scatters towards the eye, where more than one scattering is asked for.
    pub diffuse: Option<Arc<Diffuse>>,
    /// Times that light of stars may scatter.
    pub bounces: usize,
}

/// Largest relative error of a number in single precision, and in half precision.
pub const SINGLE: f64 = 1.0 / (1 << 24) as f64;
/// The same in half precision, in which textures hold densities.
pub const HALF: f64 = 1.0 / (1 << 11) as f64;
/// Relative error of one term of one segment in single precision: the exponential's polynomial and that of sinh y/y.
const TERM_ROUNDING: f64 = 3e-6;

/// Samples between looks at whether a ray can end.
pub const END_EVERY: usize = 8;
/// What lies behind an ended ray, as a part of the accuracy.
pub const END_SHARE: f32 = 0.02;
/// Depth from which on a look is worth its price.
pub const END_DEPTH: f32 = 3.0;

/// Most voxels along an edge of a [glance](Plan::glance), and its samples along one.
pub const GLANCE_VOXELS: usize = 64;
const GLANCE_STEPS: f64 = 0.75;
/// At which it looks where a phase function must be asked, and where rays may end.
const GLANCE_ACCURACY: f64 = 0.02;

/// Samples a ray of the deck.
pub const DECK_STEPS: usize = 100;

/// How far a ray's samples are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepping {
    /// So many samples in each voxel edge of the finest grid.
    PerVoxel(f64),
    /// So many samples on every ray.
    Fixed(usize),
}

impl Stepping {
    /// Samples along so many parsecs.
    pub fn steps(self, length_pc: f64, voxel_pc: f64) -> usize {
        match self {
            Stepping::PerVoxel(n) => (length_pc / voxel_pc * n).ceil().max(1.0) as usize,
            Stepping::Fixed(n) => n,
        }
    }
}

impl std::fmt::Display for Stepping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Stepping::PerVoxel(n) => write!(f, "{n} samples a voxel"),
            Stepping::Fixed(n) => write!(f, "{n} samples a ray"),
        }
    }
}

/// A plan before its steps are known.
struct Draft {
    lights: Vec<Light>,
    space: Space,
    spectral: Spectral,
    light_field: Option<LightField>,
    star_march: Option<usize>,
}

impl Draft {
    fn new(scene: &Scene, lights: Vec<Light>, space: Space, spectral: Spectral, options: &Options, control: &Control) -> Result<Self> {
        diffuse::check(&spectral, options)?;
        let star_depth = options.method.entry.star_depth;
        let light_field = match star_depth {
            StarDepth::Gathered => LightField::new(scene, &lights, &spectral, &space, options, control)?,
            StarDepth::Cached | StarDepth::Marched => None,
        };
        let star_march = (star_depth == StarDepth::Marched).then(|| options.method.steps.unwrap_or(DECK_STEPS));
        Ok(Self { lights, space, spectral, light_field, star_march })
    }

    fn plan(mut self, scene: &Scene, stepping: Stepping, options: &Options, before: Option<&Diffuse>, control: &Control) -> Result<Plan> {
        let fineness = (options, Fineness::FULL);
        let diffuse = Diffuse::new(scene, &self.lights, &self.spectral, &self.space, fineness, before, control)?;
        if self.light_field.is_some() {
            self.space.forget_star_depths(options, control)?;
        }
        Ok(Plan {
            camera: scene.camera.clone(),
            lights: Arc::new(self.lights),
            space: Arc::new(self.space),
            spectral: Arc::new(self.spectral),
            stepping,
            star_march: self.star_march,
            light_field: self.light_field.map(Arc::new),
            diffuse: diffuse.map(Arc::new),
            bounces: options.method.bounces,
        })
    }
}

impl Plan {
    /// Plans `scene`: pilot rays choose steps, star depths and rules, and measure what they cost.
    pub fn new(scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        Self::renewed(None, scene, options, control)
    }

    /// The same, bit by bit, from what another plan has that still holds: densities, depths of stars that did not move, light that was scattered before.
    pub fn renewed(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        let lights = crate::light::lights(scene)?;
        // A light field stands in place of star depths, which are gone.
        let known = before.filter(|plan| plan.light_field.is_none());
        let space = match known.map(|plan| plan.space.again(scene, options, control)).transpose()?.flatten() {
            Some(space) => space,
            None => Space::new(scene, options, control)?,
        };
        space.check_stars(scene)?;
        let spectral = pilot::spectral(scene, &lights, &space, options, control)?;
        spectral.check_strength(&lights)?;
        let mut draft = Draft::new(scene, lights, space, spectral, options, control)?;
        let stepping = match draft.star_march {
            // Nothing is baked that a step could be wrong about.
            Some(n) => Stepping::Fixed(n),
            None => {
                let Draft { lights, space, spectral, light_field, .. } = &mut draft;
                pilot::choose(scene, lights, spectral, space, light_field.as_ref(), options, control)?
            }
        };
        draft.plan(scene, stepping, options, before.and_then(|plan| plan.diffuse.as_deref()), control)
    }

    /// Plans `scene` for a look at once, while things change, from what `before`, another glance, has that still holds: without the star field, by the rule
    /// [`GLANCE`](rule::GLANCE) whatever the scene's method is, at [`GLANCE_VOXELS`], and nothing is measured or stated of its error.
    pub fn glance(before: Option<&Self>, scene: &Scene, options: &Options, control: &Control) -> Result<Self> {
        let entry =
            MethodEntry { name: rule::GLANCE.name, summary: rule::GLANCE.summary, rule: &rule::GLANCE, star_depth: StarDepth::Cached };
        let kept = &options.method;
        let method = Method {
            entry,
            accuracy: GLANCE_ACCURACY,
            bake: kept.bake,
            bounces: kept.bounces,
            exact_stars: kept.exact_stars,
            ..Method::default()
        };
        let options = &Options { method, ..options.clone() };
        let space = match before.map(|plan| plan.space.follow(scene, options, control)).transpose()?.flatten() {
            Some(space) => space,
            None => Arc::new(Space::coarse(scene, options, GLANCE_VOXELS, control)?),
        };
        let mut lights = crate::light::lights(scene)?;
        lights.retain(|light| !matches!(light.path, Path::FieldStar { .. }));
        let spectral = Spectral::new(scene, &lights, space.crowd.as_deref(), options, space.reach(&scene.camera), control)?;
        let known = before.and_then(|plan| plan.diffuse.as_deref());
        let diffuse = Diffuse::new(scene, &lights, &spectral, &space, (options, Fineness::GLANCE), known, control)?;
        Ok(Self {
            camera: scene.camera.clone(),
            lights: Arc::new(lights),
            space,
            spectral: Arc::new(spectral),
            stepping: Stepping::PerVoxel(GLANCE_STEPS),
            star_march: None,
            light_field: None,
            diffuse: diffuse.map(Arc::new),
            bounces: options.method.bounces,
        })
    }

    /// Looks from elsewhere; all that space and spectra decide stays.
    ///
    /// # Errors
    /// When the user wishes to stop; the plan is as before then.
    pub fn look_from(&mut self, camera: Camera, control: &Control) -> Result<()> {
        if let Some(diffuse) = &self.diffuse {
            self.diffuse = Some(diffuse.seen_by(&camera, control)?);
        }
        self.camera = camera;
        Ok(())
    }

    /// Plans `scene` at `steps` samples a ray, with rules as they are asked for and nothing measured: for comparisons that measure from outside.
    pub fn sampled(scene: &Scene, options: &Options, steps: usize, control: &Control) -> Result<Self> {
        let method = Method { steps: Some(steps), ..options.method.clone() };
        let options = &Options { method, ..options.clone() };
        let lights = crate::light::lights(scene)?;
        let space = Space::new(scene, options, control)?;
        space.check_stars(scene)?;
        let spectral = Spectral::new(scene, &lights, space.crowd.as_deref(), options, space.reach(&scene.camera), control)?;
        Draft::new(scene, lights, space, spectral, options, control)?.plan(scene, Stepping::Fixed(steps), options, None, control)
    }

    /// Puts a star elsewhere [pc]: its depths alone are swept anew, nothing that spectra decide is touched. The measured spatial error stays that of the
    /// places before, and so does light that was scattered before.
    ///
    /// # Errors
    /// Where there is no such star, a light field stands in place of its depths, or the user wishes to stop; the plan is as before then.
    pub fn move_star(&mut self, star: usize, place: glam::DVec3, control: &Control) -> Result<()> {
        Arc::make_mut(&mut self.space).move_star(star, place, control)
    }

    /// Everything the march reads.
    pub fn volumes(&self) -> impl Iterator<Item = &Volume> {
        let fields = self.light_field.iter().flat_map(|f| &f.volumes);
        self.space.volumes.iter().chain(fields).chain(self.diffuse.iter().flat_map(|d| &d.volumes))
    }

    /// What a march of this plan on the processor is expected to find, before it was done.
    pub fn expected(&self) -> Findings {
        Findings { depth: self.spectral.depth, rays: (self.camera.width * self.camera.height) as u64, storage: SINGLE, negative: 0 }
    }

    /// What arithmetic adds to the error of a light that takes `path`: depths and light are sums over all steps in single precision, of densities kept with a relative
    /// error of `storage`, and a ray ends when little is left. What comes straight from a star is done in double precision.
    fn rounding(&self, path: Path, storage: f64) -> Rounding {
        let longest = self.space.occupied.map_or(0.0, |b| b.size().length());
        let steps = if longest > 0.0 { self.stepping.steps(longest, self.space.voxel_pc()) as f64 } else { 0.0 };
        // A sum of n like terms loses at most half a unit of the last place n/2 times on the average of its way.
        let sum = SINGLE * (4.0 + 0.5 * steps);
        let early = f64::from(END_SHARE) * self.spectral.accuracy;
        match path {
            Path::Scattered { .. } | Path::Emitted { .. } => Rounding { depth: storage + sum, light: TERM_ROUNDING + sum + early },
            Path::Background => Rounding { depth: storage + sum, light: SINGLE },
            Path::Direct { .. } | Path::FieldStar { .. } => Rounding { depth: 0.0, light: 0.0 },
        }
    }

    /// The certificate of a passband in words, a line for each light, for what a march found.
    pub fn certificate(&self, band: usize, findings: &Findings) -> Vec<String> {
        self.certificates(band, findings).iter().map(|(light, c)| format!("{}: {}", self.lights[*light].name, in_words(c))).collect()
    }

    /// The certificate of the light that a passband's rule serves worst, in words.
    pub fn worst_certificate(&self, band: usize, findings: &Findings) -> String {
        let certificates = self.certificates(band, findings);
        let Some((light, worst)) = certificates.iter().max_by(|a, b| a.1.absolute.total_cmp(&b.1.absolute)) else {
            return "no light shines in this band".into();
        };
        let others = match certificates.len() {
            1 => String::new(),
            count => format!(", worst of {count} lights ({})", self.lights[*light].name),
        };
        in_words(worst) + &others
    }

    /// Certificates of the lights that shine in a passband, by their numbers, arithmetic included.
    pub fn certificates(&self, band: usize, findings: &Findings) -> Vec<(usize, Certificate)> {
        let (sources, depth) = (&self.spectral.bands[band].sources, findings.depth);
        let mut certificates = self.spectral.certify(band, depth);
        for (light, gathered) in self.light_field.iter().flat_map(|field| field.certify(band, sources, depth)) {
            certificates[light] = gathered;
        }
        let shining = |(light, _): &(usize, Certificate)| sources[*light].measure.total() > 0.0;
        let rounded = |(light, c): (usize, Certificate)| {
            let rounding = self.rounding(self.lights[light].path, findings.storage);
            (light, c.rounded(&sources[light].measure, rounding))
        };
        certificates.into_iter().enumerate().filter(shining).map(rounded).collect()
    }

    /// Whether the pilot rays found a larger error than was asked for.
    pub fn misses_accuracy(&self) -> bool {
        self.space.spatial.is_some_and(|s| s.error > self.spectral.accuracy)
    }

    /// What to know of the picture beside the certificates: what it is about, and words.
    pub fn notes(&self) -> Vec<(String, String)> {
        let isotropic = self.light_field.as_ref().filter(|f| f.isotropic_instead);
        let isotropic = isotropic.map(|_| ("phase function".into(), "put aside by this method, which scatters evenly".into()));
        let gathered = self.diffuse.iter().filter_map(|d| d.found.gathered).map(|g| ("gathered stars".into(), g.to_string()));
        let diffuse = self.diffuse.iter().filter(|d| d.found.sweeps > 0).map(|d| ("many bounces".into(), d.found.to_string()));
        self.spatial_note().into_iter().chain(isotropic).chain(self.fit_note()).chain(gathered).chain(diffuse).collect()
    }

    /// The worst of the polynomials that stand for spectra.
    fn fit_note(&self) -> Option<(String, String)> {
        let of_rules = self.spectral.bands.iter().flat_map(|band| {
            let fits = (0..self.lights.len()).filter_map(|light| band.rule.form.decay().fit(light).map(|fit| (light, fit)));
            fits.map(|(light, fit)| (format!("{} in {}", self.lights[light].name, band.band.name()), fit))
        });
        let of_stars = self.light_field.iter().flat_map(|f| f.fits().map(|(light, fit)| (self.lights[light].name.clone(), fit)));
        let (name, worst) = of_rules.chain(of_stars).max_by(|a, b| a.1.rms.total_cmp(&b.1.rms))?;
        let degree = worst.polynomial.coefficients.len() - 1;
        let words = format!(
            "worst of degree {degree}: {name}, rms {:.1e}, at most {:.1e} of its peak; a part of the spectral error",
            worst.rms, worst.largest
        );
        Some(("polynomial fits".into(), words))
    }

    /// The spatial error in words.
    fn spatial_note(&self) -> Option<(String, String)> {
        let s = self.space.spatial?;
        let words = format!(
            "measured {:.1e} (relative rms of the worst band over {} pilot rays, {}, {})",
            s.error,
            s.rays,
            s.stepping,
            match &self.light_field {
                None => format!("star depths of {} a voxel", self.space.star_factor),
                Some(field) => format!("a light field of {} numbers a voxel", field.propagation.channels()),
            }
        );
        let words = match s.sampling {
            Some((error, edge)) => format!("{words}, {error:.1e} of it by samples of functions, {edge} along an edge"),
            None => words,
        };
        let asked = self.spectral.accuracy;
        let words = if self.misses_accuracy() { format!("{words}: more than the {asked:.1e} that was asked for") } else { words };
        Some(("spatial error".into(), words))
    }

    /// What the plan says of a picture in keywords: method, steps and errors as numbers.
    pub fn keywords(&self, findings: &Findings) -> Vec<Keyword> {
        let mut keywords = vec![
            keywords::text("METHOD", self.spectral.method, "how spectral integrals are done"),
            keywords::integer("BOUNCES", self.bounces, "times that light may scatter"),
            keywords::text("STEPS", self.stepping.to_string(), "how far samples are apart"),
        ];
        keywords.extend(keywords::number("ACCURACY", self.spectral.accuracy, "asked for"));
        keywords.extend(keywords::number("TAUMAX", findings.depth, "largest optical depth at V that was met"));
        if let Some(spatial) = self.space.spatial {
            keywords.extend(keywords::number("SPATERR", spatial.error, "spatial error, relative rms, measured"));
            keywords.push(keywords::integer("SPATRAYS", spatial.rays, "rays that it was measured on"));
            if let Some((error, edge)) = spatial.sampling {
                keywords.extend(keywords::number("SAMPERR", error, "of it by samples of functions"));
                keywords.push(keywords::integer("BAKE", edge, "voxels along an edge that they were sampled to"));
            }
        }
        keywords
    }

    /// The spectral error of a band's worst light in keywords.
    pub fn band_keywords(&self, band: usize, findings: &Findings) -> Vec<Keyword> {
        let worst = self.certificates(band, findings).into_iter().map(|(_, c)| c).reduce(Certificate::or_worse);
        let errors = worst.into_iter().flat_map(|c| {
            let absolute = keywords::number("SPECERR", c.absolute, "spectral error at most, in parts of F(0)");
            absolute.into_iter().chain(keywords::number("SPECREL", c.relative, "and in parts of F(a), the light left"))
        });
        errors.collect()
    }

    /// Bytes of all tables and grids.
    pub fn bytes(&self) -> u64 {
        let fields = self.light_field.as_ref().map_or(0, |f| f.bytes()) + self.diffuse.as_ref().map_or(0, |d| d.bytes());
        self.space.bytes() + self.spectral.bytes() + fields
    }
}

fn in_words(c: &Certificate) -> String {
    format!("spectral error at most {:.1e} of F(0), {:.1e} of F(a), for depths up to {:.3}", c.absolute, c.relative, c.depth)
}

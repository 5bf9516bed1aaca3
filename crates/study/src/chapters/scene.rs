//! Barrès & Neyret's scene with as many stars as a chapter wants, and its frames.

use crate::backends;
use crate::bench::timed;
use barnard::control::Control;
use barnard::image::{Image, relative_rms, worst};
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planned, Planner, Quality, sample_functions};
use barnard::scene::{Method, Scene};
use spectra::rule::Settings;

use crate::Result;

/// A scene whose functions are sampled, so that all methods and the reference see one cloud.
pub struct Run {
    /// The scene of the chapters.
    pub scene: Scene,
}

/// A method that takes part, with what is fixed of it.
pub struct Contender {
    /// The name in the catalogue.
    pub method: &'static str,
    /// The fixed size, if it has one.
    pub count: Option<usize>,
    /// The degree of polynomials.
    pub degree: usize,
    /// The samples on a ray.
    pub steps: usize,
}

impl Contender {
    /// A contender with Barrès & Neyret's N = 100 and degree 5.
    pub fn new(method: &'static str, count: Option<usize>) -> Self {
        Self { method, count, degree: 5, steps: 100 }
    }

    /// The name and the size, for tables.
    pub fn label(&self) -> String {
        self.count.map_or(self.method.to_owned(), |n| format!("{} {n}", self.method))
    }
}

/// Temperatures that stars take in turn [K].
const TEMPERATURES: [u32; 6] = [10000, 3000, 5000, 8000, 20000, 40000];
/// Barrès & Neyret's three polynomial filters.
const BANDS: &str = "[[band]]\nname = \"blue\"\nkind = \"polynomial\"\ncoefficients = [-38.5062, 179.5555, -204.0816]\nlow = \"370 nm\"\nhigh = \"510 nm\"\n\
     [[band]]\nname = \"green\"\nkind = \"polynomial\"\ncoefficients = [-60.7347, 224.4898, -204.0816]\nlow = \"480 nm\"\nhigh = \"620 nm\"\n\
     [[band]]\nname = \"red\"\nkind = \"polynomial\"\ncoefficients = [-51.1605, 160.4938, -123.4568]\nlow = \"560 nm\"\nhigh = \"740 nm\"\n";

impl Run {
    /// Barrès & Neyret's cloud on `bake` voxels an edge, lit by a number of stars, seen through its filters or through one
    /// passband of the catalogue, in `edge` × `edge` pixels.
    pub fn new(stars: usize, passband: Option<&str>, bake: usize, edge: usize) -> Result<Self> {
        let mut text = passband.map_or(String::new(), |name| format!("bands = [\"{name}\"]\n"));
        text += &format!(
            "[camera]\nkind = \"perspective\"\nposition = \"0 0 4 pc\"\nfield_of_view = \"30 deg\"\nsize = [{edge}, {edge}]\n\
             [field.cloud]\nkind = \"fbm\"\nseed = 2\nradius = \"1 pc\"\nscale = \"0.6 pc\"\noctaves = 5\noffset = 0.15\n\
             [dust]\ndensity = \"cloud\"\nscale = \"4 /pc\"\nlaw = \"inverse_wavelength\"\nalbedo = 0.7\n[method]\nbake = {bake}\n"
        );
        for star in 0..stars {
            // Barrès & Neyret's own star first; the others around the cloud's middle by the golden angle.
            let (turn, height) = (2.399_963 * star as f64, 0.9 - 1.8 * (star as f64 + 0.5) / stars as f64);
            let flat = (1.0 - height * height).sqrt();
            let place = if star == 0 { [0.3, 0.35, 0.4] } else { [0.62 * flat * turn.cos(), 0.62 * height, 0.62 * flat * turn.sin()] };
            text += &format!(
                "[[star]]\nkind = \"blackbody\"\nposition = \"{} {} {} pc\"\ntemperature = \"{} K\"\nluminosity = \"1000 Lsun\"\nvisible = false\n",
                place[0],
                place[1],
                place[2],
                TEMPERATURES[star % TEMPERATURES.len()]
            );
        }
        if passband.is_none() {
            text += BANDS;
        }
        let scene = barnard_files::parse("study.toml", "study", text, &barnard_files::in_folder(".", DEFAULT_LIMIT))?;
        let options = Options::within(DEFAULT_LIMIT);
        let scene = sample_functions(&scene, &options)?;
        Ok(Self { scene })
    }

    /// The plan of a method as it is asked for, without pilots.
    pub fn plan(&self, contender: &Contender, control: &Control) -> Result<Planned> {
        let settings = Settings { count: contender.count, degree: contender.degree, ..Settings::default() };
        let method = Method { settings, ..self.scene.method.clone().with_name(contender.method)? };
        Ok(Planner::new(&Options::default()).with_quality(Quality::Fixed(contender.steps)).plan(
            self.scene.clone().with_method(method),
            None,
            control,
        )?)
    }

    /// Seconds a frame: the median of three, or one if that is long.
    pub fn seconds(&self, plan: &Planned, control: &Control) -> Result<f64> {
        Ok(timed(3, || backends::light(plan, control).map(|_| 0.0))?.0)
    }

    /// The seconds that one frame takes.
    pub fn once(&self, plan: &Planned, control: &Control) -> Result<f64> {
        Ok(timed(0, || backends::light(plan, control).map(|_| 0.0))?.0)
    }

    /// Resizes the scene to fewer pixels.
    pub fn resized(&mut self, edge: usize) {
        let camera = self.scene.camera.clone().with_size(edge, edge);
        self.scene = self.scene.clone().with_camera(camera);
    }

    /// The picture of a plan at the scene's present size, whatever it was planned for.
    pub fn image(&self, plan: Planned, control: &Control) -> Result<Image> {
        let plan = plan.with_size(self.scene.camera.width, self.scene.camera.height);
        Ok(backends::picture(&plan, control)?)
    }

    /// The picture of the reference.
    pub fn reference(&self, control: &Control) -> Result<Image> {
        Ok(backends::reference(&self.scene, control)?)
    }
}

/// Relative rms error of the worst band.
pub fn error(image: &Image, truth: &Image) -> f64 {
    worst((0..truth.bands.len()).map(|b| image.relative_rmse(b, truth, b)))
}

/// The error without the brightest 5 % of the truth's pixels, which stand next to stars.
pub fn error_away_from_stars(image: &Image, truth: &Image) -> f64 {
    let of_band = |b: usize| {
        let mut order: Vec<f64> = truth.band(b).collect();
        order.sort_by(f64::total_cmp);
        let limit = order[(order.len() * 95 / 100).min(order.len() - 1)];
        relative_rms(image.band(b).zip(truth.band(b)).filter(|(_, t)| *t < limit))
    };
    worst((0..truth.bands.len()).map(of_band))
}

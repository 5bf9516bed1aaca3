//! Random scenes whose light is known: a background behind a box of even dust, or gas that glows evenly within it.
//!
//! A ray that goes a length s through a box of extinction σ sees F(σ s) of what lies behind, and ∫ F da/σ over 0 … σ s
//! of what glows there, however few its steps: all that can be wrong is the spectral rule and arithmetic, which is what
//! a certificate states.

use std::fmt::Write;

use barnard::control::Control;
use barnard::geometry::Bounds;
use barnard::glam::DVec3;
use barnard::memory::DEFAULT_LIMIT;
use barnard::plan::{Options, Planner, Quality};
use barnard::scene::methods;
use rayon::prelude::*;
use spectra::extinction::{Extinction, LAWS, Maker};
use spectra::passband::{self, Passband};

use super::integral::{IntegrandSamples, SourceShape};
use crate::page::{short, table};
use crate::{Chapter, Findings, Result, backends};

pub const CHAPTER: Chapter = Chapter {
    name: "slabs",
    title: "Certificates on ten thousand random scenes",
    question: "Is a stated spectral error ever exceeded? Random laws, filters, lights, methods, accuracies and depths. Light behind a box of uniform dust, rendered by \
               `cpu`, is compared with independent integrals over wavelength.",
    run: |control| campaign(LightPlace::Behind, control),
};

/// The number of scenes of the page.
const SCENES: usize = 10_000;
/// Pixels along an edge, each of which sees a depth of its own.
const EDGE: usize = 4;
/// The excess over a bound that is not counted: the independent integrals are themselves known to this.
const INTEGRAL: f64 = 2e-9;
/// Worst cases that are shown.
const SHOWN: usize = 8;

/// The place that a scene's light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LightPlace {
    /// The light comes from behind the box.
    Behind,
    /// The light comes from everywhere within the box.
    Within,
}

/// Numbers from 0 to 1 by scene and question (SplitMix64; Steele, Lea & Flood 2014, OOPSLA).
struct Dice {
    state: u64,
}

impl Dice {
    fn new(scene: usize) -> Self {
        Self { state: (scene as u64).wrapping_mul(0xd134_2543_de82_ef95) }
    }

    fn next(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number between two, evenly in the logarithm.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.next())
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[((self.next() * choices.len() as f64) as usize).min(choices.len() - 1)]
    }
}

/// One random scene of the campaign.
struct SlabCase {
    text: String,
    place: LightPlace,
    method: &'static str,
    law: Extinction,
    law_name: String,
    bands: Vec<&'static str>,
    /// The density of extinction [pc⁻¹].
    sigma: f64,
    /// The shape of what shines, and its radiance where the shape is one [W m⁻² sr⁻¹ µm⁻¹], of a length of 1 pc if it
    /// comes from within.
    shape: SourceShape,
    radiance: f64,
}

const BOX: Bounds = Bounds { low: DVec3::new(-0.7, -0.8, -0.5), high: DVec3::new(0.9, 0.6, 0.5) };

impl SlabCase {
    fn new(place: LightPlace, number: usize) -> Result<Self> {
        let mut dice = Dice::new(number);
        let names: Vec<&'static str> = methods().map(|m| m.name).filter(|m| *m != "sampled").collect();
        let method = dice.one_of(&names);
        let entry = if method == "analytic" { LAWS[0] } else { LAWS[(dice.next() * LAWS.len() as f64) as usize] };
        let r_v = match entry.maker {
            Maker::RatioOfV { low, high, .. } => Some(low + (high - low) * dice.next()),
            Maker::Fixed(_) => None,
        };
        let law = Extinction::with_r_v(entry.name, r_v)?;
        let inside =
            |name: &&'static str| Passband::by_name(name).is_ok_and(|b| law.check("x", b.support_um().0, b.support_um().1).is_ok());
        let all: Vec<&'static str> = passband::names().into_iter().filter(inside).collect();
        let mut bands: Vec<&'static str> = (0..3).map(|_| dice.one_of(&all)).collect();
        bands.sort_unstable();
        bands.dedup();
        let pivot = Passband::by_name(bands[0])?.pivot().0;
        let radiance = 1e-6;
        let (shape, words) = match place {
            LightPlace::Behind => Self::background(&mut dice, pivot, radiance),
            LightPlace::Within => Self::gas(&mut dice, pivot, radiance),
        };
        let sigma = dice.between(0.01, 300.0);
        let accuracy = dice.between(1e-6, 1e-2);
        let count = if dice.next() < 0.3 { format!("count = {}\n", 2 + (dice.next() * 7.0) as usize) } else { String::new() };
        let ratio = r_v.map_or(String::new(), |r| format!("r_v = {r}\n"));
        let (x, y) = (dice.next() - 0.5, dice.next() - 0.5);
        // Where light comes from within, every segment is an integral of its own: few of them, thick ones.
        let steps = if place == LightPlace::Within { format!("steps = {}\n", dice.one_of(&[1, 2, 3, 8, 40])) } else { String::new() };
        let text = format!(
            r#"bands = {bands:?}
[camera]
kind = "orthographic"
position = "{x} {y} 3 pc"
width = "1.9 pc"
size = [{EDGE}, {EDGE}]
[field.box]
kind = "box"
low = "{} {} {} pc"
high = "{} {} {} pc"
[dust]
density = "box"
scale = "{sigma} /pc"
law = "{}"
{ratio}albedo = 0.0
{words}[method]
name = "{method}"
accuracy = {accuracy}
bake = 4
{count}{steps}"#,
            BOX.low.x, BOX.low.y, BOX.low.z, BOX.high.x, BOX.high.y, BOX.high.z, entry.name
        );
        let law_name = r_v.map_or(entry.name.to_owned(), |r| format!("{} {r:.2}", entry.name));
        Ok(Self { text, place, method, law, law_name, bands, sigma, shape, radiance })
    }

    /// A light behind the box, and how a scene says it.
    fn background(dice: &mut Dice, pivot: f64, radiance: f64) -> (SourceShape, String) {
        let head = format!(
            r#"[background]
radiance = "{radiance} W/m2/sr/um"
wavelength = "{pivot} um"
"#
        );
        if dice.next() < 0.5 {
            let temperature = dice.between(2000.0, 50_000.0);
            let star = format!("{head}kind = \"blackbody\"\ntemperature = \"{temperature} K\"\n");
            return (SourceShape::BlackBody(temperature, pivot), star);
        }
        let exponent = -4.0 + 8.0 * dice.next();
        let star = format!(
            r#"{head}kind = "power_law"
exponent = {exponent}
reference = "{pivot} um"
"#
        );
        (SourceShape::PowerLaw(exponent, pivot), star)
    }

    /// A gas that glows within the box, and how a scene says it.
    fn gas(dice: &mut Dice, pivot: f64, radiance: f64) -> (SourceShape, String) {
        let exponent = -4.0 + 8.0 * dice.next();
        // Strength is stated per nm.
        let scale = format!(
            r#"scale = "{radiance} W/m2/sr/pc"
continuum = 1e-3
continuum_at = "{pivot} um"
continuum_exponent = {exponent}
"#
        );
        (
            SourceShape::PowerLaw(exponent, pivot),
            format!(
                r#"[[emission]]
kind = "lines"
lines = []
density = "box"
{scale}"#
            ),
        )
    }

    /// The radiance that a ray of `length` [pc] through the box should see in a passband [W m⁻² sr⁻¹], and F(0).
    fn truth(&self, band: &Passband) -> impl Fn(f64) -> (f64, f64) + use<> {
        let (sigma, radiance) = (self.sigma, self.radiance);
        let samples = IntegrandSamples::new(band, self.shape, &*self.law);
        let (whole, place) = (radiance * samples.behind(0.0), self.place);
        move |length| match place {
            LightPlace::Behind => (radiance * samples.behind(sigma * length), whole),
            LightPlace::Within => (length * radiance * samples.within(sigma * length), length * whole),
        }
    }

    fn toml(&self) -> String {
        let place = if self.place == LightPlace::Behind { "behind" } else { "within" };
        match self.shape {
            SourceShape::BlackBody(t, _) => format!("black body of {t:.0} K {place}"),
            SourceShape::PowerLaw(e, _) => format!("power law {e:.2} {place}"),
        }
    }
}

/// The outcome of one band of one scene.
struct BandOutcome {
    method: &'static str,
    what: String,
    /// Largest true error over the pixels, and what wstated: of F(0), and of F(a).
    absolute: (f64, f64),
    relative: (f64, f64),
}

impl BandOutcome {
    /// The excess of the worse of both errors over its bound, as a factor.
    fn excess(&self) -> f64 {
        let over = |(found, stated): (f64, f64)| (found - INTEGRAL).max(0.0) / stated.max(f64::MIN_POSITIVE);
        over(self.absolute).max(over(self.relative))
    }
}

/// Renders a scene and holds each band to its bound; none where the scene cannot be done by its method.
fn outcomes(place: LightPlace, number: usize, control: &Control) -> Result<Option<Vec<BandOutcome>>> {
    let case = SlabCase::new(place, number)?;
    let scene = barnard_files::parse("campaign.toml", "campaign", case.text.clone(), &barnard_files::in_folder(".", DEFAULT_LIMIT))?;
    let options = Options::within(DEFAULT_LIMIT);
    let done = Planner::new(&options)
        .with_quality(Quality::Fixed(8))
        .plan(&scene, None, control)
        .and_then(|plan| Ok((backends::light(&plan, control)?, plan)));
    let (light, plan) = match done {
        Ok(done) => done,
        Err(barnard::Error::Interrupted) => return Err(barnard::Error::Interrupted.into()),
        Err(_) => return Ok(None),
    };
    let lengths: Vec<f64> = (0..EDGE * EDGE)
        .map(|i| scene.camera.ray((i % EDGE) as f64 + 0.5, (i / EDGE) as f64 + 0.5))
        .map(|ray| BOX.clip(&ray).map_or(0.0, |(near, far)| far - near))
        .collect();
    let of_band = |(b, name): (usize, &&'static str)| -> Result<Option<BandOutcome>> {
        let truth = case.truth(&Passband::by_name(name)?);
        if truth(1.0).1 <= 0.0 {
            return Ok(None);
        }
        let stated = plan.certificates(b, &light.stats).into_iter().next();
        let (mut absolute, mut relative) = (0.0f64, 0.0f64);
        for (i, length) in lengths.iter().enumerate().filter(|(_, l)| **l > 0.0) {
            let (value, whole) = truth(*length);
            let error = (light.samples.at(b * EDGE * EDGE + i) - value).abs();
            absolute = absolute.max(error / whole);
            // Below the range of single precision there is no light, and no part of it that could be wrong.
            if value > 1e-30 {
                relative = relative.max(error / value);
            }
        }
        let stated = stated.map_or((0.0, 0.0), |(_, c)| (c.absolute, c.relative));
        Ok(Some(BandOutcome {
            method: case.method,
            what: format!("{number}: {name}, {}, sigma {:.3}/pc, {}", case.law_name, case.sigma, case.toml()),
            absolute: (absolute, stated.0),
            relative: (relative, stated.1),
        }))
    };
    Ok(Some(case.bands.iter().enumerate().map(of_band).collect::<Result<Vec<_>>>()?.into_iter().flatten().collect()))
}

/// Runs all scenes, and says which bounds were exceeded.
pub(super) fn campaign(place: LightPlace, control: &Control) -> Result<Findings> {
    let done: Vec<Option<Vec<BandOutcome>>> = (0..SCENES)
        .into_par_iter()
        .map(|number| {
            control.check().map_err(crate::StudyError::from)?;
            // A scene takes milliseconds: its own progress would be noise.
            outcomes(place, number, &Control::default())
        })
        .collect::<Result<_>>()?;
    let refused = done.iter().filter(|d| d.is_none()).count();
    let mut all: Vec<BandOutcome> = done.into_iter().flatten().flatten().collect();
    let exceeded = all.iter().filter(|o| o.excess() > 1.0).count();
    let mut text = format!(
        "{SCENES} scenes, {} bands; {refused} scenes were rejected by their method. **Bounds exceeded: {exceeded}.** `sampled` is excluded, because its error is noise.\n\n",
        all.len()
    );
    let rows = methods().filter_map(|method| {
        let outcomes: Vec<&BandOutcome> = all.iter().filter(|o| o.method == method.name).collect();
        let largest = |quantity: fn(&BandOutcome) -> (f64, f64)| {
            outcomes.iter().map(|o| quantity(o)).map(|(f, s)| (f - INTEGRAL).max(0.0) / s).fold(0.0, f64::max)
        };
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
        };
        (!outcomes.is_empty()).then(|| {
            vec![
                method.name.to_owned(),
                outcomes.len().to_string(),
                short(median(outcomes.iter().map(|o| o.absolute.1).collect())),
                short(median(outcomes.iter().map(|o| o.absolute.0).collect())),
                short(largest(|o| o.absolute)),
                short(largest(|o| o.relative)),
                outcomes.iter().filter(|o| o.excess() > 1.0).count().to_string(),
            ]
        })
    });
    let head =
        ["method", "bands", "stated / F(0), median", "true, median", "true / stated of F(0), largest", "of F(a), largest", "exceeded"];
    text += &table(&head, &rows.collect::<Vec<_>>());
    all.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    let _ = writeln!(text, "Closest to their bounds:\n");
    let closest = all.iter().take(SHOWN).map(|o| {
        vec![o.method.to_owned(), o.what.clone(), short(o.absolute.0), short(o.absolute.1), short(o.relative.0), short(o.relative.1)]
    });
    let head = ["method", "scene and band", "error / F(0)", "stated", "error / F(a)", "stated"];
    text += &table(&head, &closest.collect::<Vec<_>>());
    Ok(Findings { text, ..Findings::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Holds some hundred scenes of the campaign, every method among them: no bound is exceeded, and a bound of a tenth
    /// would be. Beside them `known`, which once exceeded theirs.
    fn hold(place: LightPlace, known: &[usize]) {
        let tried = |n: usize| outcomes(place, n, &Control::default()).unwrap();
        let numbers: Vec<usize> = (0..240).chain(known.iter().copied()).collect();
        let all: Vec<BandOutcome> = numbers.into_par_iter().filter_map(tried).flatten().collect();
        assert!(all.len() > 300 && methods().filter(|m| m.name != "sampled").all(|m| all.iter().any(|o| o.method == m.name)));
        let exceeded = all.iter().filter(|o| o.excess() > 1.0);
        let words: Vec<String> = exceeded.map(|o| format!("{} {}: {:?} {:?}", o.method, o.what, o.absolute, o.relative)).collect();
        assert!(words.is_empty(), "{words:#?}");
        assert!(all.iter().filter(|o| 10.0 * o.excess() > 1.0).count() > all.len() / 20);
    }

    #[test]
    fn no_bound_of_light_from_behind_is_exceeded() {
        hold(LightPlace::Behind, &[]);
    }

    #[test]
    fn no_bound_of_light_from_within_is_exceeded() {
        // Light of two extinctions through a red leak, and terms that cancel where little is left.
        hold(LightPlace::Within, &[5256, 5003]);
    }
}

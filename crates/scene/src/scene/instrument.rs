//! The `[instrument]` table: what records the picture.

use spectra::constants::PARSEC;
use spectra::units::{Angle, Area, Charge, Counts, DarkCurrent, Gain, HitRate, Length, Magnitude, Quantity, Time};

use crate::data::Inputs;
use crate::error::Result;
use crate::instrument::{Brightness, Instrument, MAX_FRAMES, Sky, preset, psf};
use crate::observation::RadianceUnit;
use crate::properties::{Key, Section, Table, build_kind};

pub(super) const KEYS: &[Key] = &[
    Key::optional("preset", "text", "none", "predefined instrument; other keys override its values").of("instruments"),
    Key::optional("aperture", "length", "of the preset", "diameter of the aperture; required without a preset"),
    Key::optional("obstruction", "number", "0", "diameter of the central obstruction relative to the aperture"),
    Key::optional(
        "collecting_area",
        "area",
        "of the aperture",
        "collecting area, if not that of aperture and obstruction; Hubble's passbands include its obstruction",
    ),
    Key::optional("throughput", "number", "1", "recorded fraction of the light, in addition to the passband"),
    Key::optional("psf", "list of tables", "airy", "point-spread functions, applied in sequence, [[instrument.psf]]"),
    Key::optional("pixel_scale", "angle", "the picture's", "angle per detector pixel; the camera's pixels must be at least as fine"),
    Key::optional(
        "sky",
        "list of texts",
        "dark",
        "sky brightness in mag/arcsec2, such as \"21.6 mag\": one for all passbands, or one per passband",
    ),
    Key::optional(
        "allow_foreign_filters",
        "boolean",
        "false",
        "allow catalogue passbands of other instruments; those of [[band]] always are",
    ),
    Key::optional("sky_system", "text", "ab", "magnitude system of `sky`: ab, st or vega"),
    Key::optional("subtract_sky", "boolean", "true", "subtract the mean sky from the master; its noise remains"),
    Key::optional("dark_current", "dark current", "0 e/s", "dark current per pixel"),
    Key::optional("read_noise", "charge", "0 e", "read noise per pixel, standard deviation"),
    Key::optional("gain", "gain", "1 e/ADU", "electrons of a count"),
    Key::optional("bias", "counts", "what reading needs", "counts of an empty pixel; default: six times the read noise"),
    Key::optional("full_well", "charge", "none", "full well, electrons per pixel"),
    Key::optional("bits", "integer", "16", "bits per count, up to 16"),
    Key::optional("pixel_size", "length", "10 um", "edge of a pixel, for cosmic rays"),
    Key::optional("cosmic_rays", "rate of hits", "0 /cm2/s", "rate of cosmic-ray hits"),
    Key::optional(
        "mosaic",
        "list of texts",
        "none",
        "passbands of 2 x 2 pixels of a colour sensor, row by row from the upper left; [] for none",
    ),
    Key::optional("exposure", "time", "60 s", "exposure of a frame"),
    Key::optional("frames", "integer", "1", "number of frames"),
    Key::optional("seed", "integer", "1", "seed of the noise"),
];

/// The zero points by name.
const SYSTEMS: [(&str, RadianceUnit); 3] = [("ab", RadianceUnit::Ab), ("st", RadianceUnit::St), ("vega", RadianceUnit::Vega)];

fn build(section: &Section, inputs: &Inputs) -> Result<Instrument> {
    let keys: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
    section.check_keys(&keys)?;
    let aperture_m = section.positive::<Length>("aperture")?.map(|length| length.0 * PARSEC);
    let mut own = match (section.text("preset")?, aperture_m) {
        (Some(name), _) => section.wrap("preset", preset(name))?,
        (None, Some(aperture_m)) => Instrument::of_aperture(aperture_m),
        (None, None) => return Err(section.error("aperture", "an instrument requires a \"preset\" or an \"aperture\" such as \"0.2 m\"")),
    };
    set(&mut own.aperture_m, aperture_m);
    // What another aperture collects is not what the preset's did.
    if aperture_m.is_some() || section.has("obstruction") {
        own.collecting_area_m2 = None;
    }
    set(&mut own.obstruction, section.number("obstruction", 0.0..=0.99)?);
    own.collecting_area_m2 = section.positive::<Area>("collecting_area")?.map(|area| area.0).or(own.collecting_area_m2);
    set(&mut own.throughput, section.number("throughput", 1e-6..=1.0)?);
    let spread = section.tables("psf")?;
    if !spread.is_empty() {
        own.psf = spread.iter().map(|table| build_kind("point-spread function", psf::KINDS, table, inputs)).collect::<Result<_>>()?;
    }
    own.pixel_rad = section.positive::<Angle>("pixel_scale")?.map(|angle| angle.0).or(own.pixel_rad);
    set(&mut own.allow_foreign_filters, section.flag("allow_foreign_filters")?);
    own.sky = sky(section, own.sky)?;
    set(&mut own.subtract_sky, section.flag("subtract_sky")?);
    let detector = &mut own.detector;
    set(&mut detector.dark_current, not_negative::<DarkCurrent>(section, "dark_current")?);
    set(&mut detector.read_noise, not_negative::<Charge>(section, "read_noise")?);
    set(&mut detector.gain, section.positive::<Gain>("gain")?.map(|gain| gain.0));
    set(&mut detector.bias, not_negative::<Counts>(section, "bias")?);
    if !section.has("bias") && (section.has("read_noise") || section.has("gain")) {
        detector.bias = detector.bias.max(detector.least_bias());
    }
    set(&mut detector.full_well, section.positive::<Charge>("full_well")?.map(|charge| charge.0));
    set(&mut detector.bits, section.integer("bits", 1..=16)?.map(|bits| bits as u32));
    set(&mut detector.pixel_um, section.positive::<Length>("pixel_size")?.map(|length| length.0 * PARSEC * 1e6));
    set(&mut detector.cosmic_rays, not_negative::<HitRate>(section, "cosmic_rays")?);
    if let Some(names) = section.texts("mosaic")? {
        let square: Option<[&str; 4]> = names.try_into().ok();
        let wrong = || {
            section
                .error("mosaic", "a mosaic must name the passbands of four pixels, such as [\"R\", \"G\", \"G\", \"B\"], or be [] for none")
        };
        detector.mosaic = match square {
            Some(square) => Some(square.map(str::to_owned)),
            None if section.texts("mosaic")?.is_some_and(|names| names.is_empty()) => None,
            None => return Err(wrong()),
        };
    }
    set(&mut own.exposure_s, section.positive::<Time>("exposure")?.map(|time| time.0));
    set(&mut own.frames, section.integer("frames", 1..=MAX_FRAMES as i64)?.map(|number| number as usize));
    set(&mut own.seed, section.integer("seed", 0..=i64::MAX)?.map(|number| number as u64));
    Ok(own)
}

impl Instrument {
    /// Reads an instrument from its properties, those of a table `[instrument]`.
    ///
    /// # Errors
    /// If a key is unknown or a value wrong, or it is no instrument; its place is said.
    pub fn from_properties(table: &Table, inputs: &Inputs) -> Result<Self> {
        let section = Section::new(table, "instrument");
        let instrument = build(&section, inputs)?;
        instrument.check().map_err(|error| {
            // A message begins with what it is about.
            let words = error.to_string();
            let key = KEYS.iter().find(|key| words.starts_with(&key.name.replace('_', " "))).map_or("preset", |key| key.name);
            section.error(key, words)
        })?;
        Ok(instrument)
    }
}

fn set<T>(own: &mut T, said: Option<T>) {
    if let Some(said) = said {
        *own = said;
    }
}

/// A quantity that is zero or more.
fn not_negative<Q: Quantity + std::fmt::Display>(section: &Section, key: &str) -> Result<Option<f64>> {
    match section.quantity::<Q>(key)? {
        Some(quantity) if quantity.internal() < 0.0 => {
            Err(section
                .error(key, format!("{quantity} is out of range; the {} must be at least zero, such as \"{}\"", Q::NAME, Q::EXAMPLE)))
        }
        quantity => Ok(quantity.map(Quantity::internal)),
    }
}

fn sky(section: &Section, before: Sky) -> Result<Sky> {
    let names = SYSTEMS.map(|(name, _)| name);
    let system =
        section.choice("sky_system", &names)?.and_then(|name| SYSTEMS.iter().find(|(own, _)| *own == name).map(|(_, system)| *system));
    let Some(said) = section.texts("sky")? else {
        if system.is_some() {
            section.refuse(&["sky_system"], "\"sky\"")?;
        }
        return Ok(before);
    };
    let magnitude = |text: &&str| section.wrap("sky", Magnitude::parse(text)).map(|magnitude| magnitude.0);
    let magnitudes = said.iter().map(magnitude).collect::<Result<Vec<f64>>>()?;
    let brightness = if magnitudes.is_empty() { Brightness::Dark } else { Brightness::Listed(magnitudes) };
    Ok(Sky { system: system.unwrap_or(RadianceUnit::Ab), brightness })
}

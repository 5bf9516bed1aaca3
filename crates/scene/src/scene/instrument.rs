//! The `[instrument]` table: what records the picture.

use spectra::constants::PARSEC;
use spectra::units::{Angle, Area, Charge, Counts, DarkCurrent, Gain, HitRate, Length, Magnitude, Time};

use crate::data::Inputs;
use crate::error::Result;
use crate::instrument::{Brightness, Instrument, MAX_FRAMES, Sky, preset, psf};
use crate::observation::RadianceUnit;
use crate::properties::{
    Choice, Choices, Flag, Integer, Key, KeyRow, Number, OrDefault, Quantities, Section, Table, Tables, Text, Texts, build_kind,
};

const PRESET: Key<Text> = Key::text("preset", "predefined instrument; other keys override its values").of("instruments");
const APERTURE: Key<Length> =
    Key::quantity::<Length>("aperture", "diameter of the aperture; required without a preset").positive().otherwise("of the preset");
const OBSTRUCTION: Key<Number, OrDefault> =
    Key::number("obstruction", "diameter of the central obstruction relative to the aperture").range(0.0..=0.99).default(0.0);
const COLLECTING_AREA: Key<Area> = Key::quantity::<Area>(
    "collecting_area",
    "collecting area, if not that of aperture and obstruction; Hubble's passbands include its obstruction",
)
.positive()
.otherwise("of the aperture");
const THROUGHPUT: Key<Number, OrDefault> =
    Key::number("throughput", "recorded fraction of the light, in addition to the passband").range(1e-6..=1.0).default(1.0);
const PSF: Key<Tables> = Key::tables("psf", "point-spread functions, applied in sequence, [[instrument.psf]]").otherwise("airy");
const PIXEL_SCALE: Key<Angle> =
    Key::quantity::<Angle>("pixel_scale", "angle per detector pixel; the camera's pixels must be at least as fine")
        .positive()
        .otherwise("the picture's");
const SKY: Key<Quantities<Magnitude>> =
    Key::quantities("sky", "sky brightness per square arcsecond: one for all passbands, or one per passband")
        .otherwise("dark")
        .example("[\"21 mag\"]");
const ALLOW_FOREIGN_FILTERS: Key<Flag, OrDefault> =
    Key::flag("allow_foreign_filters", "allow catalogue passbands of other instruments; those of [[band]] always are").default(false);
const SKY_SYSTEM: Key<Choice<System>, OrDefault> = Key::choice("sky_system", "magnitude system of `sky`").default("ab").needs("sky");
const SUBTRACT_SKY: Key<Flag, OrDefault> =
    Key::flag("subtract_sky", "subtract the mean sky from the master; its noise remains").default(true);
const DARK_CURRENT: Key<DarkCurrent, OrDefault> =
    Key::quantity::<DarkCurrent>("dark_current", "dark current per pixel").not_negative().default("0 e/s");
const READ_NOISE: Key<Charge, OrDefault> =
    Key::quantity::<Charge>("read_noise", "read noise per pixel, standard deviation").not_negative().default("0 e");
const GAIN: Key<Gain, OrDefault> = Key::quantity::<Gain>("gain", "electrons of a count").positive().default("1 e/ADU");
const BIAS: Key<Counts> = Key::quantity::<Counts>("bias", "counts of an empty pixel; default: six times the read noise")
    .not_negative()
    .otherwise("what reading needs");
const FULL_WELL: Key<Charge> = Key::quantity::<Charge>("full_well", "full well, electrons per pixel").positive();
const BITS: Key<Integer<u32>, OrDefault> = Key::integer("bits", "bits per count").range(1..=16).default(16);
const PIXEL_SIZE: Key<Length, OrDefault> =
    Key::quantity::<Length>("pixel_size", "edge of a pixel, for cosmic rays").positive().default("10 um");
const COSMIC_RAYS: Key<HitRate, OrDefault> =
    Key::quantity::<HitRate>("cosmic_rays", "rate of cosmic-ray hits").not_negative().default("0 /cm2/s");
const MOSAIC: Key<Texts> =
    Key::texts("mosaic", "passbands of 2 x 2 pixels of a colour sensor, row by row from the upper left; [] for none").example("[]");
const EXPOSURE: Key<Time, OrDefault> = Key::quantity::<Time>("exposure", "exposure of a frame").positive().default("60 s");
const FRAMES: Key<Integer<usize>, OrDefault> = Key::integer("frames", "number of frames").range(1..=MAX_FRAMES as i64).default(1);
const SEED: Key<Integer<u64>, OrDefault> = Key::integer("seed", "seed of the noise").default(1);

pub(super) const KEYS: &[KeyRow] = &[
    PRESET.row,
    APERTURE.row,
    OBSTRUCTION.row,
    COLLECTING_AREA.row,
    THROUGHPUT.row,
    PSF.row,
    PIXEL_SCALE.row,
    SKY.row,
    ALLOW_FOREIGN_FILTERS.row,
    SKY_SYSTEM.row,
    SUBTRACT_SKY.row,
    DARK_CURRENT.row,
    READ_NOISE.row,
    GAIN.row,
    BIAS.row,
    FULL_WELL.row,
    BITS.row,
    PIXEL_SIZE.row,
    COSMIC_RAYS.row,
    MOSAIC.row,
    EXPOSURE.row,
    FRAMES.row,
    SEED.row,
];

/// Zero point of sky magnitudes.
#[derive(Clone, Copy)]
struct System(RadianceUnit);

impl Choices for System {
    const ROWS: &'static [(&'static str, Self)] =
        &[("ab", Self(RadianceUnit::Ab)), ("st", Self(RadianceUnit::St)), ("vega", Self(RadianceUnit::Vega))];
}

fn build(section: &Section, inputs: &Inputs) -> Result<Instrument> {
    section.check(KEYS)?;
    let aperture_m = section.read(&APERTURE)?.map(|length| length.0 * PARSEC);
    let mut instrument = match (section.read(&PRESET)?, aperture_m) {
        (Some(name), _) => section.wrap(&PRESET, preset(name))?,
        (None, Some(aperture_m)) => Instrument::of_aperture(aperture_m),
        (None, None) => return Err(section.error(&APERTURE, "an instrument requires a \"preset\" or an \"aperture\" such as \"0.2 m\"")),
    };
    set(&mut instrument.aperture_m, aperture_m);
    // What another aperture collects is not what the preset's did.
    if aperture_m.is_some() || section.has(&OBSTRUCTION) {
        instrument.collecting_area_m2 = None;
    }
    set(&mut instrument.obstruction, section.stated(&OBSTRUCTION)?);
    instrument.collecting_area_m2 = section.read(&COLLECTING_AREA)?.map(|area| area.0).or(instrument.collecting_area_m2);
    set(&mut instrument.throughput, section.stated(&THROUGHPUT)?);
    if let Some(spread) = section.read(&PSF)?.filter(|spread| !spread.is_empty()) {
        instrument.psf =
            spread.iter().map(|table| build_kind("point-spread function", psf::KINDS, table, inputs)).collect::<Result<_>>()?;
    }
    instrument.pixel_rad = section.read(&PIXEL_SCALE)?.map(|angle| angle.0).or(instrument.pixel_rad);
    set(&mut instrument.allow_foreign_filters, section.stated(&ALLOW_FOREIGN_FILTERS)?);
    instrument.sky = sky(section, instrument.sky)?;
    set(&mut instrument.subtract_sky, section.stated(&SUBTRACT_SKY)?);
    let detector = &mut instrument.detector;
    set(&mut detector.dark_current, section.stated(&DARK_CURRENT)?.map(|current| current.0));
    set(&mut detector.read_noise, section.stated(&READ_NOISE)?.map(|charge| charge.0));
    set(&mut detector.gain, section.stated(&GAIN)?.map(|gain| gain.0));
    set(&mut detector.bias, section.stated(&BIAS)?.map(|counts| counts.0));
    if !section.has(&BIAS) && (section.has(&READ_NOISE) || section.has(&GAIN)) {
        detector.bias = detector.bias.max(detector.least_bias());
    }
    set(&mut detector.full_well, section.read(&FULL_WELL)?.map(|charge| charge.0));
    set(&mut detector.bits, section.stated(&BITS)?);
    set(&mut detector.pixel_um, section.stated(&PIXEL_SIZE)?.map(|length| length.0 * PARSEC * 1e6));
    set(&mut detector.cosmic_rays, section.stated(&COSMIC_RAYS)?.map(|rate| rate.0));
    if let Some(names) = section.read(&MOSAIC)? {
        detector.mosaic = match names[..] {
            [] => None,
            [a, b, c, d] => Some([a, b, c, d].map(str::to_owned)),
            _ => {
                let message = "a mosaic must name the passbands of four pixels, such as [\"R\", \"G\", \"G\", \"B\"], or be [] for none";
                return Err(section.error(&MOSAIC, message));
            }
        };
    }
    set(&mut instrument.exposure_s, section.stated(&EXPOSURE)?.map(|time| time.0));
    set(&mut instrument.frames, section.stated(&FRAMES)?);
    set(&mut instrument.seed, section.stated(&SEED)?);
    Ok(instrument)
}

impl Instrument {
    /// Reads an instrument from its properties, those of a table `[instrument]`.
    ///
    /// # Errors
    /// If a key is unknown or a value wrong, or it is no instrument; the error states its place.
    pub fn from_properties(table: &Table, inputs: &Inputs) -> Result<Self> {
        let section = Section::new(table, "instrument");
        let instrument = build(&section, inputs)?;
        instrument.check().map_err(|error| {
            let key = error.subject().and_then(|subject| KEYS.iter().find(|key| key.name == subject)).unwrap_or(&PRESET.row);
            section.error(key, error.to_string())
        })?;
        Ok(instrument)
    }
}

fn set<T>(setting: &mut T, stated: Option<T>) {
    if let Some(value) = stated {
        *setting = value;
    }
}

fn sky(section: &Section, before: Sky) -> Result<Sky> {
    let Some(magnitudes) = section.read(&SKY)? else { return Ok(before) };
    let brightness =
        if magnitudes.is_empty() { Brightness::Dark } else { Brightness::Listed(magnitudes.iter().map(|magnitude| magnitude.0).collect()) };
    Ok(Sky { system: section.read(&SKY_SYSTEM)?.0, brightness })
}

//! Errors of the spectral library that a user can correct.

/// Errors of this crate; each says what was wrong and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectraError {
    /// A quantity that does not parse.
    #[error("\"{text}\" is not {} {quantity}: {reason}; write it like \"{example}\"", article(quantity))]
    Quantity {
        /// The text that was written.
        text: String,
        /// The quantity that it should have been.
        quantity: &'static str,
        /// Why it is no such quantity.
        reason: String,
        /// A text that is one.
        example: &'static str,
    },
    /// A name that a catalogue does not hold.
    #[error("unknown {noun} \"{name}\"{}; {known}", nearest_hint(nearest))]
    Unknown {
        /// The noun of the catalogue, such as a passband.
        noun: &'static str,
        /// The name that was asked for.
        name: String,
        /// The nearest name that exists.
        nearest: Option<String>,
        /// All names, or their number if they are many.
        known: String,
    },
    /// A value outside of the range in which it means something.
    #[error("{what} is {}, outside of its validity range {low} to {high}", crate::number::short(*value))]
    Range {
        /// The quantity that was given.
        what: String,
        /// The value that was given.
        value: f64,
        /// The lowest value that would be right.
        low: f64,
        /// The highest value that would be right.
        high: f64,
    },
    /// A table that cannot be read.
    #[error("{name}: {reason}")]
    Table {
        /// The name of the table.
        name: String,
        /// Problem and remedy.
        reason: String,
    },
    /// A law or a spectrum that does not reach over all wavelengths that are asked of it.
    #[error("{0}")]
    Reach(String),
    /// A parameter that an extinction law does not take.
    #[error("{0}")]
    Law(String),
    /// A way to say how bright something is that does not go with its spectrum.
    #[error("{0}")]
    Brightness(String),
    /// A spectral type that no star has.
    #[error("{0}")]
    SpectralType(String),
    /// A temperature or gravity outside of the model atmospheres.
    #[error("{0}")]
    Atmosphere(String),
    /// An invalid analytic passband.
    #[error("{0}")]
    Passband(String),
    /// A palette that is made for other bands.
    #[error("{0}")]
    Palette(String),
    /// A polynomial or a basis of exponentials that cannot be made.
    #[error("{0}")]
    Fit(String),
    /// A spectral rule that does not hold for this law or these settings.
    #[error("{0}")]
    Rule(String),
}

/// The indefinite article of a noun.
pub fn article(noun: &str) -> &'static str {
    if noun.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" }
}

fn nearest_hint(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|n| format!(", did you mean \"{n}\"?")).unwrap_or_default()
}

/// The candidate that is closest to `name`, if any is close.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    // "V" is short for "johnson-V", "F656N" for "hst-wfc3-f656n".
    if let Some(whole) = candidates.iter().find(|c| c.rsplit_once('-').is_some_and(|(_, last)| last.eq_ignore_ascii_case(name))) {
        return Some((*whole).to_owned());
    }
    candidates
        .into_iter()
        .map(|c| (strsim::jaro_winkler(name, c), c))
        .filter(|(score, _)| *score > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c.to_owned())
}

impl SpectraError {
    /// The error for a `name` that is not among `known`; long catalogues are named, not printed.
    pub fn unknown(noun: &'static str, name: &str, known: &[&str]) -> Self {
        let listing = match known.len() {
            0 => format!("there is no {noun}"),
            1..=24 => format!("known: {}", known.join(", ")),
            count => format!("`barnard list` shows all {count}"),
        };
        SpectraError::Unknown { noun, name: name.to_owned(), nearest: nearest(name, known.iter().copied()), known: listing }
    }

    /// The error for a table called `name`.
    pub fn table(name: &str, reason: impl Into<String>) -> Self {
        SpectraError::Table { name: name.to_owned(), reason: reason.into() }
    }
}

/// The result of functions of this crate.
pub type Result<T, E = SpectraError> = std::result::Result<T, E>;

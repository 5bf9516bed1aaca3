//! Free parameters of a fit.

use barnard::error::{Error, Result};
use barnard::properties::places::{get, set};
use barnard::properties::{Form, Table, Value};
use barnard::scene::{self, Part};
use barnard::spectra::error::nearest;

/// A number of a scene that is free.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The place of its key, such as "star.0.luminosity".
    pub key: String,
    /// The least and the largest value that it may have, in the unit in which the scene says it.
    pub bounds: (f64, f64),
    /// Prior: mean and standard deviation.
    pub prior: Option<(f64, f64)>,
}

/// Ranges of keys that are wider than this times the start value do not bound a fit from above.
const NARROW: f64 = 100.0;

/// Free parameters of a scene from a text such as "star\[0\].luminosity, star\[0\].temperature=5000..30000, dust.scale~4+-0.5": keys with
/// bounds and priors in the units of the scene. Bounds are narrowed to the ranges of the keys.
///
/// # Errors
/// If a part has another form, or a key is listed twice.
pub fn free_parameters(text: &str, tree: &Table) -> Result<Vec<Parameter>> {
    let parameters: Vec<Parameter> = text.split(',').map(|part| part.trim().parse()).collect::<Result<_>>()?;
    narrowed(parameters, tree)
}

/// Free parameters of a scene with bounds narrowed to the ranges of their keys.
///
/// # Errors
/// If a key is listed twice, or bounds or a prior are empty.
pub fn narrowed(parameters: Vec<Parameter>, tree: &Table) -> Result<Vec<Parameter>> {
    if let Some(empty) = parameters.iter().find(|text_part| text_part.is_empty()) {
        let problem = format!("free parameter {} has no value within its bounds and prior", empty.key);
        return Err(Error::conflict(problem, "give LOW < HIGH and a positive standard deviation"));
    }
    if let Some(twice) =
        parameters.iter().enumerate().find(|(i, parameter)| parameters[..*i].iter().any(|other| other.key == parameter.key))
    {
        return Err(Error::conflict(format!("free parameter {} is listed twice", twice.1.key), "list each key once"));
    }
    Ok(parameters.into_iter().map(|parameter| parameter.narrowed(tree)).collect())
}

impl Parameter {
    /// True if no value is within the bounds, or the prior has no width.
    fn is_empty(&self) -> bool {
        let Self { bounds: (low, high), prior, .. } = *self;
        !(low < high && prior.is_none_or(|(mean, sigma)| mean.is_finite() && sigma.is_finite() && sigma > 0.0))
    }

    /// The parameter with bounds within the range of its key.
    fn narrowed(mut self, tree: &Table) -> Self {
        let known = scene::parameter(tree, &self.key);
        let Some((known, start)) = known.and_then(|known| Some((known.range(), *known.numbers()?.0.first()?))) else { return self };
        let (low, high) = known;
        let is_narrow = self.bounds.1.is_finite() || high - low <= NARROW * start.abs();
        self.bounds.0 = self.bounds.0.max(low);
        self.bounds.1 = if is_narrow { self.bounds.1.min(high) } else { self.bounds.1 };
        self
    }
}

impl std::str::FromStr for Parameter {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            let example = "KEY, KEY=LOW..HIGH or KEY~MEAN+-SIGMA, such as star[0].temperature=5000..30000";
            Error::malformed("free parameter", text, example)
        };
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong);
        let (rest, prior) = match text.split_once('~') {
            None => (text, None),
            Some((rest, prior)) => {
                let (mean, sigma) = prior.split_once("+-").or_else(|| prior.split_once('±')).ok_or_else(wrong)?;
                (rest, Some((number(mean)?, number(sigma)?)))
            }
        };
        let (key, bounds) = match rest.split_once('=') {
            None => (rest, (f64::NEG_INFINITY, f64::INFINITY)),
            Some((key, bounds)) => {
                let (low, high) = bounds.split_once("..").ok_or_else(wrong)?;
                let end = |text: &str, open: f64| if text.trim().is_empty() { Ok(open) } else { number(text) };
                (key, (end(low, f64::NEG_INFINITY)?, end(high, f64::INFINITY)?))
            }
        };
        let parameter = Self { key: key.trim().to_owned(), bounds, prior };
        if parameter.key.is_empty() || parameter.is_empty() { Err(wrong()) } else { Ok(parameter) }
    }
}

/// Position and form of a free parameter.
#[derive(Debug, Clone)]
pub(crate) struct FreeParameter {
    key: String,
    form: Form,
    /// Parts of the scene that it changes.
    pub parts: &'static [Part],
}

impl FreeParameter {
    /// Finds a parameter in a scene; what it says there is given too.
    pub fn of(tree: &Table, parameter: &Parameter) -> Result<(Self, f64)> {
        let wrong = |problem: String| Error::conflict(format!("free parameter {}: {problem}", parameter.key), "free keys have one number");
        let found = get(tree, &parameter.key).map_err(wrong)?;
        let missing = || {
            let (table, key) = parameter.key.rsplit_once('.').unwrap_or(("", &parameter.key));
            let siblings = match get(tree, table).ok().flatten().map(|property| &property.value) {
                Some(Value::Table(table)) => table.iter().map(|(key, _)| key).collect(),
                _ => Vec::new(),
            };
            let hint = nearest(key, siblings).map(|near| format!("; did you mean \"{near}\"?")).unwrap_or_default();
            Error::missing(format!("a start value of {}", parameter.key), format!("write the key in the scene{hint}"))
        };
        let found = found.ok_or_else(missing)?;
        match Form::of(&found.value) {
            Some((form, numbers)) if numbers.len() == 1 => {
                let parts = scene::parameter(tree, &parameter.key).map_or(&[][..], |known| known.parts);
                Ok((Self { key: parameter.key.clone(), form, parts }, numbers[0]))
            }
            _ => Err(wrong(format!("the scene has {}", found.value))),
        }
    }

    /// Its unit, as the scene writes it; nothing where it has none.
    pub fn unit(&self) -> &str {
        match &self.form {
            Form::Quantity(unit) => unit,
            Form::Number | Form::List => "",
        }
    }

    /// Says a value in its place.
    pub fn set(&self, tree: &mut Table, value: f64) -> Result<()> {
        set(tree, &self.key, self.form.value(&[value]).into())
            .map_err(|reason| Error::conflict(format!("free parameter {}: {reason}", self.key), "free another key"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read() {
        let free = |text: &str| free_parameters(text, &Table::default());
        let all = free("star.0.luminosity, star.0.temperature=5000..30000,dust.scale=0..~4+-0.5").unwrap();
        let keys: Vec<&str> = all.iter().map(|parameter| parameter.key.as_str()).collect();
        assert_eq!(keys, ["star.0.luminosity", "star.0.temperature", "dust.scale"]);
        assert_eq!((all[1].bounds, all[2].bounds.0, all[2].prior), ((5000.0, 30000.0), 0.0, Some((4.0, 0.5))));
        // The range of a key bounds it: an albedo lies between 0 and 1, a temperature above zero.
        let mut dust = Table::default();
        dust.insert("albedo", Value::Number(0.5));
        dust.insert("scale", Value::Text("4 mag/pc".into()));
        let mut tree = Table::default();
        tree.insert("dust", Value::Table(dust));
        let bounds: Vec<_> = free_parameters("dust.albedo, dust.scale", &tree).unwrap().iter().map(|parameter| parameter.bounds).collect();
        assert_eq!(bounds, [(0.0, 1.0), (0.0, f64::INFINITY)]);
        assert_eq!(free_parameters("dust.albedo=0.2..7", &tree).unwrap()[0].bounds, (0.2, 1.0));
        for wrong in ["", "a=1", "a=2..1", "a~3", "a~3+-0", "a~x+-1", "a,a", "=1..2", "a=1..nan"] {
            assert!(free(wrong).unwrap_err().to_string().contains("free parameter"), "{wrong}");
        }
    }
}

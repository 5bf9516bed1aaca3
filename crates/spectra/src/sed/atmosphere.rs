//! Hot stars by their temperature and gravity: the model atmospheres of Kurucz 1993, between 10 000 and 50 000 K.
//!
//! ln F_λ is linear in ln T and in log g between the models; where a model sends nothing at a wavelength, F_λ itself
//! is. Against models that were left out, at half the grid's resolution, that is 0.4 % from 300 to 1100 nm above 19 000
//! K and 1 % above 14 000 K.
//!
//! | symbol | variable | unit |
//! |---|---|---|
//! | F_λ | `flux` | W m⁻² µm⁻¹ at the star's surface |
//! | T | `temperature` | K |
//! | log g | `log_g` | dex of cm s⁻² |

use std::sync::{Arc, OnceLock};

use super::embedded::once;
use crate::embedded::embedded_columns;
use crate::error::{Result, SpectraError};
use crate::table::Table;
use crate::units::Temperature;

const KURUCZ: &str = include_str!("../../data/stars/kurucz.csv");

/// Models of one temperature, by ascending gravity.
struct Isotherm {
    temperature: f64,
    models: Vec<(f64, Vec<f64>)>,
}

struct GravityGrid {
    lambda_um: Vec<f64>,
    isotherms: Vec<Isotherm>,
}

/// T and log g of a column such as `t10000g20`.
fn parameters(column: &str) -> Option<(f64, f64)> {
    let (temperature, tenths) = column.strip_prefix('t')?.split_once('g')?;
    Some((temperature.parse().ok()?, tenths.parse::<f64>().ok()? / 10.0))
}

fn grid() -> Result<&'static GravityGrid> {
    static GRID: OnceLock<GravityGrid> = OnceLock::new();
    once(&GRID, || {
        let head = KURUCZ.lines().find_map(|line| line.strip_prefix("wavelength_nm,")).unwrap_or("");
        let names: Vec<&str> = head.split(',').collect();
        let mut columns = embedded_columns("kurucz", KURUCZ, names.len() + 1)?.into_iter();
        let lambda_um = columns.next().unwrap_or_default().iter().map(|nm| nm * 1e-3).collect();
        let mut isotherms: Vec<Isotherm> = Vec::new();
        for (name, flux) in names.iter().zip(columns) {
            let (temperature, log_g) =
                parameters(name).ok_or_else(|| SpectraError::table("kurucz", format!("\"{name}\" names no model")))?;
            // 1 erg s⁻¹ cm⁻² nm⁻¹ is 1 W m⁻² µm⁻¹.
            match isotherms.last_mut() {
                Some(last) if last.temperature == temperature => last.models.push((log_g, flux)),
                _ => isotherms.push(Isotherm { temperature, models: vec![(log_g, flux)] }),
            }
        }
        Ok(GravityGrid { lambda_um, isotherms })
    })
}

/// The two neighbours of `at` among ascending `places`, and how far it is from the first to the second [1].
fn between(places: impl Iterator<Item = f64> + Clone, at: f64) -> Option<(usize, usize, f64)> {
    let above = places.clone().position(|place| place >= at)?;
    let high = places.clone().nth(above)?;
    if high == at {
        return Some((above, above, 0.0));
    }
    let low = places.clone().nth(above.checked_sub(1)?)?;
    Some((above - 1, above, (at - low) / (high - low)))
}

/// The spectrum between `a` and `b`: by their logarithms where both shine.
fn blend(a: &[f64], b: &[f64], share: f64) -> Vec<f64> {
    let one = |(a, b): (&f64, &f64)| match a.min(*b) > 0.0 {
        true => a * (b / a).powf(share),
        false => a + share * (b - a),
    };
    a.iter().zip(b).map(one).collect()
}

impl Isotherm {
    fn gravities(&self) -> impl Iterator<Item = f64> + Clone {
        self.models.iter().map(|(log_g, _)| *log_g)
    }

    /// F_λ at a gravity; none where no model is as light or as heavy.
    fn at(&self, log_g: f64) -> Option<Vec<f64>> {
        let (low, high, share) = between(self.gravities(), log_g)?;
        Some(blend(&self.models[low].1, &self.models[high].1, share))
    }
}

/// The flux at the surface of a star of `temperature` and surface gravity `log_g` [dex of cm s⁻²], F_λ [W m⁻² µm⁻¹]
/// over λ \[µm\].
///
/// # Errors
/// Outside of the grid: the hotter a star, the heavier must it be to hold together.
pub fn atmosphere(temperature: Temperature, log_g: f64) -> Result<Arc<Table>> {
    let grid = grid()?;
    let temperatures = grid.isotherms.iter().map(|i| i.temperature.ln());
    let Some((low, high, share)) = between(temperatures, temperature.0.ln()) else {
        let end = |i: Option<&Isotherm>| i.map_or(0.0, |i| i.temperature);
        return Err(SpectraError::Atmosphere(format!(
            "the model atmospheres cover {} to {} K, but the temperature is {temperature}; use a spectral type or a black body",
            end(grid.isotherms.first()),
            end(grid.isotherms.last())
        )));
    };
    let (cool, hot) = (&grid.isotherms[low], &grid.isotherms[high]);
    let (Some(cooler), Some(hotter)) = (cool.at(log_g), hot.at(log_g)) else {
        let least = hot.gravities().next().unwrap_or(0.0);
        let most = hot.gravities().last().unwrap_or(0.0);
        return Err(SpectraError::Atmosphere(format!(
            "at {temperature} the model atmospheres cover log g = {least} to {most} (cgs), but log_g is {log_g}"
        )));
    };
    let flux = blend(&cooler, &hotter, share);
    Ok(Arc::new(Table::new("model atmosphere", grid.lambda_um.clone(), flux)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::STEFAN_BOLTZMANN;
    use crate::passband::Passband;
    use crate::sed::{star, vega};

    /// ∫ F_λ dλ = σ T⁴, which is what effective temperature means; between the models as well as at them.
    #[test]
    fn atmospheres_send_what_their_temperature_says() {
        for (t, log_g, within) in [
            (10000.0, 4.0, 0.003),
            (16000.0, 3.0, 0.003),
            (30000.0, 4.0, 0.003),
            (50000.0, 5.0, 0.003),
            (10250.0, 3.75, 0.02),
            (33333.0, 4.2, 0.01),
        ] {
            let flux = atmosphere(Temperature(t), log_g).unwrap();
            let (x, y) = (flux.x(), flux.y());
            let sum: f64 = (1..x.len()).map(|i| 0.5 * (x[i] - x[i - 1]) * (y[i] + y[i - 1])).sum();
            let ratio = sum / (STEFAN_BOLTZMANN * f64::powi(t, 4));
            assert!((ratio - 1.0).abs() < within, "{t} K, {log_g}: {ratio}");
        }
    }

    /// Models against observed stars of the temperatures that Pickles 1998 (table 2) gives his types: B−V. His mean
    /// spectra scatter themselves: B0V is 0.03 mag bluer than tables of such stars.
    #[test]
    fn atmospheres_have_the_colours_of_stars() {
        let [b, v] = ["johnson-B", "johnson-V"].map(|name| Passband::by_name(name).unwrap());
        let colour = |spectrum: &Table| {
            let magnitude =
                |band: &Passband| -2.5 * (band.integrate(|l| spectrum.at_or_zero(l)) / band.integrate(|l| vega().unwrap().at(l))).log10();
            magnitude(&b) - magnitude(&v)
        };
        let types = [("O9V", 35481.0), ("B0V", 28184.0), ("B1V", 22387.0), ("B3V", 19055.0), ("B8V", 11749.0), ("B9V", 10715.0)];
        let off = types.map(|(name, temperature)| {
            let model = colour(&atmosphere(Temperature(temperature), 4.0).unwrap());
            model - colour(&star(name).unwrap())
        });
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        assert!(mean.abs() < 0.03 && off.iter().all(|o| o.abs() < 0.08), "{mean:.3} of {off:.3?}");
    }

    #[test]
    fn what_the_grid_does_not_hold_is_refused() {
        for (t, log_g, expected) in [
            (9999.0, 4.0, "cover 10000 to 50000 K"),
            (50001.0, 5.0, "cover 10000"),
            (45000.0, 4.0, "cover log g = 4.5 to 5"),
            (20000.0, 5.5, "cover log g = 3 to 5"),
            (f64::NAN, 4.0, "temperature is NaN"),
            (20000.0, f64::NAN, "log_g is NaN"),
        ] {
            let message = atmosphere(Temperature(t), log_g).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}

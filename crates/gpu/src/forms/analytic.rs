//! Closed forms of polynomial spectra, where f32 keeps their digits.

use barnard::plan::{ClosedForm, Plan};
use spectra::polynomial::MAX_DEGREE;
use spectra::rule::Form;

use super::{Contents, FormEntry, Heads, Turns};
use crate::error::{GpuError, Result};

pub(super) const ENTRY: FormEntry = FormEntry {
    name: "analytic",
    is_form: |form| matches!(form, Form::Analytic(_)),
    wgsl: include_str!("../shaders/forms/analytic.wgsl"),
    bounded: false,
    is_short: false,
    // Two ends at two depths.
    turns: Turns { each_band: 4 * TURNS_OF_AN_END, each_term: 0 },
    heads: Heads::LightsAndBands,
    fill,
};

/// Levels of the continued fraction or the series, recurrences up and down, powers; lines are few.
const TURNS_OF_AN_END: usize = 24 + 3 * (MAX_DEGREE + 3) + 8;

fn fill(plan: &Plan, lights: &[usize], contents: &mut Contents) -> Result<()> {
    let bands = &plan.spectral().bands;
    for (i, light) in lights.iter().enumerate() {
        for (b, band) in bands.iter().enumerate() {
            let Form::Analytic(analytic) = &band.rule.form else { continue };
            let head = match ClosedForm::new(analytic, *light, plan.spectral().accuracy) {
                ClosedForm::Dark => [0.0; 4],
                ClosedForm::Double => {
                    return Err(GpuError::Digits { light: plan.lights()[*light].name.clone(), band: band.band.name().into() });
                }
                ClosedForm::Single { ends, lines, extent } => {
                    let powers = ends.first().map_or(0, |end| end.factors.len());
                    let head = [contents.here(), ends.len() as f32, powers as f32, lines.len() as f32];
                    let of_ends = ends.iter().flat_map(|end| std::iter::once(end.x_per_depth).chain(end.factors.iter().flatten().copied()));
                    let of_lines = lines.iter().flat_map(|line| [line.0, line.1]);
                    let flat: Vec<f32> = [extent.spread, extent.middle].into_iter().chain(of_ends).chain(of_lines).collect();
                    contents.tables.numbers(&flat, 0);
                    head
                }
            };
            contents.heads[i * bands.len() + b] = head;
        }
    }
    Ok(())
}

//! Tables of ln F: in a thin segment the medium is grey with the local mean extinction and its bend, in a thick one
//! light is what the table leaves behind both ends.

use spectra::rule::{DepthTable, Form};

use super::{Bases, DepthSpan};
use crate::packet::{LANES, Lane, RowPlace, exp, mean_transmittance, sinhc};
use crate::plan::Plan;

/// A table for each light and band.
#[derive(Debug)]
pub struct LookupTerms {
    tables: Vec<Vec<LogTable>>,
}

/// ln (F(a)/F(0)) at equal steps: `spectra::rule::DepthTable::rows`.
#[derive(Debug, Clone)]
struct LogTable {
    /// Entries per unit of depth.
    per_depth: f32,
    rows: Vec<Gap>,
}

/// One gap between two entries of the table.
#[derive(Debug, Clone, Copy)]
#[repr(align(16))]
struct Gap {
    /// ln F at the entry where the gap begins.
    log: f32,
    /// The growth of ln F from there to the next entry.
    rise: f32,
    /// Half of the second derivative of ln F over the depth.
    bend: f32,
    /// ∫ F/F(0) da from where it begins on.
    left: f32,
}

impl LookupTerms {
    pub(super) fn new(plan: &Plan) -> Self {
        let table = |light: usize, form: &Form| match form {
            Form::Lookup(lookup) => {
                let t = &lookup.tables[light];
                let row = |[log, rise, bend, left]: [f32; 4]| Gap { log, rise, bend, left };
                LogTable { per_depth: (1.0 / t.step) as f32, rows: t.rows().map(|r| row(r.map(|v| v as f32))).collect() }
            }
            _ => LogTable { per_depth: 1.0, rows: Vec::new() },
        };
        let of_light = |light: usize| plan.spectral.bands.iter().map(|b| table(light, &b.rule.form)).collect();
        Self { tables: (0..plan.lights.len()).map(of_light).collect() }
    }

    #[inline(always)]
    pub(super) fn accumulate(&self, light: usize, DepthSpan { middle, half }: &DepthSpan, bases: Bases, sum: &mut [Lane]) {
        for (term, (table, sum)) in self.tables[light].iter().zip(sum).enumerate() {
            let Some(base) = bases.of(term) else { continue };
            for lane in 0..LANES {
                sum[lane] += base[lane] * table.mean(middle[lane], half[lane].abs());
            }
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, light: usize, term: usize, depth: f32) -> f32 {
        let table = &self.tables[light][term];
        let RowPlace { cell, fraction } = table.place(depth);
        exp(table.rows[cell as usize].at(fraction))
    }
}

impl LogTable {
    /// The gap in which a depth lies, and how far within; the last gap goes on.
    #[inline(always)]
    fn place(&self, depth: f32) -> RowPlace {
        let x = depth * self.per_depth;
        let cell = (x as usize).min(self.rows.len() - 1) as u32;
        RowPlace { cell, fraction: x - cell as f32 }
    }

    /// The mean of F/F(0) over depths between middle − half and middle + half.
    #[inline(always)]
    fn mean(&self, middle: f32, half: f32) -> f32 {
        let RowPlace { cell, fraction } = self.place(middle);
        let row = &self.rows[cell as usize];
        let y = row.rise * self.per_depth * half;
        let bend = row.bend * half * half;
        if y.abs() <= DepthTable::THIN && bend <= DepthTable::EVEN {
            // ∫ u² e^(−y u) du/2 over −1 … 1 is 1/3 + y²/10.
            return exp(row.at(fraction)) * (sinhc(y * y) + bend * (1.0 / 3.0 + 0.1 * y * y));
        }
        self.thick(self.place(middle - half), self.place(middle + half))
    }

    /// The mean between two places of the table, where the segment between them is thick.
    fn thick(&self, first: RowPlace, last: RowPlace) -> f32 {
        let row = |cell: u32| &self.rows[cell as usize];
        let (from, to) = (row(first.cell), row(last.cell));
        if first.cell == last.cell {
            return between(from.at(first.fraction), to.at(last.fraction));
        }
        let before = (1.0 - first.fraction) * between(from.at(first.fraction), from.log + from.rise);
        let after = last.fraction * between(to.log, to.at(last.fraction));
        let gaps = (1.0 - first.fraction) + (last.cell - first.cell - 1) as f32 + last.fraction;
        (before + after + (row(first.cell + 1).left - to.left) * self.per_depth) / gaps
    }
}

impl Gap {
    /// ln F at a fraction of the gap.
    #[inline(always)]
    fn at(&self, fraction: f32) -> f32 {
        self.log + fraction * self.rise
    }
}

/// The mean of e^x over x that is linear between two ends.
fn between(from: f32, to: f32) -> f32 {
    mean_transmittance(-0.5 * (from + to), 0.5 * (from - to))
}

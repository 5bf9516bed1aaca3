//! Corner plots: how well parameters are known, and how they go together.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::figure::{as_png, as_svg, register_font};
use crate::{Result, StudyError};

/// What is known of a few parameters, normally distributed: each by itself on the diagonal, each pair below it.
#[derive(Debug, Clone)]
pub struct Corner {
    /// The caption of the figure.
    pub title: String,
    /// Name and description of each parameter, one line each.
    pub parameters: Vec<Vec<String>>,
    /// How two parameters go together, from −1 to 1; no number where nobody knows.
    pub correlation: Vec<Vec<f64>>,
}

/// The edge of a cell, and what is beside all of them \[px\].
const CELL: u32 = 168;
const MARGIN: u32 = 14;
const CAPTION: u32 = 34;
/// Extent of a cell \[standard errors\].
const REACH: f64 = 3.4;
/// Distances within which a pair is with a probability of 68.3 and of 95.4 %: −2 ln(1 − p) is their square.
const WITHIN: [f64; 2] = [1.515, 2.486];
const LINE: RGBColor = RGBColor(0, 114, 178);
const FRAME: RGBColor = RGBColor(130, 130, 130);

impl Corner {
    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<String> {
        as_svg(self.size(), |area| self.draw(area))
    }

    /// The figure as the bytes of a PNG file.
    ///
    /// # Errors
    /// If it cannot be drawn or encoded.
    pub fn png(&self) -> Result<Vec<u8>> {
        as_png(self.size(), |area| self.draw(area))
    }

    fn size(&self) -> (u32, u32) {
        let edge = 2 * MARGIN + CELL * self.parameters.len().max(1) as u32;
        (edge, edge + CAPTION)
    }

    fn draw<D: DrawingBackend>(&self, area: &DrawingArea<D, Shift>) -> Result<()> {
        register_font();
        let failed = |e: &dyn std::fmt::Display| StudyError::Figure("corner".into(), e.to_string());
        area.fill(&WHITE).map_err(|e| failed(&e))?;
        let count = self.parameters.len();
        let caption = TextStyle::from(("sans-serif", 20)).pos(Pos::new(HPos::Left, VPos::Top));
        area.draw(&Text::new(self.title.clone(), (MARGIN as i32, 10), caption)).map_err(|e| failed(&e))?;
        let body = area.margin(MARGIN + CAPTION, MARGIN, MARGIN, MARGIN);
        for (number, cell) in body.split_evenly((count, count)).iter().enumerate() {
            let (row, column) = (number / count, number % count);
            if row < column {
                let correlation = self.correlation[row][column];
                let words = if correlation.is_finite() { format!("{correlation:+.2}") } else { "unknown".into() };
                let style = TextStyle::from(("sans-serif", 18)).pos(Pos::new(HPos::Center, VPos::Center));
                cell.draw(&Text::new(words, (CELL as i32 / 2, CELL as i32 / 2), style)).map_err(|e| failed(&e))?;
                continue;
            }
            // A curve by itself leaves room for words above it.
            let upwards = if row == column { 0.0..2.3 } else { -REACH..REACH };
            let mut chart = ChartBuilder::on(cell).margin(4).build_cartesian_2d(-REACH..REACH, upwards.clone()).map_err(|e| failed(&e))?;
            let frame = Rectangle::new([(-REACH, upwards.start), (REACH, upwards.end)], FRAME.stroke_width(1));
            chart.draw_series([frame]).map_err(|e| failed(&e))?;
            let lines: Vec<Vec<(f64, f64)>> = match row == column {
                true => vec![(-68..=68).map(|i| f64::from(i) / 20.0).map(|x| (x, (-0.5 * x * x).exp())).collect()],
                false if !self.correlation[row][column].is_finite() => Vec::new(),
                false => WITHIN.iter().map(|distance| ellipse(self.correlation[row][column], *distance)).collect(),
            };
            chart.draw_series(lines.into_iter().map(|line| PathElement::new(line, LINE.stroke_width(2)))).map_err(|e| failed(&e))?;
            if row == column {
                for (line, words) in self.parameters[row].iter().enumerate() {
                    let style = ("sans-serif", if line == 0 { 14 } else { 12 });
                    cell.draw(&Text::new(words.clone(), (10, 10 + 16 * line as i32), style)).map_err(|e| failed(&e))?;
                }
            }
        }
        area.present().map_err(|e| failed(&e))
    }
}

/// Ellipse of equal probability of two correlated normal variables, in standard errors.
fn ellipse(correlation: f64, distance: f64) -> Vec<(f64, f64)> {
    // Along both diagonals, which are its axes.
    let [along, across] = [1.0 + correlation, 1.0 - correlation].map(|factor| distance * (0.5 * factor).max(0.0).sqrt());
    let place = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / 96.0).sin_cos();
        (along * cos + across * sin, along * cos - across * sin)
    };
    (0..=96).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ellipse is where the quadratic form of the correlation matrix is what it should be, and reaches one standard error to each side
    /// per unit of distance.
    #[test]
    fn ellipses_are_of_equal_probability() {
        for correlation in [-0.9, 0.0, 0.5, 1.0] {
            for (x, y) in ellipse(correlation, 2.0) {
                let rest = 1.0 - correlation * correlation;
                let form = if rest > 0.0 { (x * x - 2.0 * correlation * x * y + y * y) / rest } else { 4.0 };
                assert!((form - 4.0).abs() < 1e-9 && x.abs() <= 2.0 + 1e-12 && y.abs() <= 2.0 + 1e-12, "{correlation}: {x} {y}");
            }
        }
        assert!(WITHIN.iter().zip([0.682_69, 0.954_50]).all(|(r, p): (&f64, f64)| ((-0.5 * r * r).exp() - (1.0 - p)).abs() < 1e-3));
    }

    #[test]
    fn corners_are_drawn() {
        let parameters = vec![vec!["star.0.luminosity".into(), "900 +- 2 Lsun".into()], vec!["dust.scale".into()]];
        let corner = Corner { title: "t".into(), parameters, correlation: vec![vec![1.0, -0.5], vec![-0.5, 1.0]] };
        let unknown = Corner { correlation: vec![vec![f64::NAN; 2]; 2], ..corner.clone() };
        assert!(unknown.svg().unwrap().contains("unknown"));
        let svg = corner.svg().unwrap();
        assert!(svg.contains("star.0.luminosity") && svg.contains("-0.50") && svg.matches("<polyline").count() == 4, "{svg}");
        assert!(corner.png().unwrap().starts_with(b"\x89PNG"));
    }
}

//! Maps: numbers over a plane, several beside each other, with colours that grow evenly lighter.

use plotters::coord::Shift;
use plotters::prelude::*;

use barnard_files::formats::encode_png;

use crate::figure::register_font;
use crate::{Result, StudyError};

/// Numbers over a plane.
#[derive(Debug, Clone)]
pub struct Map {
    /// Quantity and unit.
    pub title: String,
    /// Columns and rows.
    pub size: (usize, usize),
    /// Extent of the plane, across and upwards \[pc\].
    pub across: (f64, f64),
    /// See [`across`](Self::across).
    pub upwards: (f64, f64),
    /// The values, row by row from below; what is not finite stays grey.
    pub values: Vec<f64>,
    /// The values of the darkest and of the lightest colour.
    pub range: (f64, f64),
}

/// Maps beside each other.
#[derive(Debug, Clone)]
pub struct Maps {
    /// The name of the file.
    pub name: String,
    /// The caption.
    pub title: String,
    /// The maps.
    pub maps: Vec<Map>,
}

/// The width of a map with its axes and scale, and the height of the caption \[px\].
const WIDTH: u32 = 430;
const CAPTION: u32 = 40;
/// Frame of a map: at its left with its margins, above, below, and the scale with its numbers \[px\].
const LEFT: u32 = 56;
const ABOVE: u32 = 30;
const BELOW: u32 = 46;
const SCALE: u32 = 64;
/// Maps in a row.
const IN_A_ROW: usize = 3;
/// Steps of a scale.
const STEPS: usize = 64;

impl Maps {
    /// The maps as the bytes of a PNG file.
    ///
    /// # Errors
    /// If they cannot be drawn or encoded.
    pub fn png(&self) -> Result<Vec<u8>> {
        let columns = self.maps.len().clamp(1, IN_A_ROW);
        let rows = self.maps.len().div_ceil(columns).max(1);
        // A parsec is as long across as upwards.
        let side = |(low, high): (f64, f64)| high - low;
        let aspect = self.maps.first().map_or(1.0, |map| (side(map.upwards) / side(map.across)).clamp(0.2, 5.0));
        let height = ABOVE + BELOW + (f64::from(WIDTH - LEFT - SCALE) * aspect) as u32;
        let size = (WIDTH * columns as u32, CAPTION + height * rows as u32);
        let mut pixels = vec![0; 3 * size.0 as usize * size.1 as usize];
        self.draw(&BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area(), (rows, columns))
            .map_err(|e| StudyError::Figure(self.name.clone(), e.to_string()))?;
        Ok(encode_png((size.0 as usize, size.1 as usize), &pixels, &[])?)
    }

    fn draw(&self, area: &DrawingArea<BitMapBackend, Shift>, grid: (usize, usize)) -> std::result::Result<(), Box<dyn std::error::Error>> {
        register_font();
        area.fill(&WHITE)?;
        let below = area.titled(&self.title, ("sans-serif", 22))?;
        let title = area.dim_in_pixel().1 - below.dim_in_pixel().1;
        let area = below.margin(CAPTION.saturating_sub(title), 0, 0, 0);
        for (map, panel) in self.maps.iter().zip(area.split_evenly(grid)) {
            map.draw(&panel)?;
        }
        area.present()?;
        Ok(())
    }
}

impl Map {
    fn colour(&self, value: f64) -> RGBColor {
        if !value.is_finite() {
            return RGBColor(200, 200, 200);
        }
        let (low, high) = self.range;
        ViridisRGB.get_color(((value - low) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
    }

    fn draw(&self, panel: &DrawingArea<BitMapBackend, Shift>) -> std::result::Result<(), Box<dyn std::error::Error>> {
        if !(self.range.0.is_finite() && self.range.1.is_finite() && self.range.0 < self.range.1) {
            return Err(format!("{}: no range of values: {:?}", self.title, self.range).into());
        }
        let (left, scale) = panel.split_horizontally(WIDTH - SCALE);
        let left = left.titled(&self.title, ("sans-serif", 17))?;
        let title = panel.dim_in_pixel().1 - left.dim_in_pixel().1;
        let mut chart = ChartBuilder::on(&left)
            .margin_top(ABOVE.saturating_sub(title))
            .margin_left(6)
            .margin_right(6)
            .margin_bottom(BELOW - 34)
            .x_label_area_size(34)
            .y_label_area_size(LEFT - 12)
            .build_cartesian_2d(self.across.0..self.across.1, self.upwards.0..self.upwards.1)?;
        let (columns, rows) = self.size;
        let side = |(low, high): (f64, f64), count: usize, i: usize| low + (high - low) * i as f64 / count as f64;
        chart.draw_series(self.values.iter().enumerate().map(|(i, value)| {
            let (x, y) = (i % columns, i / columns);
            let corner = |x: usize, y: usize| (side(self.across, columns, x), side(self.upwards, rows, y));
            Rectangle::new([corner(x, y), corner(x + 1, y + 1)], self.colour(*value).filled())
        }))?;
        chart.configure_mesh().disable_mesh().x_desc("x [pc]").y_desc("y [pc]").label_style(("sans-serif", 13)).draw()?;
        let (low, high) = self.range;
        let mut bar = ChartBuilder::on(&scale)
            .margin_top(ABOVE)
            .margin_bottom(BELOW)
            .margin_right(6)
            .y_label_area_size(44)
            .build_cartesian_2d(0.0..1.0, low..high)?;
        bar.draw_series((0..STEPS).map(|i| {
            let value = |i: usize| low + (high - low) * i as f64 / STEPS as f64;
            Rectangle::new([(0.0, value(i)), (1.0, value(i + 1))], self.colour(value(i)).filled())
        }))?;
        bar.configure_mesh().disable_mesh().disable_x_axis().label_style(("sans-serif", 12)).draw()?;
        Ok(())
    }
}

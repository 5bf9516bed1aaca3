//! Figures: series over two axes, as CSV, SVG and PNG; and pictures of pixels.

use std::sync::Once;

use barnard_files::formats::encode_png;
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::{Result, StudyError};

/// An axis of a figure.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Quantity and unit.
    pub label: &'static str,
    /// True if the axis is logarithmic.
    pub log: bool,
}

impl Axis {
    /// An axis of equal steps.
    pub fn linear(label: &'static str) -> Self {
        Self { label, log: false }
    }

    /// An axis of equal ratios.
    pub fn log(label: &'static str) -> Self {
        Self { label, log: true }
    }

    fn place(&self, v: f64) -> f64 {
        if self.log { v.log10() } else { v }
    }

    /// The text of a tick.
    fn tick(&self, v: f64) -> String {
        match self.log {
            true if (-2.5..4.0).contains(&v) => {
                // Two digits.
                let digits = 10f64.powf(1.0 - v.floor());
                format!("{}", (10f64.powf(v) * digits).round() / digits)
            }
            true if (v - v.round()).abs() < 1e-9 => format!("1e{v}"),
            true => format!("{:.0e}", 10f64.powf(v)),
            false => format!("{}", (v * 1e4).round() / 1e4),
        }
    }
}

/// A line through points.
#[derive(Debug, Clone)]
pub struct Series {
    /// The name in the legend.
    pub name: String,
    /// The points (x, y).
    pub points: Vec<(f64, f64)>,
}

/// A figure with axes.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The name of its files.
    pub name: String,
    /// The caption of the figure.
    pub title: String,
    /// The axis across.
    pub x: Axis,
    /// The axis upwards.
    pub y: Axis,
    /// The lines that it shows.
    pub series: Vec<Series>,
}

/// A picture of pixels, without axes.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The name of its file.
    pub name: String,
    /// The caption of the picture.
    pub title: String,
    /// The number of columns and of rows.
    pub size: (usize, usize),
    /// The sRGB of each pixel, row by row [0, 1].
    pub pixels: Vec<[f64; 3]>,
}

/// The value that is shown as white: all but the brightest fiftieth is below it, whatever its unit.
pub fn white(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() * 98 / 100].max(f64::MIN_POSITIVE)
}

/// A line in its parts.
type Runs = Vec<Vec<(f64, f64)>>;

/// Width and height of figures [px].
const SIZE: (u32, u32) = (900, 560);
/// Most points of a line that are shown as such.
const FEW: usize = 40;
/// Colours that most eyes distinguish: Okabe & Ito 2008, and five others.
const COLOURS: [RGBColor; 12] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(60, 60, 60),
    RGBColor(130, 130, 130),
    RGBColor(180, 180, 180),
    RGBColor(120, 80, 40),
    RGBColor(0, 60, 60),
    RGBColor(150, 0, 60),
];

impl Figure {
    /// The figure as lines of series, x, y.
    pub fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
        let mut csv = format!("series,{},{}\n", quoted(self.x.label), quoted(self.y.label));
        for series in &self.series {
            series.points.iter().for_each(|(x, y)| csv += &format!("{},{x:e},{y:e}\n", quoted(&series.name)));
        }
        csv
    }

    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn svg(&self) -> Result<String> {
        as_svg(SIZE, |area| self.draw(area))
    }

    /// The figure as the bytes of a PNG file.
    ///
    /// # Errors
    /// If it cannot be drawn or encoded.
    pub fn png(&self) -> Result<Vec<u8>> {
        as_png(SIZE, |area| self.draw(area))
    }

    /// The corner in which a legend hides the fewest points.
    fn emptiest_corner<'a>(&self, points: impl Iterator<Item = &'a (f64, f64)> + Clone) -> SeriesLabelPosition {
        let ends =
            |quantity: fn(&(f64, f64)) -> f64| points.clone().map(quantity).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        let ((left, right), (bottom, top)) = (ends(|p| p.0), ends(|p| p.1));
        let near = |from: f64, to: f64, v: f64, part: f64| (v - from).abs() <= part * (to - from).abs();
        let hidden = |x: (f64, f64), y: (f64, f64)| {
            points.clone().filter(|p| near(x.0, x.1, p.0, LEGEND.0) && near(y.0, y.1, p.1, LEGEND.1)).count()
        };
        let corners = [
            (SeriesLabelPosition::UpperRight, hidden((right, left), (top, bottom))),
            (SeriesLabelPosition::UpperLeft, hidden((left, right), (top, bottom))),
            (SeriesLabelPosition::LowerRight, hidden((right, left), (bottom, top))),
            (SeriesLabelPosition::LowerLeft, hidden((left, right), (bottom, top))),
        ];
        corners.into_iter().min_by_key(|c| c.1).map_or(SeriesLabelPosition::UpperRight, |c| c.0)
    }

    fn draw<D: DrawingBackend>(&self, area: &DrawingArea<D, Shift>) -> Result<()> {
        register_font();
        let failed = |e: &dyn std::fmt::Display| StudyError::Figure(self.name.clone(), e.to_string());
        area.fill(&WHITE).map_err(|e| failed(&e))?;
        let visible = |(x, y): &(f64, f64)| {
            let (x, y) = (self.x.place(*x), self.y.place(*y));
            (x.is_finite() && y.is_finite()).then_some((x, y))
        };
        // Where a point has no place the line is interrupted.
        let runs = |s: &Series| -> Runs {
            let places: Vec<Option<(f64, f64)>> = s.points.iter().map(visible).collect();
            places.split(Option::is_none).filter(|run| !run.is_empty()).map(|run| run.iter().copied().flatten().collect()).collect()
        };
        let lines: Vec<(&str, Runs)> = self.series.iter().map(|s| (s.name.as_str(), runs(s))).collect();
        let range = |quantity: fn(&(f64, f64)) -> f64| {
            let values = lines.iter().flat_map(|l| l.1.iter().flatten().map(quantity));
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
            let margin = 0.03 * (high - low).max(1e-9);
            if low > high { 0.0..1.0 } else { low - margin..high + margin }
        };
        let corner = self.emptiest_corner(lines.iter().flat_map(|l| l.1.iter().flatten()));
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(range(|p| p.0), range(|p| p.1))
            .map_err(|e| failed(&e))?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .x_desc(self.x.label)
            .y_desc(self.y.label)
            .x_label_formatter(&|v| self.x.tick(*v))
            .y_label_formatter(&|v| self.y.tick(*v))
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .draw()
            .map_err(|e| failed(&e))?;
        for (i, (name, runs)) in lines.into_iter().enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let style = colour.stroke_width(2);
            let paths = runs.iter().map(|run| PathElement::new(run.clone(), style));
            let drawn = chart.draw_series(paths).map_err(|e| failed(&e))?;
            drawn.label(name).legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
            let points = runs.iter().flatten();
            if points.clone().count() <= FEW {
                chart.draw_series(points.map(|p| Circle::new(*p, 3, colour.filled()))).map_err(|e| failed(&e))?;
            }
        }
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .label_font(("sans-serif", 14))
            .position(corner)
            .draw()
            .map_err(|e| failed(&e))?;
        area.present().map_err(|e| failed(&e))
    }
}

/// SVG text of a drawing with the given size in pixels.
pub(crate) fn as_svg(size: (u32, u32), draw: impl FnOnce(&DrawingArea<SVGBackend, Shift>) -> Result<()>) -> Result<String> {
    let mut svg = String::new();
    draw(&SVGBackend::with_string(&mut svg, size).into_drawing_area())?;
    Ok(svg)
}

/// Variant as the bytes of a PNG file.
pub(crate) fn as_png(size: (u32, u32), draw: impl FnOnce(&DrawingArea<BitMapBackend, Shift>) -> Result<()>) -> Result<Vec<u8>> {
    let (width, height) = (size.0 as usize, size.1 as usize);
    let mut pixels = vec![0; 3 * width * height];
    draw(&BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area())?;
    Ok(encode_png((width, height), &pixels, &[])?)
}

/// The part of a figure's width and height that a legend may take.
const LEGEND: (f64, f64) = (0.3, 0.4);

/// Text is drawn with a font that is compiled in: the same figure on every machine.
pub fn register_font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let _ = plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
}

impl Picture {
    /// The picture as the bytes of a PNG file.
    ///
    /// # Errors
    /// If it cannot be drawn or encoded.
    pub fn png(&self) -> Result<Vec<u8>> {
        let bytes: Vec<u8> = self.pixels.iter().flatten().map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect();
        Ok(encode_png(self.size, &bytes, &[])?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure() -> Figure {
        let series = Series { name: "a \"b\"".into(), points: vec![(1.0, 1e-3), (2.0, 1e-5), (3.0, 0.0)] };
        Figure { name: "f".into(), title: "t".into(), x: Axis::linear("x"), y: Axis::log("y [1]"), series: vec![series] }
    }

    /// A zero has no place on a logarithmic axis, but in the table.
    #[test]
    fn figures_are_drawn_and_told() {
        let svg = figure().svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("y [1]") && svg.matches("<circle").count() == 2, "{svg}");
        let png = figure().png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert!(pixels.chunks(3).any(|p| p == [0, 114, 178]) && pixels.chunks(3).any(|p| p == [255, 255, 255]));
        assert_eq!(
            figure().csv().lines().collect::<Vec<_>>()[1..],
            ["\"a \"\"b\"\"\",1e0,1e-3", "\"a \"\"b\"\"\",2e0,1e-5", "\"a \"\"b\"\"\",3e0,0e0"]
        );
    }

    #[test]
    fn nothing_to_draw_is_drawn() {
        assert!(Figure { series: Vec::new(), ..figure() }.svg().unwrap().starts_with("<svg"));
    }
}

//! Stars, filters, dust and gas: their spectra in one plot, and every key that the scene has of them.

use barnard::scene::Scene;
use eframe::egui::{self, Color32, Context, Ui};
use egui_plot::{Legend, Line, LineStyle, Plot, PlotPoints, Points, VLine};
use spectra::constants::SOLAR_LUMINOSITY;
use spectra::passband::Passband;
use toml_edit::{ArrayOfTables, Item, Table, Value};

use super::{band_colour, section, wavelength_colour};
use crate::command::Commands;
use crate::editor;
use crate::model::Model;
use barnard_explorer::edit::{self, Edit, count, numbers, place_text, table};

/// Points of a curve in the plot.
const SAMPLES: usize = 240;
/// Points of a filter that is made to be dragged.
const POINTS: usize = 11;
/// Least value of a curve in logarithms, as a part of its largest.
const FLOOR: f64 = 1e-4;
/// The distance within which the pointer takes hold of a point of a curve [points of the screen].
const GRIP: f32 = 12.0;
/// Most stars whose spectra are drawn.
const MAX_STARS: usize = 6;

/// Shows the panel of spectra.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    section(ui, "Spectra", true, |ui| {
        let mut logarithmic = model.layout.logarithmic;
        if ui.checkbox(&mut logarithmic, "logarithmic").changed() {
            commands.lay_out(move |layout| layout.logarithmic = logarithmic);
        }
        plot(ui, model, commands);
    });
    section(ui, "Filters", true, |ui| filters(ui, model, commands));
    let stars = egui::CollapsingHeader::new("Stars").default_open(true).open(revealed(ui.ctx(), "star").map(|_| true));
    stars.show(ui, |ui| list(ui, model, "star", commands));
    for i in 0..count(model.document.toml().as_table(), "star_table") {
        section(ui, &format!("Table of stars {}", i + 1), true, |ui| {
            editor::keys(ui, &model.document, &format!("star_table.{i}"), commands)
        });
    }
    if model.document.scene().dust.is_some() {
        section(ui, "Dust", true, |ui| {
            editor::keys(ui, &model.document, "dust", commands);
            for part in ["dust.phase", "dust.albedo"] {
                if table(model.document.toml().as_table(), part).is_some() {
                    section(ui, part, true, |ui| editor::keys(ui, &model.document, part, commands));
                }
            }
        });
    }
    if model.document.toml().get("gas").is_some() {
        section(ui, "Gas ionised by stars", true, |ui| {
            editor::keys(ui, &model.document, "gas", commands);
            for note in model.document.scene().ionised().iter().flat_map(|gas| gas.notes()) {
                ui.weak(note);
            }
        });
    }
    if count(model.document.toml().as_table(), "emission") > 0 {
        section(ui, "Gas", true, |ui| list(ui, model, "emission", commands));
    }
    section(ui, "Background", false, |ui| {
        editor::keys(ui, &model.document, "background", commands);
        if table(model.document.toml().as_table(), "background.stars").is_some() {
            section(ui, "Star field", true, |ui| editor::keys(ui, &model.document, "background.stars", commands));
        }
    });
    section(ui, "Fields", false, |ui| {
        let names: Vec<String> = model
            .document
            .toml()
            .get("field")
            .and_then(Item::as_table_like)
            .map_or_else(Vec::new, |fields| fields.iter().map(|(name, _)| name.to_owned()).collect());
        for name in names {
            section(ui, &name, false, |ui| editor::keys(ui, &model.document, &format!("field.{name}"), commands));
        }
    });
    for (title, table) in [("Camera", "camera"), ("Detail", "detail"), ("Output", "output"), ("Sequence", "sequence")] {
        section(ui, title, false, |ui| editor::keys(ui, &model.document, table, commands));
    }
}

/// The tables of a list, each with its keys.
fn list(ui: &mut Ui, model: &Model, name: &str, commands: &mut Commands) {
    let titles: Vec<String> = match name {
        "star" => model.document.stars().iter().map(|s| s.name.clone()).collect(),
        _ => model.document.scene().emission.iter().map(|e| e.name.clone()).collect(),
    };
    for (i, title) in titles.iter().enumerate() {
        let open = (revealed(ui.ctx(), name) == Some(i)).then_some(true);
        let header = egui::CollapsingHeader::new(title).id_salt((name, i)).default_open(i == 0).open(open).show(ui, |ui| {
            editor::keys(ui, &model.document, &format!("{name}.{i}"), commands);
            if name == "emission" {
                lines(ui, model, i, commands);
            }
            if ui.button("Remove").on_hover_text(format!("remove {title} from the scene")).clicked() {
                commands.push(Edit::drop(name, i));
            }
        });
        if open.is_some() {
            ui.data_mut(|data| data.remove::<usize>(revealed_id(name)));
            header.header_response.scroll_to_me(Some(egui::Align::Min));
        }
    }
    let hover = "add a star of 15000 K, as luminous as the brightest, in front of the cloud's centre";
    if name == "star" && ui.button("Add a star").on_hover_text(hover).clicked() {
        commands.push(Edit::push("star", star(model)));
        reveal(ui.ctx(), name, titles.len());
    }
}

/// Opens a table of a list in the next frame, and scrolls to it.
pub fn reveal(ctx: &Context, list: &str, index: usize) {
    ctx.data_mut(|data| data.insert_temp(revealed_id(list), index));
}

/// Number of the table of a list that is to be opened, if any.
fn revealed(ctx: &Context, list: &str) -> Option<usize> {
    ctx.data(|data| data.get_temp(revealed_id(list)))
}

fn revealed_id(list: &str) -> egui::Id {
    egui::Id::unique(("revealed", list))
}

/// Distance of a new star in front of the cloud's centre, relative to the cloud's radius: not behind most of its dust.
const BEFORE: f64 = 0.7;
/// The luminosity of the first star \[Lsun\].
const FIRST_LSUN: f64 = 1000.0;

/// Luminosity of a star between 20 nm and 50 um \[Lsun\].
fn luminosity_lsun(star: &barnard::scene::Star) -> f64 {
    const STEPS: usize = 400;
    let (first, step) = (0.02f64, (50.0f64 / 0.02).ln() / STEPS as f64);
    let per_step = (0..STEPS).map(|i| {
        let lambda = first * ((i as f64 + 0.5) * step).exp();
        star.spectrum.continuum(lambda) * lambda * step
    });
    per_step.sum::<f64>() / SOLAR_LUMINOSITY
}

/// A star that is seen and lights the cloud.
fn star(model: &Model) -> Table {
    let (scene, flight) = (model.document.scene(), &model.flight);
    let bounds = scene.dust.as_ref().map(|dust| dust.density.bounds()).or_else(|| scene.species().first().map(|gas| gas.density.bounds()));
    let radius = bounds.map_or(0.0, |bounds| 0.5 * bounds.size().min_element());
    let before = (BEFORE * radius).min(0.5 * flight.distance());
    let place = flight.pivot - before * flight.camera.forward;
    let brightest = model.document.stars().iter().map(luminosity_lsun).fold(0.0, f64::max);
    let luminosity = format!("{} Lsun", edit::significant(if brightest > 0.0 { brightest } else { FIRST_LSUN }));
    let mut star = Table::new();
    for (key, value) in [
        ("kind", "blackbody"),
        ("position", &*place_text(place, flight.distance())),
        ("temperature", "15000 K"),
        ("luminosity", &*luminosity),
    ] {
        star.insert(key, Item::Value(value.into()));
    }
    star
}

/// The strengths of a gas's own lines.
fn lines(ui: &mut Ui, model: &Model, i: usize, commands: &mut Commands) {
    let place = format!("emission.{i}");
    let Some(item) = table(model.document.toml().as_table(), &place).and_then(|t| t.get("lines")) else { return };
    let Some(lines) = item.as_array() else { return };
    egui::Grid::new((&place, "lines")).num_columns(2).show(ui, |ui| {
        for (n, line) in lines.iter().enumerate().filter_map(|(n, v)| Some((n, v.as_inline_table()?))) {
            let name = line.get("wavelength").and_then(Value::as_str).unwrap_or("").to_owned();
            let now = line.get("strength").and_then(edit::number).unwrap_or(0.0);
            let label = ui.label(&name);
            let mut strength = now;
            let drag = ui.add(editor::drag(&mut strength, (0.01 * now).max(1e-6)).range(0.0..=f64::MAX)).labelled_by(label.id);
            if editor::is_changed(&drag, now, strength) {
                commands.push(Edit::set(&format!("{place}.lines.{n}"), "strength", edit::significant(strength)));
            }
            drag.on_hover_text("strength, integrated over the line");
            ui.end_row();
        }
    });
}

/// Sets of filters, and filters whose curves are dragged.
fn filters(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let now = model.document.toml().get("bands").and_then(Item::as_str).unwrap_or("own").to_owned();
    let label = ui.label("set").on_hover_text("a set of passbands with its default colours");
    let chosen = egui::ComboBox::from_id_salt("bands").selected_text(&now).width(180.0).show_ui(ui, |ui| {
        for set in spectra::passband::SETS {
            if ui.selectable_label(set.name == now, set.name).on_hover_text(set.summary).clicked() && set.name != now {
                commands.push(barnard_explorer::comparison::filters(set.name));
            }
        }
    });
    chosen.response.labelled_by(label.id);
    for (b, band) in model.document.scene().bands.iter().enumerate() {
        let words = format!(
            "{}: pivot {:.1} nm, width {:.1} nm, counts {}",
            band.name(),
            band.pivot().nm(),
            band.width().nm(),
            band.counting().name()
        );
        ui.colored_label(band_colour(model.document.scene(), b), words);
    }
    for i in 0..count(model.document.toml().as_table(), "band") {
        section(ui, &format!("band {}", i + 1), false, |ui| editor::keys(ui, &model.document, &format!("band.{i}"), commands));
    }
    let is_stated = count(model.document.toml().as_table(), "band") > 0;
    if !is_stated && ui.button("Curves to drag").on_hover_text("write each filter as points, to drag in the plot").clicked() {
        commands.push(as_points(&model.document.scene().bands));
    }
}

/// The edit that turns the filters into straight lines between points.
fn as_points(bands: &[Passband]) -> Edit {
    let mut list = ArrayOfTables::new();
    for band in bands {
        let (low, high) = band.support_um();
        let nm: Vec<f64> = (0..POINTS).map(|i| 1e3 * (low + (high - low) * i as f64 / (POINTS - 1) as f64)).collect();
        let peak = if band.peak() > 1.0 { band.peak() } else { 1.0 };
        // `counting` states the weight of a photon, the curve is the throughput alone.
        let weight = |nm: f64| if band.counting().name() == "photon" { band.pivot().nm() / nm } else { 1.0 };
        let mut star_table = Table::new();
        star_table.insert("name", Item::Value(band.name().into()));
        star_table.insert("kind", Item::Value("points".into()));
        star_table.insert("counting", Item::Value(band.counting().name().into()));
        star_table
            .insert("throughput", Item::Value(numbers(nm.iter().map(|l| (band.response(1e-3 * l) * weight(*l) / peak).clamp(0.0, 1.0)))));
        star_table.insert("nm", Item::Value(numbers(nm)));
        list.push(star_table);
    }
    Edit::new("curves to drag", move |document| {
        document.remove("bands");
        document.insert("band", Item::ArrayOfTables(list));
    })
}

/// The interval in which filters of the scene let light through, with a margin [nm].
fn range(scene: &Scene) -> (f64, f64) {
    let ends = scene.bands.iter().map(Passband::support_um).fold((f64::MAX, 0.0f64), |(l, h), (a, b)| (l.min(a), h.max(b)));
    let margin = 0.05 * (ends.1 - ends.0);
    (1e3 * (ends.0 - margin).max(1e-3), 1e3 * (ends.1 + margin))
}

/// The points of one curve over nm, as parts of its largest value, in logarithms if asked for.
fn curve(range: (f64, f64), logarithmic: bool, f: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let nm = |i: usize| range.0 + (range.1 - range.0) * i as f64 / (SAMPLES - 1) as f64;
    let values: Vec<[f64; 2]> = (0..SAMPLES).map(|i| [nm(i), f(1e-3 * nm(i))]).collect();
    let largest = values.iter().map(|v| v[1]).fold(0.0, f64::max);
    let shown = |v: f64| if logarithmic { (v / largest).max(FLOOR).log10() } else { v / largest };
    if largest > 0.0 { values.iter().map(|[nm, v]| [*nm, shown(*v)]).collect() } else { Vec::new() }
}

fn plot(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let scene = model.document.scene();
    let (range, logarithmic) = (range(scene), model.layout.logarithmic);
    let dragged = ui.data(|d| d.get_temp::<(usize, usize)>(egui::Id::unique("curve point")));
    let points = draggable(model, logarithmic);
    let strong = ui.visuals().strong_text_color();
    let plot = Plot::new("spectra")
        .height(190.0)
        .legend(Legend::default().text_style(egui::TextStyle::Small))
        .x_axis_label("wavelength [nm]")
        .y_axis_label(if logarithmic { "log10 of the largest" } else { "relative to the largest" })
        .allow_scroll(false)
        .allow_drag(points.is_empty())
        .include_x(range.0)
        .include_x(range.1)
        .include_y(if logarithmic { FLOOR.log10() } else { 0.0 })
        .include_y(if logarithmic { 0.0 } else { 1.0 });
    let shown = plot.show(ui, |plot| {
        for (b, band) in scene.bands.iter().enumerate() {
            let colour = band_colour(scene, b);
            let floor = if logarithmic { FLOOR.log10() } else { 0.0 };
            let line = Line::new(band.name(), PlotPoints::from(curve(range, logarithmic, |l| band.response(l))));
            plot.line(line.color(colour).fill(floor as f32).fill_alpha(0.18));
        }
        for star in scene.stars.iter().take(MAX_STARS) {
            let line = curve(range, logarithmic, |l| star.spectrum.continuum(l));
            plot.line(Line::new(&star.name, PlotPoints::from(line)).width(1.5).color(strong));
        }
        for gas in scene.species() {
            let line = curve(range, logarithmic, |l| gas.spectrum.continuum(l));
            if !line.is_empty() {
                plot.line(Line::new(&gas.name, PlotPoints::from(line)).style(LineStyle::dotted_loose()));
            }
            for line in gas.spectrum.lines().iter().filter(|l| (range.0..=range.1).contains(&(1e3 * l.lambda_um))) {
                plot.vline(VLine::new(&gas.name, 1e3 * line.lambda_um).width(1.0).color(wavelength_colour(1e3 * line.lambda_um)));
            }
        }
        if let Some(dust) = &scene.dust {
            let known = |l: f64| dust.extinction.check("", l, l).map_or(0.0, |()| dust.extinction.k(l));
            plot.line(Line::new("extinction", PlotPoints::from(curve(range, logarithmic, known))).color(Color32::GRAY));
            let albedo = curve(range, logarithmic, |l| dust.albedo.at(l));
            plot.line(Line::new("albedo", PlotPoints::from(albedo)).color(Color32::GRAY).style(LineStyle::dashed_loose()));
        }
        for (_, marks) in &points {
            plot.points(Points::new("", PlotPoints::from(marks.clone())).radius(3.5).color(Color32::WHITE));
        }
        plot.pointer_coordinate()
    });
    drag(ui, model, &shown, &points, dragged, logarithmic, commands);
}

/// Points of the scene's own curves, as the plot shows them: which band, and where.
fn draggable(model: &Model, logarithmic: bool) -> Vec<(usize, Vec<[f64; 2]>)> {
    let root = model.document.toml().as_table();
    let shown = |v: f64, largest: f64| if logarithmic { (v / largest).max(FLOOR).log10() } else { v / largest };
    let points = |i: usize| {
        let band = table(root, &format!("band.{i}"))?;
        (band.get("kind")?.as_str()? == "points").then_some(())?;
        let (nm, throughput) = (edit::list(band, "nm")?, edit::list(band, "throughput")?);
        let largest = throughput.iter().copied().fold(1e-9, f64::max);
        Some((i, nm.into_iter().zip(throughput).map(|(l, t)| [l, shown(t, largest)]).collect()))
    };
    (0..count(root, "band")).filter_map(points).collect()
}

/// Takes hold of a point, and carries it.
fn drag(
    ui: &Ui,
    model: &Model,
    shown: &egui_plot::PlotResponse<Option<egui_plot::PlotPoint>>,
    points: &[(usize, Vec<[f64; 2]>)],
    dragged: Option<(usize, usize)>,
    logarithmic: bool,
    commands: &mut Commands,
) {
    let id = egui::Id::unique("curve point");
    let Some(pointer) = shown.response.interact_pointer_pos() else {
        ui.data_mut(|d| d.remove::<(usize, usize)>(id));
        return;
    };
    if shown.response.drag_started() {
        let pressed = ui.input(|i| i.pointer.press_origin()).unwrap_or(pointer);
        let on_screen = |p: &[f64; 2]| shown.transform.position_from_point(&(*p).into()).distance(pressed);
        let all = points.iter().flat_map(|(band, marks)| marks.iter().enumerate().map(move |(i, p)| (*band, i, on_screen(p))));
        if let Some((band, i, _)) = all.filter(|p| p.2 < GRIP).min_by(|a, b| a.2.total_cmp(&b.2)) {
            ui.data_mut(|d| d.insert_temp(id, (band, i)));
        }
        return;
    }
    let (Some((band, i)), Some(at), true) = (dragged, shown.inner, shown.response.dragged()) else { return };
    let place = format!("band.{band}");
    let Some(band_table) = table(model.document.toml().as_table(), &place) else { return };
    let (Some(mut nm), Some(mut throughput)) = (edit::list(band_table, "nm"), edit::list(band_table, "throughput")) else { return };
    let largest = throughput.iter().copied().fold(1e-9, f64::max);
    // Points keep their order: each stays between its neighbours.
    let low = if i == 0 { 1.0 } else { nm[i - 1] + 0.01 };
    let high = nm.get(i + 1).map_or(f64::MAX, |n| n - 0.01);
    nm[i] = at.x.clamp(low, high.max(low));
    throughput[i] = (if logarithmic { 10f64.powf(at.y) } else { at.y } * largest).clamp(0.0, 1.0);
    commands.push(
        Edit::set(&place, "nm", numbers(nm))
            .and(Edit::set(&place, "throughput", numbers(throughput)))
            .with_name(format!("{place} dragged")),
    );
}

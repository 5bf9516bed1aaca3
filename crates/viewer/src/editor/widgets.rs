//! The widgets of one key: what its value is shown as, and what a change of it writes.

use std::ops::RangeInclusive;

use barnard::properties::{KeyRow, Type};
use barnard_files::catalogue::Catalogue;
use eframe::egui::{self, DragValue, Id, Response, Ui};
use spectra::units::parts;
use toml_edit::{Item, Value};

use crate::command::Commands;
use barnard_explorer::edit::{Edit, rounded, significant};

/// The relative change of a number in one point of a drag.
const DRAG: f64 = 0.006;
/// Size of a coordinate, whatever its digits: panels keep their width while a star is dragged.
const COORDINATE: [f32; 2] = [54.0, 18.0];
/// Most characters of a coordinate that three of stand in a line.
const SHORT: usize = 7;
/// Digits of numbers that are written.
const DIGITS: usize = 6;

/// A number that is dragged, or typed and then taken as a whole, in the digits that it is written with.
pub fn drag(value: &mut f64, speed: f64) -> DragValue<'_> {
    DragValue::new(value).speed(speed).update_while_editing(false).custom_formatter(|v, _| rounded(v, DIGITS))
}

/// True if a number was changed by more than being shown in fewer digits.
pub fn is_changed(response: &Response, before: f64, after: f64) -> bool {
    response.changed() && rounded(before, DIGITS) != rounded(after, DIGITS)
}

/// A key of a table, and what its widgets ask for.
pub struct KeyWidget<'a> {
    pub place: &'a str,
    pub key: &'a KeyRow,
    pub commands: &'a mut Commands,
}

impl KeyWidget<'_> {
    /// Shows a value of the key as the widget that fits it; `label` names it.
    pub fn show(&mut self, ui: &mut Ui, item: &Item, label: Id) -> Response {
        let float = |v: f64| Value::from(significant(v));
        match (self.key.value, item.as_value()) {
            (_, Some(Value::Boolean(flag))) => {
                let mut on = *flag.value();
                let response = ui.checkbox(&mut on, "");
                self.set_if(response, on)
            }
            (Type::Position, Some(Value::String(text))) => self.position(ui, text.value(), label),
            (Type::Integer, Some(Value::Integer(n))) => {
                let mut number = *n.value();
                let response = ui.add(DragValue::new(&mut number).range(self.range(1.0)).update_while_editing(false));
                self.set_if(response, number)
            }
            (_, Some(Value::Integer(n))) => self.number(ui, *n.value() as f64, "", float),
            (_, Some(Value::Float(v))) => self.number(ui, *v.value(), "", float),
            (Type::Quantity(..), Some(Value::String(text))) => match parts(text.value()) {
                Some((value, unit)) => self.quantity(ui, value, unit),
                None => self.words(ui, text.value(), |t| Some(t.into())),
            },
            (_, Some(Value::String(text))) => match self.names() {
                names if names.is_empty() => self.words(ui, text.value(), |t| Some(t.into())),
                names => self.choice(ui, &names, text.value()),
            },
            (_, Some(value)) => {
                let text = value.clone().decorated("", "").to_string();
                self.words(ui, &text, |t| t.parse::<Value>().ok())
            }
            (_, None) => ui.weak("a table"),
        }
    }

    fn set(&mut self, value: impl Into<Value>) {
        self.commands.push(Edit::set(self.place, self.key.name, value.into()));
    }

    fn set_if(&mut self, response: Response, value: impl Into<Value>) -> Response {
        if response.changed() {
            self.set(value);
        }
        response
    }

    /// Allowed numbers in a unit of this size.
    fn range(&self, size: f64) -> RangeInclusive<f64> {
        let range = self.key.range;
        let low = if range.excludes_low { range.low.next_up() } else { range.low };
        let high = if range.excludes_high { range.high.next_down() } else { range.high };
        low / size..=high / size
    }

    /// A number that is dragged in proportion to itself.
    fn number(&mut self, ui: &mut Ui, value: f64, unit: &str, write: impl Fn(f64) -> Value) -> Response {
        let mut changed = value;
        let suffix = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let size = self.key.value.quantity().and_then(|quantity| quantity.unit_size(unit)).unwrap_or(1.0);
        let response = ui.add(drag(&mut changed, (value.abs() * DRAG).max(1e-4)).range(self.range(size)).suffix(suffix));
        if is_changed(&response, value, changed) {
            self.set(write(changed));
        }
        response
    }

    /// A quantity: its number, and the unit it is written in.
    fn quantity(&mut self, ui: &mut Ui, value: f64, unit: &str) -> Response {
        self.number(ui, value, unit, |v| Value::from(format!("{} {unit}", rounded(v, DIGITS))))
    }

    /// Three coordinates and a unit of length.
    fn position(&mut self, ui: &mut Ui, text: &str, label: Id) -> Response {
        let words: Vec<&str> = text.split([' ', ',']).filter(|w| !w.is_empty()).collect();
        let &[x, y, z, unit] = &words[..] else { return ui.weak(text) };
        let (Ok(x), Ok(y), Ok(z)) = (x.parse::<f64>(), y.parse::<f64>(), z.parse::<f64>()) else { return ui.weak(text) };
        let before = [x, y, z];
        let mut after = before;
        let speed = (before.iter().map(|v| v.abs()).fold(0.0, f64::max) * DRAG).max(1e-3);
        let mut changed = false;
        let long = before.iter().any(|v| rounded(*v, DIGITS).len() > SHORT);
        let drags = |ui: &mut Ui| {
            ui.spacing_mut().interact_size = COORDINATE.into();
            let drags = [0, 1, 2].map(|i| {
                let response = ui.add(drag(&mut after[i], speed)).labelled_by(label);
                changed |= is_changed(&response, before[i], after[i]);
                response
            });
            ui.label(unit);
            drags.into_iter().reduce(|a, b| a | b)
        };
        // Long numbers stand below each other.
        let row = if long { ui.vertical(drags) } else { ui.horizontal(drags) };
        if changed {
            let written = |i: usize| if after[i] == before[i] { words[i].to_owned() } else { rounded(after[i], DIGITS) };
            self.set(format!("{} {} {} {unit}", written(0), written(1), written(2)));
        }
        row.inner.unwrap_or(row.response)
    }

    /// Names that the value is one of, with summaries; empty where any text is allowed.
    fn names(&self) -> Vec<(String, String)> {
        let catalogue = self.key.catalogue.and_then(|name| Catalogue::by_name(name).ok());
        let choices = || self.key.value.choices().into_iter().map(|name| (name.to_owned(), String::new())).collect();
        catalogue.map_or_else(choices, |catalogue| (catalogue.rows)())
    }

    /// One of some names.
    fn choice(&mut self, ui: &mut Ui, rows: &[(String, String)], now: &str) -> Response {
        let summary = rows.iter().find(|(name, _)| name == now).map_or("", |(_, summary)| summary).to_owned();
        let combo = egui::ComboBox::from_id_salt((self.place, self.key.name)).selected_text(now).width(150.0).show_ui(ui, |ui| {
            for (name, summary) in rows {
                if ui.selectable_label(name == now, name).on_hover_text(summary).clicked() && name != now {
                    self.set(name.as_str());
                }
            }
        });
        combo.response.on_hover_text(summary)
    }

    /// A text that is taken when it is left.
    fn words(&mut self, ui: &mut Ui, now: &str, write: impl Fn(&str) -> Option<Value>) -> Response {
        let id = Id::unique(("words", self.place, self.key.name));
        let mut text = ui.data_mut(|d| d.get_temp::<String>(id)).unwrap_or_else(|| now.to_owned());
        let response = ui.add(egui::TextEdit::singleline(&mut text).id(id.with("edit")).desired_width(150.0));
        if response.has_focus() {
            ui.data_mut(|d| d.insert_temp(id, text.clone()));
        }
        if response.lost_focus() {
            ui.data_mut(|d| d.remove::<String>(id));
            let given_up = ui.input(|i| i.key_pressed(egui::Key::Escape));
            match write(&text) {
                Some(value) if text != now && !given_up => self.set(value),
                _ => {}
            }
        }
        response
    }
}

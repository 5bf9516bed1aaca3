//! Results as JSON on standard output.

use std::io::Write;

use barnard::image::Image;
use barnard::properties::{Table, Value};
use serde_json::{Map, json};

/// Prints a result; a reader that closed the pipe stops nothing.
pub fn print(result: &serde_json::Value) {
    let mut out = std::io::stdout().lock();
    let _ = serde_json::to_writer_pretty(&mut out, result).map(|()| writeln!(out));
}

/// A tree as JSON; quantities are texts with their unit.
pub fn json_of(tree: &Table) -> serde_json::Value {
    serde_json::Value::Object(tree.iter().map(|(key, property)| (key.to_owned(), json_of_value(&property.value))).collect::<Map<_, _>>())
}

fn json_of_value(value: &Value) -> serde_json::Value {
    match value {
        Value::Text(text) => json!(text),
        Value::Quantity(..) => json!(value.to_string()),
        Value::Integer(number) => json!(number),
        Value::Number(number) => json!(number),
        Value::Flag(flag) => json!(flag),
        Value::List(items) => items.iter().map(|item| json_of_value(&item.value)).collect(),
        Value::Table(table) => json_of(table),
    }
}

/// Facts about an image that was written to files, with its report.
pub fn json_of_image(image: &Image, files: &[String], seconds: f64) -> serde_json::Value {
    let bands: Vec<String> = image.bands.iter().map(|band| band.label()).collect();
    json!({
        "files": files,
        "width": image.width,
        "height": image.height,
        "bands": bands,
        "seconds": seconds,
        "report": json_of(&image.report.tree()),
    })
}

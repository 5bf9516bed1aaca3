//! A scene around a grid.

use std::sync::Arc;

use barnard::field::Field;

/// The density of a scene whose dust is the grid in a file of these bytes; `keys` stand in its table.
pub fn density(name: &str, bytes: &[u8], keys: &str, memory_limit: u64) -> Result<Arc<dyn Field>, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(name), bytes).unwrap();
    let text = format!(
        r#"[camera]
kind = "perspective"
position = "0 0 9 pc"
field_of_view = "30 deg"
[field.n]
kind = "grid"
file = "{name}"
{keys}
[dust]
density = "n"
scale = "5.32e-22 mag cm2"
"#
    );
    let scene = barnard_files::parse("test.toml", "test", text, &barnard_files::in_folder(folder.path(), memory_limit))
        .map_err(|e| e.to_string())?;
    Ok(scene.dust.as_ref().unwrap().density.clone())
}

//! The manual of the scene format, made of the catalogues that the parser reads.

use std::fmt::Write;

use barnard::field;
use barnard::properties::KeyRow;
use barnard::scene::schema::{KindRow, TABLES, TableRow};

use crate::catalogue::Catalogue;

/// The text of `docs/scene-format.md`.
pub fn manual() -> String {
    let mut page = String::from(INTRODUCTION);
    units(&mut page);
    for table in TABLES {
        section(&mut page, table);
    }
    page
}

fn section(page: &mut String, table: &TableRow) {
    let _ = writeln!(page, "\n## {}\n", table.title);
    if !table.text.is_empty() {
        let _ = writeln!(page, "{}\n", table.text);
    }
    if !table.keys.is_empty() {
        keys(page, table.keys);
    }
    for kind in (table.kinds)().into_iter().filter(|_| table.path != "background") {
        entry(page, &kind);
    }
    match table.path {
        "field.*" => expressions(page),
        "emission" => catalogues(page, table, |page| {
            let _ = writeln!(page, "\nIons with emissivities: {}.", spectra::nebular::ions().join(", "));
        }),
        _ => catalogues(page, table, |_| ()),
    }
}

fn expressions(page: &mut String) {
    let functions = |names: &[&str]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    let _ = writeln!(
        page,
        "\n**Expressions** have `+ - * / ^` and parentheses with the usual precedence (−x² is −(x²); the ambiguous `a^b^c` and `a/-b` are errors), \
         numbers such as `1e-3`, functions {}, of two arguments {} (`step(a, edge)` is 1 where a ≥ edge; `ln` is natural), x, y, z in pc, and pi. \
         Names of fields have letters, digits and _, and must differ from these.",
        functions(&field::functions()),
        functions(&field::functions_of_two())
    );
}

fn catalogues(page: &mut String, table: &TableRow, more: impl FnOnce(&mut String)) {
    for (title, name) in table.catalogues {
        let rows = Catalogue::by_name(name).map_or_else(|_| Vec::new(), |catalogue| (catalogue.rows)());
        let _ = writeln!(page, "\n**{title}**\n\n| name | what it is |\n|---|---|");
        for (name, summary) in rows {
            let _ = writeln!(page, "| `{name}` | {summary} |");
        }
    }
    more(page);
}

const INTRODUCTION: &str = "# The scene format

This page is generated from the program's catalogues (`BLESS=1 cargo test -p barnard-files --test suite manual`).

A scene is a TOML file. Quantities are strings with units (`\"656.3 nm\"`, `\"0.4 pc\"`, `\"39000 K\"`, `\"2 mag/pc\"`), positions three numbers and a unit
(`\"0.5 0 -2 pc\"`), directions lists (`[0, 1, 0]`). Unknown keys are errors. Files are relative to the scene file. In tables, `kind` selects a row of a
catalogue; `barnard list CATALOGUE` prints the names of one.

```toml
bands = \"johnson\"

[camera]
kind = \"perspective\"
position = \"0 0 6 pc\"
field_of_view = \"30 deg\"
size = [512, 512]

[field.cloud]
kind = \"fbm\"
seed = 3

[dust]
density = \"cloud\"
scale = \"4 mag/pc\"

[[star]]
kind = \"blackbody\"
position = \"0 0.2 0.3 pc\"
temperature = \"20000 K\"
luminosity = \"8000 Lsun\"
```
";

fn units(page: &mut String) {
    page.push_str("\n## Units\n\n| quantity | units | example |\n|---|---|---|\n");
    for quantity in spectra::units::QUANTITIES {
        let units: Vec<String> = quantity.units.iter().map(|(name, _)| format!("`{name}`")).collect();
        let _ = writeln!(page, "| {} | {} | `{}` |", quantity.name, units.join(", "), quantity.example);
    }
    page.push_str(CSV);
}

const CSV: &str = "
## Files of spectra

Filters, stars, gas, albedos and mean cosines are read from text, ECSV, VOTable (TABLEDATA) or a FITS binary table: a wavelength in ascending or descending
order and a value. In text, commas, semicolons, tabs or blanks separate columns, the same in all rows; decimal commas are read where no number can mean anything
else. Lines that begin with `#`, `%`, `!` or `//` are comments. A line of column names, and a line of units below it, may precede the rows.

The unit of the spectral axis is that of the key `unit`, of the column (`wavelength_nm`, `lambda [Å]`, a unit of the table), or of a comment that names the columns. Any
spelling of angstrom, nm, um, mm and m is understood, and wavenumbers (cm-1), frequencies and photon energies are converted. Where no unit is stated, one is
inferred if all rows lie between 90 nm and 30 um in that unit alone, and a note says so; otherwise the file is refused. `column` chooses one of several columns.
Percent become fractions; fluxes per frequency (`Jy`) or in photons (`PHOTLAM`) become fluxes per wavelength. Wavelengths in air (`wavelength_air`) become those in vacuum.

Between rows the curve is straight. A filter is zero outside of its rows; a star or a gas must reach over every passband, unless its rows end with zero; an albedo
or a mean cosine keeps its first and last value beyond its rows. `barnard info FILE` prints how a file is understood.
";

fn entry(page: &mut String, kind: &KindRow) {
    let _ = writeln!(page, "\n### kind = \"{}\"\n\n{}.", kind.name, kind.summary);
    if !kind.keys.is_empty() {
        page.push('\n');
        keys(page, kind.keys);
    }
}

fn keys(page: &mut String, keys: &[KeyRow]) {
    page.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
    for key in keys {
        let default = key.default_words().unwrap_or_else(|| "**required**".to_owned());
        let _ = writeln!(page, "| `{}` | {} | {default} | {} |", key.name, key.type_words(), key.summary);
    }
}

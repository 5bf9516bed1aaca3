//! The manual of the scene format, made of the catalogues that the parser reads.

use std::fmt::Write;

use super::{Key, Kind, ROOT, albedo, background, band, display, dust, emission, method, star};
use crate::{camera, field, phase};

/// `docs/scene-format.md`.
pub fn manual() -> String {
    let mut page = String::from(INTRODUCTION);
    units(&mut page);
    page.push_str("\n## The scene\n\n");
    keys(&mut page, ROOT);
    section(&mut page, "[camera]", "Where the observer is; `kind` chooses the projection.", camera::common_keys(), camera::KINDS);
    section(
        &mut page,
        "[field.NAME]",
        "Named scalar fields. Expressions elsewhere use them by name, so products, sums and masks are written as formulas (below). An expression that uses a grid lives on the finest such grid's voxels.",
        &[],
        field::KINDS,
    );
    let functions = |names: &[&str]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    let _ = writeln!(
        page,
        "\n**Expressions** have `+ - * / ^` and parentheses, bound as in mathematics (−x² is −(x²); `a^b^c` and `a/-b`, which can be read in two ways, are refused), \
         numbers such as `1e-3`, functions {}, of two arguments {} (`step(a, edge)` is 1 where a ≥ edge; `ln` is natural), x, y, z in pc, and pi. \
         A field's name has letters, digits and _, and is none of these.",
        functions(&field::FUNCTIONS),
        functions(&field::FUNCTIONS_OF_TWO)
    );
    plain(&mut page, "[dust]", "Dust that absorbs and scatters.", dust::KEYS);
    catalogue(&mut page, "Extinction laws", spectra::extinction::LAWS.iter().map(|l| (l.name, l.summary)));
    section(&mut page, "[dust.albedo]", "The part of extinction that scatters.", &[], albedo::KINDS);
    page.push_str("\n## [dust.phase]\n\nHow scattered light is spread over angle; cos θ = +1 is forward.\n");
    for kind in phase::KINDS {
        entry(&mut page, kind.name, kind.summary, kind.keys);
    }
    section(
        &mut page,
        "[[star]]",
        "A star; `kind` chooses the shape of its spectrum, and exactly one scale says how bright it is.",
        star::KEYS,
        star::SPECTRA,
    );
    catalogue(&mut page, "Stellar spectra", spectra::sed::STARS.iter().map(|s| (s.name, s.summary)));
    section(&mut page, "[[emission]]", "Gas that glows.", emission::KEYS, emission::KINDS);
    catalogue(&mut page, "Line lists", spectra::nebular::LINE_LISTS.iter().map(|l| (l.name, l.summary)));
    let _ = writeln!(page, "\nIons with emissivities: {}.", spectra::nebular::ions().join(", "));
    plain(
        &mut page,
        "[background]",
        "What lies behind the cloud: with a `kind` (the spectra of stars, above) an even light, with `[background.stars]` a field of stars.",
        background::UNIFORM_KEYS,
    );
    plain(&mut page, "[background.stars]", "Stars at infinity, the same from every camera.", background::STAR_KEYS);
    section(&mut page, "[[band]]", "Passbands of one's own, beside the sets and embedded passbands of `bands`.", band::KEYS, band::KINDS);
    catalogue(&mut page, "Sets of passbands", spectra::passband::SETS.iter().map(|s| (s.name, s.summary)));
    catalogue(&mut page, "Families of embedded passbands", spectra::passband::FAMILIES.iter().map(|f| (f.name, f.summary)));
    plain(&mut page, "[display]", "Palette and stretch of pictures; they never touch the radiance.", display::KEYS);
    catalogue(&mut page, "Palettes", spectra::colour::PALETTES.iter().map(|p| (p.name, p.summary)));
    catalogue(&mut page, "Stretches", spectra::colour::STRETCHES.iter().map(|s| (s.name, s.summary)));
    plain(&mut page, "[method]", "How spectral integrals are done.", method::KEYS);
    catalogue(&mut page, "Methods", method::methods().map(|m| (m.name, m.summary)));
    page
}

const INTRODUCTION: &str = "# The scene format

This page is made of the program's own catalogues (`BLESS=1 cargo test -p barnard --test manual` writes it).

A scene is a TOML file. Quantities are texts with units (`\"656.3 nm\"`, `\"0.4 pc\"`, `\"39000 K\"`, `\"2 mag/pc\"`), positions three numbers and a unit
(`\"0.5 0 -2 pc\"`), directions lists (`[0, 1, 0]`). Unknown keys are errors. Files are relative to the scene file. Tables with a `kind` choose a row of a
catalogue.

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
    use spectra::units::*;
    page.push_str("\n## Units\n\n| quantity | units | example |\n|---|---|---|\n");
    row::<Wavelength>(page);
    row::<Length>(page);
    row::<Angle>(page);
    row::<Temperature>(page);
    row::<Velocity>(page);
    row::<Luminosity>(page);
    row::<SpectralLuminosity>(page);
    row::<Magnitude>(page);
    row::<SpectralRadiance>(page);
    row::<ExtinctionCoefficient>(page);
    row::<ExtinctionPerColumn>(page);
    row::<NumberDensity>(page);
    row::<Emissivity>(page);
    row::<SkyDensity>(page);
    page.push_str(CSV);
}

fn row<Q: spectra::units::Quantity>(page: &mut String) {
    let units: Vec<String> = Q::UNITS.iter().map(|(name, _)| format!("`{name}`")).collect();
    let _ = writeln!(page, "| {} | {} | `{}` |", Q::NAME, units.join(", "), Q::EXAMPLE);
}

const CSV: &str = "
## Files of spectra

Filters, stars, gas, albedos and mean cosines are read from CSV text: two columns, a wavelength in ascending order and a value, parted by commas, semicolons,
tabs or blanks; numbers have a decimal point. Lines that begin with `#` and one line of column names are skipped; they may name the unit of the wavelength
(`nm`, `um`, `µm`, `micron`, `angstrom`, `Å`), nm otherwise. Between rows the curve is straight. A filter is zero outside of its rows; a star or a gas must reach
over every passband, unless its rows end with zero; an albedo or a mean cosine keeps its first and last value beyond its rows.
";

fn section<T>(page: &mut String, title: &str, text: &str, common: &[Key], kinds: &[Kind<T>]) {
    let _ = writeln!(page, "\n## {title}\n\n{text}\n");
    if !common.is_empty() {
        keys(page, common);
    }
    for kind in kinds {
        entry(page, kind.name, kind.summary, kind.keys);
    }
}

fn plain(page: &mut String, title: &str, text: &str, own: &[Key]) {
    let _ = writeln!(page, "\n## {title}\n\n{text}\n");
    keys(page, own);
}

fn entry(page: &mut String, name: &str, summary: &str, own: &[Key]) {
    let _ = writeln!(page, "\n### kind = \"{name}\"\n\n{summary}.");
    if !own.is_empty() {
        page.push('\n');
        keys(page, own);
    }
}

fn keys(page: &mut String, keys: &[Key]) {
    page.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
    for key in keys {
        let default = key.default.map_or("**required**".to_owned(), str::to_owned);
        let _ = writeln!(page, "| `{}` | {} | {default} | {} |", key.name, key.kind, key.summary);
    }
}

fn catalogue<'a>(page: &mut String, title: &str, rows: impl Iterator<Item = (&'a str, &'a str)>) {
    let _ = writeln!(page, "\n**{title}**\n\n| name | what it is |\n|---|---|");
    for (name, summary) in rows {
        let _ = writeln!(page, "| `{name}` | {summary} |");
    }
}

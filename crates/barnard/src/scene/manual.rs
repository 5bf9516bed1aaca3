//! The manual of the scene format, made of the catalogues that the parser reads.

use std::fmt::Write;

use super::{Key, Kind, ROOT, albedo, background, band, display, dust, emission, method, star};
use crate::{camera, field, phase};

/// `docs/scene-format.md`.
pub fn manual() -> String {
    let mut page = String::from(INTRODUCTION);
    page.push_str("\n## The scene\n\n");
    keys(&mut page, ROOT);
    section(&mut page, "[camera]", "Where the observer is; `kind` chooses the projection.", camera::common_keys(), camera::KINDS);
    section(
        &mut page,
        "[field.NAME]",
        "Named scalar fields. Expressions elsewhere use them by name, so products, sums and masks are written as formulas: `+ - * / ^`, `sqrt exp ln abs sin cos floor`, `min(a, b)`, `max(a, b)`, `step(a, edge)`, and x, y, z in pc. An expression that uses a grid lives on the finest such grid's voxels.",
        &[],
        field::KINDS,
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
    catalogue(&mut page, "Spectral rules", spectra::rule::RULES.iter().map(|r| (r.name, r.summary)));
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

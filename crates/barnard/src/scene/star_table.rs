//! The `[[star_table]]` tables: stars of a CSV, one a row.
//!
//! A row says what a `[[star]]` says, its columns being named like the keys: it is written as such a table in the same line of another text, and read by what reads `[[star]]`. So all kinds (but
//! that of a file) and all scales are there, and errors name file, line and key.

use spectra::error::nearest;
use spectra::units::QUANTITIES;
use toml_edit::Document;

use super::section::one_line;
use super::{Key, Loader, SceneText, Section, Star, star};
use crate::error::Result;

/// Keys of its own, and those of `[[star]]` that are most often the same for all of its stars; the others may stand here too.
pub(super) const KEYS: &[Key] = &[
    Key::required("file", "path", "the CSV: a line of column names, then a star in each row"),
    Key::optional("columns", "list of texts", "all that are keys of [[star]]", "which columns are read, beside x, y and z"),
    Key::optional("visible", "boolean", "true", "whether the stars themselves are drawn"),
    Key::optional("magnitude_band", "text", "johnson-V", "an embedded passband, for a column of magnitudes").of("passbands"),
    Key::optional("distance", "length", "needed with magnitudes", "where magnitudes were seen from"),
    Key::optional("magnitude_system", "text", "vega", "vega or ab"),
];

/// Most stars of a table: of more, frames grow with the stars.
pub const MOST_ROWS: usize = 20_000;

/// Columns of a place.
const PLACE: [&str; 3] = ["x", "y", "z"];
/// What a key is measured in where neither column nor cell says it.
const UNITS: [(&str, &str); 5] =
    [("temperature", "K"), ("luminosity", "Lsun"), ("radius", "Rsun"), ("magnitude", "mag"), ("distance", "pc")];
/// What places are measured in where their columns do not say it.
const PLACE_UNIT: &str = "pc";

/// A column that is read.
struct Column {
    /// Where it stands in a row.
    index: usize,
    name: String,
    unit: Option<String>,
    /// What its key's value is.
    kind: &'static str,
}

/// The kind of spectrum that no row can have: its `file` would be the table's.
const OF_FILE: &str = "file";
const KIND: Key = Key::optional("kind", "text", "", "");

/// All that a row may say.
fn keys() -> impl Iterator<Item = &'static Key> {
    let kinds = star::SPECTRA.iter().filter(|kind| kind.name != OF_FILE);
    [&KIND].into_iter().chain(star::KEYS).chain(kinds.flat_map(|kind| kind.keys)).filter(|key| key.name != "position")
}

pub(super) fn build(section: &Section, loader: &Loader) -> Result<Vec<Star>> {
    let known: Vec<&str> = ["file", "columns"].into_iter().chain(keys().map(|key| key.name)).collect();
    section.check_keys(&known)?;
    if section.text("kind")? == Some(OF_FILE) {
        return Err(section.error("kind", "stars of a table have no spectra of files; write such a star as [[star]]"));
    }
    let file = section.need_text("file")?;
    let text = section.wrap("file", loader.read_text(file))?;
    let name = loader.path(file).display().to_string();
    let rows = Rows { section, file: &name };
    let source = SceneText { file: name.clone(), text: rows.written(&text)? };
    let document = Document::parse(source.text.as_str()).map_err(|e| source.error(e.span(), "CSV", e.message().trim().to_owned()))?;
    Section::new(&source, document.as_table(), None, "").tables(ROWS)?.iter().map(|row| star::build(row, loader)).collect()
}

/// What the rows are called in messages.
const ROWS: &str = "row";

/// The rows of a table, on their way to be tables.
struct Rows<'a> {
    section: &'a Section<'a>,
    file: &'a str,
}

impl Rows<'_> {
    fn wrong(&self, line: u64, message: impl Into<String>) -> crate::Error {
        crate::Error::Scene { message: message.into(), file: self.file.into(), line: line as usize, place: ROWS.into() }
    }

    /// What csv has to say.
    fn told(&self, error: &csv::Error) -> crate::Error {
        let line = error.position().map_or(1, csv::Position::line);
        let message = match error.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("has {len} cells, the line of column names {expected_len}; a cell that says nothing is empty")
            }
            _ => error.to_string(),
        };
        self.wrong(line, message)
    }

    /// The same stars as a list of inline tables under [`ROWS`], each in the line of its row.
    fn written(&self, text: &str) -> Result<String> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let is_said = |line: &str| !line.trim().is_empty() && !line.starts_with('#');
        let head = text.lines().find(|line| is_said(line)).ok_or_else(|| self.wrong(1, "holds no line of column names"))?;
        let delimiter = [b',', b';', b'\t'].into_iter().find(|d| head.as_bytes().contains(d)).unwrap_or(b' ');
        // Lines of blanks are empty; where blanks part columns, many are one.
        let line = |line: &str| match (is_said(line), delimiter) {
            (false, _) => String::new(),
            (true, b' ') => line.split_whitespace().collect::<Vec<_>>().join(" "),
            (true, _) => line.to_owned(),
        };
        let lines: Vec<String> = text.lines().map(line).collect();
        // Numbers of the lines that say something, from 1.
        let said: Vec<u64> = (1..).zip(&lines).filter(|(_, line)| !line.is_empty()).map(|(number, _)| number).collect();
        let text = lines.join("\n");
        let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).trim(csv::Trim::All).from_reader(text.as_bytes());
        let head = reader.headers().map_err(|e| self.told(&e))?.clone();
        let columns = self.columns(&head, said.first().copied().unwrap_or(1))?;
        let constant = self.constant(&columns);
        // Everything up to the first row stands in the first lines.
        let (mut written, mut line, mut count) = (format!("{ROWS} = ["), 1, 0);
        for row in reader.records() {
            let row = row.map_err(|e| self.told(&e))?;
            // A row's position is that of the empty lines before it.
            let before = row.position().map_or(line, csv::Position::line);
            let own = said.get(said.partition_point(|at| *at < before)).copied().unwrap_or(before);
            while line < own {
                written.push('\n');
                line += 1;
            }
            count += 1;
            if count > MOST_ROWS {
                return Err(self.wrong(line, format!("has more than {MOST_ROWS} stars, which is most that a table may have")));
            }
            written += &self.row(&row, &columns, &constant, (count, line))?;
        }
        if count == 0 {
            return Err(self.wrong(line, "holds no stars below its column names"));
        }
        written.push(']');
        Ok(written)
    }

    /// The columns that are keys of a star.
    fn columns(&self, head: &csv::StringRecord, line: u64) -> Result<Vec<Column>> {
        let asked = self.section.texts("columns")?;
        let is_asked = |name: &str| PLACE.contains(&name) || asked.as_ref().is_none_or(|asked| asked.contains(&name));
        let mut columns: Vec<Column> = Vec::new();
        for (index, cell) in head.iter().enumerate() {
            let (name, unit) = match cell.split_once(['[', '(']) {
                Some((name, unit)) => (name.trim(), Some(unit.trim_end_matches([']', ')']).trim().to_owned())),
                None => (cell, None),
            };
            let name = name.to_lowercase();
            if !is_asked(&name) {
                continue;
            }
            let place = PLACE.contains(&name.as_str()).then_some("length");
            let Some(kind) = place.or_else(|| keys().find(|key| key.name == name).map(|key| key.kind)) else {
                let known = PLACE.into_iter().chain(keys().map(|key| key.name));
                // Catalogues have columns that mean nothing here; one that is misspelt does.
                if let Some(near) = nearest(&name, known).filter(|near| name.len() > 3 && near.len().abs_diff(name.len()) <= 1) {
                    return Err(self.wrong(line, format!("unknown column \"{name}\", did you mean \"{near}\"?")));
                }
                continue;
            };
            if columns.iter().any(|column| column.name == name) {
                return Err(self.wrong(line, format!("has two columns \"{name}\"")));
            }
            if self.section.has(&name) {
                let message = format!("\"{name}\" is a column of {} too; leave one of them out", self.file);
                return Err(self.section.error(&name, message));
            }
            columns.push(Column { index, name, unit, kind });
        }
        let found = |name: &str| columns.iter().find(|column| column.name == name);
        if let Some(missing) = PLACE.into_iter().find(|name| found(name).is_none()) {
            let named: Vec<&str> = head.iter().collect();
            return Err(
                self.wrong(line, format!("has no column \"{missing}\" ({}); write x, y, z, with a unit like \"x [pc]\"", named.join(", ")))
            );
        }
        if let Some(missing) = asked.iter().flatten().find(|name| found(name).is_none()) {
            return Err(self.section.error("columns", format!("{} has no column \"{missing}\" that a star could say", self.file)));
        }
        let units: Vec<_> = PLACE.into_iter().filter_map(found).map(|column| &column.unit).collect();
        if units.iter().any(|unit| *unit != units[0]) {
            return Err(self.wrong(line, "has x, y and z in different units; write them in one"));
        }
        Ok(columns)
    }

    /// What all stars say.
    fn constant(&self, columns: &[Column]) -> Vec<String> {
        let mut constant = self.section.inline(keys().map(|key| key.name));
        if !self.section.has("kind") && columns.iter().all(|column| column.name != "kind") {
            let kind = if columns.iter().any(|column| column.name == "type") { "stellar" } else { "blackbody" };
            constant.push(format!("kind = \"{kind}\""));
        }
        constant
    }

    /// One star.
    fn row(&self, row: &csv::StringRecord, columns: &[Column], constant: &[String], (number, line): (usize, u64)) -> Result<String> {
        let cell = |column: &Column| row.get(column.index).unwrap_or("");
        let mut place = Vec::new();
        for column in PLACE.into_iter().filter_map(|name| columns.iter().find(|column| column.name == name)) {
            let number = cell(column).parse::<f64>().ok().filter(|number| number.is_finite());
            let wrong = || {
                let (name, cell) = (&column.name, cell(column));
                self.wrong(
                    line,
                    format!("{name} = \"{cell}\" is not a number; its unit stands behind the name of its column, like \"{name} [pc]\""),
                )
            };
            place.push(number.ok_or_else(wrong)?.to_string());
        }
        let unit = columns.iter().find(|column| column.name == PLACE[0]).and_then(|x| x.unit.as_deref());
        place.push(unit.unwrap_or(PLACE_UNIT).to_owned());
        let mut values = constant.to_vec();
        values.push(format!("position = {}", one_line(&place.join(" "))));
        // An empty cell says nothing.
        let others = columns.iter().filter(|column| !PLACE.contains(&column.name.as_str()) && !cell(column).is_empty());
        values.extend(others.map(|column| format!("{} = {}", column.name, column.value(cell(column)))));
        if values.iter().all(|value| !value.starts_with("name = ")) {
            values.push(format!("name = \"star {number} of table {}\"", self.section.name()));
        }
        Ok(format!("{{ {} }}, ", values.join(", ")))
    }
}

impl Column {
    /// A cell as a value of a scene.
    fn value(&self, cell: &str) -> String {
        let is_number = cell.parse::<f64>().is_ok();
        let quantity = QUANTITIES.iter().any(|quantity| quantity.name == self.kind);
        match self.kind {
            "number" if is_number => cell.parse::<f64>().map_or_else(|_| one_line(cell), |number| format!("{number:?}")),
            "boolean" if ["true", "false"].contains(&cell.to_lowercase().as_str()) => cell.to_lowercase(),
            _ if quantity && is_number => {
                let usual = UNITS.iter().find(|(name, _)| *name == self.name).map(|(_, unit)| *unit);
                one_line(format!("{cell} {}", self.unit.as_deref().or(usual).unwrap_or("")).trim_end())
            }
            _ => one_line(cell),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    const SCENE: &str = "[camera]\nkind = \"perspective\"\nposition = \"0 0 6 pc\"\nfield_of_view = \"30 deg\"\nsize = [16, 16]\n";

    /// The stars of a scene with this table of stars, beside those of a scene in which they stand one by one.
    fn stars(csv: &str, keys: &str) -> Result<Vec<Star>> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("cluster.csv"), csv).unwrap();
        parsed(&format!("{SCENE}[[star_table]]\nfile = \"cluster.csv\"\n{keys}"), folder.path())
    }

    fn parsed(text: &str, folder: &std::path::Path) -> Result<Vec<Star>> {
        Scene::parse("test.toml", "test", text.into(), &Loader::in_folder(folder, 1 << 30)).map(|scene| scene.stars)
    }

    fn same(ours: &[Star], theirs: &str) {
        let theirs = parsed(&format!("{SCENE}{theirs}"), std::path::Path::new("")).unwrap();
        assert_eq!(ours.len(), theirs.len());
        for (a, b) in ours.iter().zip(&theirs) {
            assert!(a.name == b.name && a.position == b.position && a.visible == b.visible, "{a:?} {b:?}");
            for l in [0.4, 0.55, 0.9] {
                assert_eq!(a.spectrum.continuum(l), b.spectrum.continuum(l));
            }
        }
    }

    /// Rows are stars as `[[star]]` has them: units of columns, of cells and the usual ones, other separators, columns that mean nothing, comments, empty cells, keys of all.
    #[test]
    fn rows_are_stars() {
        let ours = stars(
            "# made by hand\nName, x [au], Y [au], z [au], temperature, luminosity [W], ra\n\n\"a, b\", 1, -2, 3e5, 9000, 1e28, 0.1\n# a pause\nc, 0, 0, 1, 5 kK, 2 Lsun, \n",
            "visible = false\n",
        );
        let one = |name: &str, place: &str, temperature: &str, luminosity: &str| {
            format!(
                "[[star]]\nname = \"{name}\"\nkind = \"blackbody\"\nposition = \"{place}\"\ntemperature = \"{temperature}\"\nluminosity = \"{luminosity}\"\nvisible = false\n"
            )
        };
        same(&ours.unwrap(), &(one("a, b", "1 -2 3e5 au", "9000 K", "1e28 W") + &one("c", "0 0 1 au", "5000 K", "2 Lsun")));
        let ours = stars("x;y;z;type;magnitude;visible\n1;2;3;o9v;4.5;TRUE\n1;2;4;;5;false\n", "distance = \"400 pc\"\n");
        assert!(ours.unwrap_err().to_string().contains("\"type\" is missing"));
        let ours = stars("x y z type magnitude visible\n1 2 3 o9v 4.5 TRUE\n1 2 4 a0v 5 false\n", "distance = \"400 pc\"\n");
        let one = |n: u32, z: f64, kind: &str, magnitude: f64| {
            format!(
                "[[star]]\nname = \"star {n} of table 1\"\nkind = \"stellar\"\ntype = \"{kind}\"\nposition = \"1 2 {z} pc\"\nmagnitude = \"{magnitude} mag\"\ndistance = \"400 pc\"\nvisible = {}\n",
                n == 1
            )
        };
        same(&ours.unwrap(), &(one(1, 3.0, "o9v", 4.5) + &one(2, 4.0, "a0v", 5.0)));
    }

    /// Byte order marks, the line ends of Windows, lines of blanks, many blanks between columns, and columns that are not asked for.
    #[test]
    fn tables_of_all_kinds_are_read() {
        let one = "[[star]]\nname = \"star 1 of table 1\"\nkind = \"blackbody\"\nposition = \"1 2 3 pc\"\ntemperature = \"5000 K\"\nluminosity = \"7 Lsun\"\n";
        for (csv, keys) in [
            ("\u{feff}# a, b\r\nx;y;z;temperature;luminosity\r\n   \r\n1;2;3;5000;7\r\n", ""),
            ("  x     y   z  temperature   luminosity\n   \n 1.0  2.0   3.0   5000     7\n", ""),
            ("x,y,z,temperature,luminosity,type,distance,radius\n1,2,3,5000,7,g2v,4,5\n", "columns = [\"temperature\", \"luminosity\"]\n"),
        ] {
            same(&stars(csv, keys).unwrap(), one);
        }
    }

    /// What is wrong is said with file, line and what would be right.
    #[test]
    fn mistakes_are_named() {
        let head = "x,y,z,temperature,luminosity\n";
        let many = head.to_owned() + &"0,0,0,5000,1\n".repeat(MOST_ROWS + 1);
        for (csv, keys, words) in [
            ("", "", &["no line of column names", "cluster.csv:1"][..]),
            (head, "", &["holds no stars"]),
            ("# nothing\nx,y,temperature\n0,0,1\n", "", &["no column \"z\"", "cluster.csv:2"]),
            ("x,y,z,temprature,luminosity\n0,0,0,5000,1\n", "", &["unknown column \"temprature\"", "\"temperature\"", "cluster.csv:1"]),
            ("x [pc],y,z,temperature,luminosity\n0,0,0,5000,1\n", "", &["different units"]),
            ("x,y,z,x\n0,0,0,0\n", "", &["two columns \"x\""]),
            (&format!("{head}0,0,0,5000,1\n\n0,0,nan,5000,1\n"), "", &["z = \"nan\" is not a number", "cluster.csv:4"]),
            (&format!("{head}0,0,0,5000 m,1\n"), "", &["unknown unit", "cluster.csv:2", "temperature"]),
            (&format!("{head}0,0,0,-5000,1\n"), "", &["not above zero", "cluster.csv:2"]),
            (&format!("{head}0,0,0,5000\n"), "", &["has 4 cells", "cluster.csv:2"]),
            (&format!("{head}0,,0,5000,1\n"), "", &["y = \"\" is not a number", "cluster.csv:2"]),
            (&format!("name,{head}\"a\nb\",0,0,0,5000,1\nc,0,0,0,-1,1\n"), "", &["not above zero", "cluster.csv:4"]),
            (&format!("{head}0,0,0,5000,1\n"), "kind = \"file\"\n", &["no spectra of files", "test.toml"]),
            (&format!("{head}0,0,0,5000,1\n"), "columns = [\"radius\"]\n", &["no column \"radius\""]),
            (&format!("{head}0,0,0,\"50\" }}\",1\n"), "", &["cluster.csv:2"]),
            (&format!("{head}0,0,0,5000,1\n"), "temperature = \"4000 K\"\n", &["is a column of", "test.toml:8"]),
            (&format!("{head}0,0,0,5000,1\n"), "position = \"0 0 0 pc\"\n", &["unknown key \"position\""]),
            (&format!("{head}0,0,0,5000,1\n"), "kind = \"stellar\"\n", &["type", "cluster.csv:2"]),
            (&many, "", &["more than 20000 stars"]),
        ] {
            let error = stars(csv, keys).unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{}: {error}", &csv[..csv.len().min(60)]);
        }
        let error = parsed(&format!("{SCENE}[[star_table]]\nfile = \"none.csv\"\n"), std::path::Path::new("")).unwrap_err().to_string();
        assert!(error.contains("none.csv") && error.contains("cannot be read"), "{error}");
    }
}

//! VOTable: the tables of the Virtual Observatory, as the SVO Filter Profile Service writes them.
//!
//! Source: IVOA Recommendation VOTable 1.5 (2025). Cells are read as TABLEDATA; BINARY, BINARY2 and FITS are refused.

use roxmltree::{Document, Node, ParsingOptions};
use spectra::curve::{Column, Columns};
use spectra::table::MAX_SAMPLES;
use spectra::{Result, SpectraError};

/// Most nodes of a document, each of some hundred bytes.
const MAX_NODES: u32 = 8_000_000;
/// The parameter by which SVO says what a detector counts: 0 is energy, 1 photons.
const DETECTOR_TYPE: &str = "DetectorType";

/// Reads the first table of a document.
///
/// # Errors
/// If the document is no XML, holds no table of numbers, or encodes it in another way.
pub fn parse(name: &str, text: &str) -> Result<Columns> {
    let refuse = |reason: String| SpectraError::table(name, reason);
    let options = ParsingOptions { allow_dtd: false, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| refuse(format!("is not a valid VOTable: {e}")))?;
    let named = |node: &Node, tag: &str| node.is_element() && node.tag_name().name() == tag;
    let table = document.descendants().find(|node| named(node, "TABLE")).ok_or_else(|| refuse("holds no TABLE".into()))?;
    let fields: Vec<Node> = table.children().filter(|node| named(node, "FIELD")).collect();
    let Some(data) = table.descendants().find(|node| named(node, "TABLEDATA")) else {
        return Err(refuse("has a binary table, which is unsupported; save it as TABLEDATA, ECSV or text".into()));
    };
    let detector = document.descendants().find(|node| named(node, "PARAM") && node.attribute("name") == Some(DETECTOR_TYPE));
    let mut columns = Columns {
        columns: fields
            .iter()
            .map(|field| Column {
                name: field.attribute("name").or_else(|| field.attribute("ID")).unwrap_or_default().to_owned(),
                unit: field.attribute("unit").map(str::to_owned),
            })
            .collect(),
        dialect: "of a VOTable".into(),
        counts_photons: detector.and_then(|node| node.attribute("value")).map(|value| value.trim() == "1"),
        ..Columns::default()
    };
    for row in data.children().filter(|node| named(node, "TR")) {
        let line = document.text_pos_at(row.range().start).row as usize;
        let cells = row.children().filter(|node| named(node, "TD")).map(|cell| cell.text().unwrap_or("").trim());
        let number = |cell: &str| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
        // A column of texts next to the numbers is no number.
        let values: Vec<f64> = cells.map(|cell| number(cell).unwrap_or(f64::NAN)).collect();
        if values.len() != fields.len() {
            return Err(refuse(format!("line {line} has {} cells, the table {} fields", values.len(), fields.len())));
        }
        if columns.rows.len() == MAX_SAMPLES {
            return Err(refuse(format!("has more than {MAX_SAMPLES} rows")));
        }
        columns.rows.push((line, values));
    }
    if columns.rows.is_empty() || fields.len() < 2 {
        return Err(refuse("has no rows of two or more numbers".into()));
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SVO: &str = r#"<?xml version="1.0"?>
<VOTABLE version="1.1" xmlns="http://www.ivoa.net/xml/VOTable/v1.1">
  <RESOURCE type="results"><TABLE>
    <PARAM name="DetectorType" value="1" datatype="char" arraysize="*"/>
    <FIELD name="Wavelength" ucd="em.wl" unit="Angstrom" datatype="double"/>
    <FIELD name="Transmission" ucd="phys.transmission" unit="" datatype="double"/>
    <DATA><TABLEDATA>
      <TR><TD>5000.0</TD><TD>0.5</TD></TR>
      <TR><TD>6000.0</TD><TD>0.8</TD></TR>
    </TABLEDATA></DATA>
  </TABLE></RESOURCE>
</VOTABLE>"#;

    #[test]
    fn a_filter_of_svo_is_read() {
        let columns = parse("svo.xml", SVO).unwrap();
        assert_eq!(columns.columns[0].unit.as_deref(), Some("Angstrom"));
        assert_eq!((columns.rows[1].1.as_slice(), columns.counts_photons), (&[6000.0, 0.8][..], Some(true)));
        for (from, to, words) in [
            ("<TD>0.8</TD>", "", "line 9"),
            ("TABLEDATA", "BINARY", "binary"),
            ("</TABLE>", "", "valid VOTable"),
            ("<TR><TD>5000.0</TD><TD>0.5</TD></TR>\n      <TR><TD>6000.0</TD><TD>0.8</TD></TR>", "", "no rows"),
        ] {
            let error = parse("svo.xml", &SVO.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}

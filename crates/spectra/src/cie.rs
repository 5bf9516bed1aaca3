//! The eye: colour matching functions of the CIE 1931 standard observer, 2°.

use std::sync::OnceLock;

use crate::embedded::embedded_columns;
use crate::error::Result;
use crate::table::Table;

/// The colour matching functions x̄, ȳ, z̄ over λ \[µm\].
///
/// # Errors
/// If the embedded tables are broken, which a test rules out.
pub fn matching_functions() -> Result<&'static [Table; 3]> {
    static FUNCTIONS: OnceLock<Result<[Table; 3]>> = OnceLock::new();
    let functions = FUNCTIONS.get_or_init(|| {
        let columns = embedded_columns("cie1931", include_str!("../data/cie/cie1931_xyz_2deg.csv"), 4)?;
        let table = |c: usize| Table::new("cie1931", columns[0].iter().map(|nm| nm * 1e-3).collect(), columns[c].clone());
        Ok([table(1)?, table(2)?, table(3)?])
    });
    functions.as_ref().map_err(Clone::clone)
}

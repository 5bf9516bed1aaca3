//! Extinction of O'Donnell 1994: CCM89 with a better optical part.
//!
//! k(λ) = a(x) + b(x)/R_V,  x = 1/λ;  a, b of eighth degree in y = x − 1.82 for 1.1 ≤ x < 3.3 µm⁻¹
//!
//! Valid for 0.3 ≤ x ≤ 10 µm⁻¹ and 2 ≤ R_V ≤ 6. Source: ApJ 422, 158, table 2, 10.1086/173713.

use super::ccm89::{Ccm89, Optical};
use super::{LawEntry, Maker};

pub(super) const ENTRY: LawEntry = LawEntry {
    name: "odonnell94",
    summary: "O'Donnell 1994 with R_V 2 to 6: CCM89 with new optical coefficients; 0.1 to 3.33 um",
    maker: Maker::RatioOfV { low: 2.0, high: 6.0, make: |r_v| Box::new(Ccm89 { r_v, optical: OPTICAL }) },
};

const OPTICAL: Optical = (
    &[-0.505, 1.647, -0.827, -1.718, 1.137, 0.701, -0.609, 0.104, 1.0],
    &[3.347, -10.805, 5.491, 11.102, -7.985, -3.989, 2.908, 1.952, 0.0],
);

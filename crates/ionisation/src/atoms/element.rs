//! The elements that are followed.

/// Elements that are followed.
pub const ELEMENTS: usize = 9;
/// Ions of an element that are followed at most: charges of 0 to 5.
pub const STAGES: usize = 6;

/// An element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Element {
    /// H
    Hydrogen,
    /// He
    Helium,
    /// C
    Carbon,
    /// N
    Nitrogen,
    /// O
    Oxygen,
    /// Ne
    Neon,
    /// Mg
    Magnesium,
    /// Si
    Silicon,
    /// S
    Sulphur,
}

impl Element {
    /// All of them, in the order of their nuclei.
    pub const ALL: [Self; ELEMENTS] = [
        Self::Hydrogen,
        Self::Helium,
        Self::Carbon,
        Self::Nitrogen,
        Self::Oxygen,
        Self::Neon,
        Self::Magnesium,
        Self::Silicon,
        Self::Sulphur,
    ];
    /// Elements other than hydrogen and helium.
    pub const METALS: [Self; ELEMENTS - 2] =
        [Self::Carbon, Self::Nitrogen, Self::Oxygen, Self::Neon, Self::Magnesium, Self::Silicon, Self::Sulphur];

    /// The charge of the nucleus.
    pub fn nucleus(self) -> usize {
        [1, 2, 6, 7, 8, 10, 12, 14, 16][self as usize]
    }

    /// The mean mass of an atom \[u\]: standard atomic weights (IUPAC 2021, abridged).
    pub fn mass_u(self) -> f64 {
        [1.008, 4.0026, 12.011, 14.007, 15.999, 20.180, 24.305, 28.085, 32.06][self as usize]
    }

    /// The symbol, as "Ne".
    pub fn symbol(self) -> &'static str {
        ["H", "He", "C", "N", "O", "Ne", "Mg", "Si", "S"][self as usize]
    }

    /// The element whose nucleus has this charge.
    pub fn of_nucleus(charge: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|element| element.nucleus() == charge)
    }

    /// The highest charge of its ions that is followed.
    pub fn charges(self) -> usize {
        self.nucleus().min(STAGES - 1)
    }

    /// The name of an ion in tables of lines: "O3" is O²⁺.
    pub fn ion(self, charge: usize) -> String {
        format!("{}{}", self.symbol(), charge + 1)
    }
}

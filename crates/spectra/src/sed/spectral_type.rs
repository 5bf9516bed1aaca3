//! Spectral types as people write them: `B3V`, `o9.5 V`, `K0 III`, `M2 Iab`, `B2-3 IV`, and as the library of Pickles
//! 1998 names its columns: `m2p5v`, `b57v`, `rg5iii`.

/// A Morgan–Keenan type of a star.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralType {
    /// Metal-rich, metal-weak or neither: `r`, `w` or a space.
    pub metals: char,
    /// 0 at O0, 10 at B0, … 60 at M0.
    pub subclass: f64,
    /// 1 for supergiants (I), … 5 for dwarfs (V).
    pub luminosity: u8,
}

const LETTERS: &str = "obafgkm";
const CLASSES: [&str; 5] = ["i", "ii", "iii", "iv", "v"];

impl SpectralType {
    /// Reads a type from its name; none where it is no type of one luminosity class.
    pub fn parse(name: &str) -> Option<Self> {
        let compact: String = name.to_lowercase().chars().filter(|c| !c.is_whitespace()).collect();
        let (metals, rest) = match compact.chars().next()? {
            c @ ('r' | 'w') => (c, &compact[1..]),
            _ => (' ', &compact[..]),
        };
        let letter = LETTERS.find(rest.chars().next()?)?;
        let rest = &rest[1..];
        let class = rest.find(['i', 'v'])?;
        let subclass = subclass(&rest[..class])?;
        // Ia, Iab and Ib are one class, and peculiarities that follow (e, n, p …) are none of a library's business.
        let (roman, after): (String, String) = {
            let end = rest[class..].find(|c| !matches!(c, 'i' | 'v')).map_or(rest.len(), |n| class + n);
            (rest[class..end].into(), rest[end..].into())
        };
        // Between two classes (IV-V, III/IV) and two stars (B2V+B3V) are no single one.
        if after.starts_with(['-', '/']) && after[1..].starts_with(['i', 'v']) || after.contains('+') {
            return None;
        }
        let luminosity = CLASSES.iter().position(|c| *c == roman)? as u8 + 1;
        // M10 is the library's own; of other letters ten is the next one's zero.
        let last = if letter + 1 == LETTERS.len() { 10.0 } else { 9.9 };
        (0.0..=last).contains(&subclass).then_some(Self { metals, subclass: 10.0 * letter as f64 + subclass, luminosity })
    }

    /// The class in Roman numerals.
    pub fn roman(self) -> String {
        CLASSES[usize::from(self.luminosity) - 1].to_uppercase()
    }

    /// The letter and subclass, such as `B2.5`.
    pub fn letter(self) -> String {
        let letter = ((self.subclass / 10.0) as usize).min(LETTERS.len() - 1);
        format!("{}{}", LETTERS[letter..=letter].to_uppercase(), self.subclass - 10.0 * letter as f64)
    }
}

/// `3`, `9.5`, `2p5`, `2-3` and `57`, which is from 5 to 7; `10` is ten.
fn subclass(text: &str) -> Option<f64> {
    let (first, second) = match text.split_once('-') {
        Some(range) => range,
        None if text.len() == 2 && text != "10" && text.bytes().all(|b| b.is_ascii_digit()) => text.split_at(1),
        None => (text, text),
    };
    let number = |t: &str| {
        let plain = t.replace('p', ".");
        plain.bytes().all(|b| b.is_ascii_digit() || b == b'.').then(|| plain.parse::<f64>().ok())?
    };
    let (first, second) = (number(first)?, number(second)?);
    (first <= second).then_some(0.5 * (first + second))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_read_as_they_are_written() {
        let class = |name: &str| SpectralType::parse(name).map(|t| (t.metals, t.subclass, t.luminosity));
        for name in ["B3V", "b3v", " B3 V ", "B3 Ve"] {
            assert_eq!(class(name), Some((' ', 13.0, 5)), "{name}");
        }
        assert_eq!(class("O9.5 Iab"), Some((' ', 9.5, 1)));
        assert_eq!(class("k0III"), Some((' ', 50.0, 3)));
        assert_eq!(class("m2p5v"), Some((' ', 62.5, 5)));
        assert_eq!(class("b57v"), Some((' ', 16.0, 5)));
        assert_eq!(class("B2-3 IV"), Some((' ', 12.5, 4)));
        assert_eq!(class("m10iii"), Some((' ', 70.0, 3)));
        assert_eq!(class("rG5III"), Some(('r', 45.0, 3)));
        for name in
            ["", "V", "B3", "Q3V", "B3VI", "b-3v", "DA2", "WN5", "b..v", "b1e9v", "b1e0v", "F5IV-V", "B1III/IV", "B2V+B3V", "K10V", "B52V"]
        {
            assert_eq!(class(name), None, "{name}");
        }
        assert_eq!(SpectralType::parse("b2.5iv").map(|t| t.letter() + &t.roman()), Some("B2.5IV".into()));
    }
}

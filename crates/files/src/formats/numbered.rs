//! Names of files with the number of a frame in them.

use std::path::{Path, PathBuf};

/// The file of a frame: `%06d` or `######` in its name stands for the number.
pub fn numbered(pattern: &Path, number: i64) -> Option<PathBuf> {
    let name = pattern.file_name()?.to_str()?;
    let (before, width, after) = placeholder(name)?;
    let digits = number.unsigned_abs().to_string();
    let sign = if number < 0 { "-" } else { "" };
    let zeros = "0".repeat(width.saturating_sub(digits.len() + sign.len()));
    Some(pattern.with_file_name(format!("{before}{sign}{zeros}{digits}{after}")))
}

/// Prefix, number width and suffix of a file name.
fn placeholder(name: &str) -> Option<(&str, usize, &str)> {
    const WIDEST: usize = 20;
    for (start, _) in name.match_indices('%') {
        let rest = &name[start + 1..];
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let width = if digits == 0 { Some(0) } else { rest[..digits].parse().ok().filter(|n| *n <= WIDEST) };
        if let (Some(width), Some(after)) = (width, rest[digits..].strip_prefix('d')) {
            return Some((&name[..start], width, after));
        }
    }
    let start = name.find('#')?;
    let width = name[start..].chars().take_while(|c| *c == '#').count();
    (width <= WIDEST).then(|| (&name[..start], width, &name[start + width..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_numbers() {
        let name = |pattern: &str, number: i64| numbered(Path::new(pattern), number).map(|path| path.display().to_string());
        assert_eq!(name("out/a_%06d.exr", 12).unwrap(), "out/a_000012.exr");
        assert_eq!(name("a%d.png", 12).unwrap(), "a12.png");
        assert_eq!(name("a_####.png", -7).unwrap(), "a_-007.png");
        assert_eq!(name("a_%3d.png", 12345).unwrap(), "a_12345.png");
        assert_eq!(name("a_%V_%03d.png", 7).unwrap(), "a_%V_007.png");
        for none in ["a.png", "a_%s.png", "a_%99d.png", "%"] {
            assert!(name(none, 1).is_none(), "{none}");
        }
    }
}

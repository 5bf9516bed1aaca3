//! Loops of a shader that are written out turn by turn.
//!
//! A loop whose first line ends with `// written out` is repeated for each value of its variable, which becomes a
//! constant: arrays are then indexed by constants and stay in registers, and nothing counts turns. Its text stays WGSL
//! that runs as it stands, and it is left as a loop where there would be too much of it.

/// Most turns of a loop that are written out.
pub const MOST_TURNS: usize = 8;

/// Most entries of a list whose loops are written out, all together.
pub const MOST_ENTRIES: usize = 32;

/// The end of the first line of a loop that is written out.
const MARK: &str = "// written out";

/// The constants of a shape that loops run to.
pub struct Limits {
    /// Most turns that are written out.
    pub most: usize,
    /// Numbers, by name.
    pub numbers: Vec<(&'static str, usize)>,
    /// Lists, by name; the loop around says which entry is meant.
    pub lists: Vec<(&'static str, Vec<usize>)>,
}

/// The first line of a loop: `for (var b = 0u; b < BANDS; b++) { // written out`.
struct Head<'a> {
    variable: &'a str,
    limit: &'a str,
}

impl<'a> Head<'a> {
    fn of(line: &'a str) -> Option<Self> {
        let inner = line.trim().strip_suffix(MARK)?.trim_end().strip_prefix("for (var ")?.strip_suffix("++) {")?;
        let (variable, rest) = inner.split_once(" = 0u; ")?;
        let (limit, _) = rest.strip_prefix(variable)?.strip_prefix(" < ")?.split_once(';')?;
        Some(Self { variable, limit })
    }

    /// The number of turns that are written out; none where no constant says so, or it would be too many.
    fn turns(&self, limits: &Limits, around: &[(String, usize)]) -> Option<usize> {
        let Some((list, index)) = self.limit.strip_suffix(']').and_then(|limit| limit.split_once('[')) else {
            return limits.numbers.iter().find(|(name, _)| *name == self.limit).map(|(_, n)| *n).filter(|n| *n <= limits.most);
        };
        let (_, entries) = limits.lists.iter().find(|(name, _)| *name == list)?;
        let (_, at) = around.iter().rev().find(|(variable, _)| variable == index)?;
        entries.get(*at).copied().filter(|_| entries.iter().sum::<usize>() <= MOST_ENTRIES)
    }
}

/// The source with its marked loops written out.
pub fn written_out(source: &str, limits: &Limits) -> String {
    let lines: Vec<&str> = source.lines().collect();
    let mut out = String::with_capacity(2 * source.len());
    write(&lines, limits, &mut Vec::new(), &mut out);
    out
}

fn write(lines: &[&str], limits: &Limits, around: &mut Vec<(String, usize)>, out: &mut String) {
    let mut at = 0;
    while let Some(line) = lines.get(at) {
        let turns = Head::of(line).and_then(|head| Some((head.turns(limits, around)?, head)));
        let Some((turns, head)) = turns else {
            *out += line;
            out.push('\n');
            at += 1;
            continue;
        };
        let end = at + end_of(&lines[at..]);
        let indent = &line[..line.len() - line.trim_start().len()];
        for turn in 0..turns {
            *out += &format!("{indent}{{\n{indent}    const {} = {turn}u;\n", head.variable);
            around.push((head.variable.to_owned(), turn));
            write(&lines[at + 1..end], limits, around, out);
            around.pop();
            *out += &format!("{indent}}}\n");
        }
        at = end + 1;
    }
}

/// The line on which a block ends that begins on the first.
fn end_of(lines: &[&str]) -> usize {
    let mut depth = 0;
    for (i, line) in lines.iter().enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        depth += code.matches('{').count();
        depth -= code.matches('}').count();
        if depth == 0 {
            return i;
        }
    }
    lines.len() - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits {
            most: 8,
            numbers: vec![("BANDS", 2), ("STARS", 0), ("MANY", 9)],
            lists: vec![("TERMS_OF", vec![1, 2]), ("LONG", vec![3, 30])],
        }
    }

    #[test]
    fn loops_are_repeated_with_constants() {
        let source = "for (var b = 0u; b < BANDS; b++) { // written out\n    x[b] = 0.0;\n}\ny = 1.0;\n";
        let written = "{\n    const b = 0u;\n    x[b] = 0.0;\n}\n{\n    const b = 1u;\n    x[b] = 0.0;\n}\ny = 1.0;\n";
        assert_eq!(written_out(source, &limits()), written);
    }

    #[test]
    fn loops_within_loops_know_their_lists() {
        let source = "for (var b = 0u; b < BANDS; b++) { // written out\n    for (var t = 0u; t < TERMS_OF[b]; t++) { // written out\n        f(b, t);\n    }\n}\n";
        assert_eq!(written_out(source, &limits()).matches("f(b, t)").count(), 3);
    }

    #[test]
    fn other_loops_stay() {
        for limit in ["BANDS", "MANY", "UNKNOWN", "TERMS_OF[b]"] {
            let mark = if limit == "BANDS" { "" } else { " // written out" };
            let source = format!("for (var b = 0u; b < {limit}; b++) {{{mark}\n    f(b);\n}}\n");
            assert_eq!(written_out(&source, &limits()), source);
        }
        let source =
            "for (var b = 0u; b < BANDS; b++) { // written out\n    for (var t = 0u; t < LONG[b]; t++) { // written out\n    }\n}\n";
        assert_eq!(written_out(source, &limits()).matches("for (var t").count(), 2);
        assert_eq!(written_out("for (var s = 0u; s < STARS; s++) { // written out\n    f(s);\n}\n", &limits()), "");
    }
}

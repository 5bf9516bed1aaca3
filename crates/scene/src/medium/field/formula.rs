//! Formulas as they are written in mathematics, parsed to terms.
//!
//! −x² is −(x²); names are those of fields, whatever functions they begin with; numbers may have exponents (1e-3). What can be read in two
//! ways (a^b^c, a/−b) is refused with the remedy.

use std::fmt::{Display, Formatter};
use std::sync::Arc;

use super::operators::{Binary, Term, Unary};

/// Names that no field may have: coordinates and π.
pub const RESERVED: [&str; 4] = ["x", "y", "z", "pi"];
/// Functions of one argument that formulas may call.
pub(super) const FUNCTIONS: [(&str, Unary); 11] = [
    ("sqrt", Unary::Sqrt),
    ("exp", Unary::Exp),
    ("ln", Unary::Ln),
    ("log10", Unary::Log10),
    ("abs", Unary::Abs),
    ("sin", Unary::Sin),
    ("cos", Unary::Cos),
    ("tan", Unary::Tan),
    ("tanh", Unary::Tanh),
    ("floor", Unary::Floor),
    ("ceil", Unary::Ceil),
];
/// Functions of two arguments that formulas may call.
pub(super) const FUNCTIONS_OF_TWO: [(&str, Binary); 3] = [("min", Binary::Min), ("max", Binary::Max), ("step", Binary::Step)];

/// Names of the functions of one argument that formulas may call.
pub fn functions() -> Vec<&'static str> {
    FUNCTIONS.map(|f| f.0).to_vec()
}

/// Names of the functions of two arguments that formulas may call.
pub fn functions_of_two() -> Vec<&'static str> {
    FUNCTIONS_OF_TWO.map(|f| f.0).to_vec()
}

/// Operators by increasing precedence; equal ones are done from left to right.
const OPERATORS: [(char, Binary); 5] =
    [('+', Binary::Sum), ('-', Binary::Difference), ('*', Binary::Product), ('/', Binary::Quotient), ('^', Binary::Power)];
/// Most parentheses within each other: parsing recurses.
const DEEPEST: usize = 100;

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Sign(char),
}

impl Display for Token {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        match self {
            Token::Number(number) => write!(f, "{number}"),
            Token::Name(name) => write!(f, "\"{name}\""),
            Token::Sign(sign) => write!(f, "\"{sign}\""),
        }
    }
}

/// True if a field may have this name: letters, digits and _, not beginning with a digit, not reserved.
///
/// # Errors
/// If it may not, with a name that would do.
pub fn check_name(name: &str) -> Result<(), String> {
    let word =
        name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !word {
        return Err(format!(
            "\"{name}\" cannot be used in an expression; names of fields have letters, digits and _, and do not begin with a digit"
        ));
    }
    if RESERVED.contains(&name) || functions().contains(&name) || functions_of_two().contains(&name) {
        return Err(format!("\"{name}\" is reserved in expressions; rename the field, such as \"{name}_field\""));
    }
    Ok(())
}

/// A formula that was parsed.
pub(super) struct Parsed {
    /// Names of its variables, sorted.
    pub names: Vec<String>,
    /// Tree of its operations; variables are places among the names.
    pub term: Term,
}

/// Parses a formula; the message says what is wrong.
pub(super) fn parse(formula: &str) -> Result<Parsed, String> {
    let tokens = signed(tokens(formula)?)?;
    let called = |i: usize| tokens.get(i + 1) == Some(&Token::Sign('('));
    let variable = |(i, token): (usize, &Token)| match token {
        Token::Name(name) if !called(i) && name != "pi" => Some(name.clone()),
        _ => None,
    };
    let mut names: Vec<String> = tokens.iter().enumerate().filter_map(variable).collect();
    names.sort();
    names.dedup();
    let mut parser = Parser { tokens: &tokens, at: 0, depth: 0, names: &names };
    let term = parser.binary(0)?;
    match parser.next() {
        None => Ok(Parsed { term, names }),
        Some(Token::Sign(',')) => Err(format!("a comma may only separate the two arguments of {}", functions_of_two().join(", "))),
        Some(token) => Err(format!("{token} is not expected there; an operator may be missing before it")),
    }
}

/// Tokens in which a sign that stands before an operand is a factor: −x² is −1 · x².
fn signed(tokens: Vec<Token>) -> Result<Vec<Token>, String> {
    let mut signed: Vec<Token> = Vec::with_capacity(tokens.len());
    for token in tokens {
        let Token::Sign(sign @ ('+' | '-')) = token else {
            signed.push(token);
            continue;
        };
        match signed.last() {
            Some(Token::Number(_) | Token::Name(_) | Token::Sign(')')) => signed.push(token),
            Some(Token::Sign('/' | '^')) => {
                return Err(format!("a sign after \"/\" or \"^\" is ambiguous; use parentheses, such as a^({sign}2)"));
            }
            _ if sign == '-' => signed.extend([Token::Number(-1.0), Token::Sign('*')]),
            _ => {}
        }
    }
    Ok(signed)
}

/// Reads terms by the precedence of their operators.
struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    /// Parentheses that are open.
    depth: usize,
    names: &'a [String],
}

impl<'a> Parser<'a> {
    fn next(&mut self) -> Option<&'a Token> {
        let token = self.tokens.get(self.at);
        self.at += 1;
        token
    }

    fn is_next(&self, sign: char) -> bool {
        self.tokens.get(self.at) == Some(&Token::Sign(sign))
    }

    /// A term whose operators outside of parentheses have at least a precedence.
    fn binary(&mut self, least: usize) -> Result<Term, String> {
        let mut left = self.operand()?;
        while let Some(Token::Sign(sign)) = self.tokens.get(self.at)
            && let Some(precedence) = OPERATORS.iter().position(|(known, _)| known == sign).filter(|known| *known >= least)
        {
            self.at += 1;
            let right = self.binary(precedence + 1)?;
            if *sign == '^' && self.is_next('^') {
                return Err("a^b^c is ambiguous; write a^(b^c) or (a^b)^c".into());
            }
            left = Term::Two(OPERATORS[precedence].1, Arc::new(left), Arc::new(right));
        }
        Ok(left)
    }

    /// A number, a variable, a function of its arguments, or a term in parentheses.
    fn operand(&mut self) -> Result<Term, String> {
        match self.next() {
            Some(Token::Number(number)) => Ok(Term::Number(*number)),
            Some(Token::Name(name)) if self.is_next('(') => self.call(name),
            Some(Token::Name(name)) if name == "pi" => Ok(Term::Number(std::f64::consts::PI)),
            Some(Token::Name(name)) => match self.names.binary_search(name) {
                Ok(place) => Ok(Term::Variable(place)),
                Err(_) => Err(format!("{name} is unknown")),
            },
            Some(Token::Sign('(')) => {
                let term = self.argument()?;
                self.close("a parenthesis").map(|()| term)
            }
            Some(token) => Err(format!("{token} stands where a number, a name or a parenthesis is expected")),
            None => Err("it ends where a number, a name or a parenthesis is expected".into()),
        }
    }

    /// A function whose parenthesis is next.
    fn call(&mut self, name: &str) -> Result<Term, String> {
        self.at += 1;
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            let argument = self.argument()?;
            self.close(name)?;
            return Ok(Term::One(*function, Arc::new(argument)));
        }
        let Some((_, function)) = FUNCTIONS_OF_TWO.iter().find(|(known, _)| *known == name) else {
            let known = [functions(), functions_of_two()].concat();
            return Err(spectra::SpectraError::unknown("function", name, &known).to_string());
        };
        let first = self.argument()?;
        if !self.is_next(',') {
            return Err(format!("{name} takes two arguments, as in {name}(x, 0.5)"));
        }
        self.at += 1;
        let second = self.argument()?;
        self.close(name)?;
        Ok(Term::Two(*function, Arc::new(first), Arc::new(second)))
    }

    /// A term within parentheses.
    fn argument(&mut self) -> Result<Term, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("parentheses stand within each other more than {DEEPEST} deep"));
        }
        let term = self.binary(0);
        self.depth -= 1;
        term
    }

    fn close(&mut self, opened: &str) -> Result<(), String> {
        match self.next() {
            Some(Token::Sign(')')) => Ok(()),
            Some(Token::Sign(',')) => Err(format!("a comma may only separate the two arguments of {}", functions_of_two().join(", "))),
            Some(token) => Err(format!("{token} is not expected there; an operator may be missing before it")),
            None => Err(format!("{opened} is not closed")),
        }
    }
}

fn tokens(formula: &str) -> Result<Vec<Token>, String> {
    let mut tokens = Vec::new();
    let mut rest = formula.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = if first.is_ascii_digit() || first == '.' {
            let length = number_length(rest);
            let value: Option<f64> = rest[..length].parse().ok().filter(|v: &f64| v.is_finite());
            tokens.push(Token::Number(value.ok_or_else(|| format!("\"{}\" is no number", &rest[..length]))?));
            length
        } else if first.is_ascii_alphabetic() || first == '_' {
            let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            tokens.push(Token::Name(rest[..length].to_owned()));
            length
        } else if "+-*/^(),".contains(first) {
            tokens.push(Token::Sign(first));
            1
        } else {
            return Err(format!("\"{first}\" is not allowed in an expression; use + - * / ^ ( ) and names"));
        };
        rest = rest[length..].trim_start();
    }
    Ok(tokens)
}

/// Digits, a point, and an exponent if digits follow it.
fn number_length(text: &str) -> usize {
    let digits = |t: &str| t.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(t.len());
    let mantissa = digits(text);
    let exponent = &text[mantissa..];
    if !exponent.starts_with(['e', 'E']) {
        return mantissa;
    }
    let sign = usize::from(exponent[1..].starts_with(['+', '-']));
    let count = exponent[1 + sign..].find(|c: char| !c.is_ascii_digit()).unwrap_or(exponent.len() - 1 - sign);
    if count == 0 { mantissa } else { mantissa + 1 + sign + count }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(formula: &str) -> f64 {
        fn of(term: &Term) -> f64 {
            match term {
                Term::Number(number) => *number,
                Term::Variable(_) => f64::NAN,
                Term::One(function, a) => function.of(of(a)),
                Term::Two(function, a, b) => function.of(of(a), of(b)),
            }
        }
        of(&parse(formula).unwrap().term)
    }

    /// Values follow from the rules of mathematics, also of many operations side by side.
    #[test]
    fn operators_bind_as_in_mathematics() {
        for (formula, wanted) in [
            ("2 + 3*4 - 5", 9.0),
            ("10 - 4 - 3", 3.0),
            ("24 / 4 / 3", 2.0),
            ("2 * 6 / 4", 3.0),
            ("-2^2", -4.0),
            ("2 * -3 + 1", -5.0),
            ("2^(-1)", 0.5),
            ("max(1, min(7, 2 + 3)) * 2", 10.0),
            ("step(1, 2) + sqrt(16)", 4.0),
        ] {
            assert_eq!(value(formula), wanted, "{formula}");
        }
        let sum = vec!["1"; 200].join(" + ");
        assert_eq!(value(&sum), 200.0);
    }

    /// Messages say what is wrong.
    #[test]
    fn malformed_formulas_are_refused() {
        let deep = format!("{}1{}", "(".repeat(DEEPEST + 1), ")".repeat(DEEPEST + 1));
        for (formula, part) in [
            ("", "ends"),
            ("2 +", "ends"),
            ("2 3", "operator may be missing"),
            ("(1", "not closed"),
            ("1)", "not expected"),
            ("* 2", "stands where"),
            ("sin()", "stands where"),
            ("min(1)", "two arguments"),
            ("sin(1, 2)", "comma"),
            ("1, 2", "comma"),
            ("a^b^c", "ambiguous"),
            ("a / -b", "ambiguous"),
            ("sine(1)", "sin"),
            (&deep, "deep"),
        ] {
            let message = parse(formula).map(|parsed| parsed.names).unwrap_err();
            assert!(message.contains(part), "{formula}: {message}");
        }
    }
}

//! Formulas as they are written in mathematics, turned into what the expression parser reads without doubt.
//!
//! −x² is −(x²); names are those of fields, whatever functions they begin with; numbers may have exponents (1e-3); functions of two
//! arguments stand between them, f(a, b) becomes ((a)f(b)). What can be read in two ways (a^b^c, a/−b) is refused with the remedy.

/// Names that no field may have: coordinates and π.
pub const RESERVED: [&str; 4] = ["x", "y", "z", "pi"];
/// The functions of one argument that formulas may call.
pub const FUNCTIONS: [&str; 11] = ["sqrt", "exp", "ln", "log10", "abs", "sin", "cos", "tan", "tanh", "floor", "ceil"];
/// The functions of two arguments that formulas may call.
pub const FUNCTIONS_OF_TWO: [&str; 3] = ["min", "max", "step"];

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Name(String),
    Sign(char),
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
    if RESERVED.contains(&name) || FUNCTIONS.contains(&name) || FUNCTIONS_OF_TWO.contains(&name) {
        return Err(format!("\"{name}\" is reserved in expressions; rename the field, such as \"{name}_field\""));
    }
    Ok(())
}

/// The formula with names in braces, exponents written out and signs bound as in mathematics.
pub fn normalised(formula: &str) -> Result<String, String> {
    let tokens = tokens(formula)?;
    let mut out = String::new();
    // For each parenthesis that is open, the function of two arguments that it belongs to, and whether its comma has come.
    let mut open: Vec<(Option<&str>, bool)> = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let before = i.checked_sub(1).map(|j| &tokens[j]);
        match token {
            // Display writes every digit and no exponent.
            Token::Number(value) => out += &value.to_string(),
            Token::Name(name) => {
                let is_called = tokens.get(i + 1) == Some(&Token::Sign('('));
                let word = word(name, is_called)?;
                if !(is_called && of_two(token).is_some()) {
                    out += &word;
                }
            }
            Token::Sign('(') => {
                let function = before.and_then(of_two);
                out += if function.is_some() { "((" } else { "(" };
                open.push((function, false));
            }
            Token::Sign(',') => match open.last_mut() {
                Some((Some(name), comma)) if !*comma => {
                    *comma = true;
                    out += &format!("){name}(");
                }
                _ => return Err(format!("a comma may only separate the two arguments of {}", FUNCTIONS_OF_TWO.join(", "))),
            },
            Token::Sign(')') => match open.pop() {
                Some((Some(name), false)) => return Err(format!("{name} takes two arguments, as in {name}(x, 0.5)")),
                Some((Some(_), true)) => out += "))",
                _ => out.push(')'),
            },
            Token::Sign(sign @ ('+' | '-')) => match before {
                Some(Token::Number(_) | Token::Name(_) | Token::Sign(')')) => out.push(*sign),
                Some(Token::Sign('/' | '^')) => {
                    return Err(format!("a sign after \"/\" or \"^\" is ambiguous; use parentheses, such as a^({sign}2)"));
                }
                _ if *sign == '-' => out += "(0-1)*",
                _ => {}
            },
            Token::Sign('^') => {
                if chained(&tokens, i) {
                    return Err("a^b^c is ambiguous; write a^(b^c) or (a^b)^c".into());
                }
                out.push('^');
            }
            Token::Sign(sign) => out.push(*sign),
        }
    }
    Ok(out)
}

/// The function of two arguments that a token names.
fn of_two(token: &Token) -> Option<&str> {
    match token {
        Token::Name(name) => FUNCTIONS_OF_TWO.contains(&name.as_str()).then_some(name),
        _ => None,
    }
}

fn word(name: &str, called: bool) -> Result<String, String> {
    if called {
        let known: Vec<&str> = FUNCTIONS.iter().chain(&FUNCTIONS_OF_TWO).copied().collect();
        return if known.contains(&name) {
            Ok(name.to_owned())
        } else {
            Err(spectra::SpectraError::unknown("function", name, &known).to_string())
        };
    }
    Ok(if name == "pi" { std::f64::consts::PI.to_string() } else { format!("{{{name}}}") })
}

/// True if another power follows the operand behind the power at `i`.
fn chained(tokens: &[Token], i: usize) -> bool {
    let mut depth = 0;
    for (j, token) in tokens.iter().enumerate().skip(i + 1) {
        match token {
            Token::Sign('(') => depth += 1,
            Token::Sign(')') => depth -= 1,
            _ => {}
        }
        let called = matches!(token, Token::Name(_)) && tokens.get(j + 1) == Some(&Token::Sign('('));
        if depth <= 0 && !called {
            return depth == 0 && tokens.get(j + 1) == Some(&Token::Sign('^'));
        }
    }
    false
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

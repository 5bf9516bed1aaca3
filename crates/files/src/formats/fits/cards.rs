//! Cards of a FITS header, as they are written.

use barnard::keywords::{Keyword, Value};

/// Bytes of a block, and of a card.
pub const BLOCK: usize = 2880;
pub const CARD: usize = 80;

/// Cards of one header, padded to whole blocks at the end.
#[derive(Default)]
pub struct Cards(Vec<u8>);

impl Cards {
    pub fn push(&mut self, card: String) {
        let ascii: String = crate::formats::ascii(&card).chars().take(CARD).collect();
        self.0.extend(format!("{ascii:<CARD$}").bytes());
    }
    pub fn value(&mut self, keyword: &str, value: impl std::fmt::Display, comment: &str) {
        self.push(format!("{keyword:<8}= {:>20} / {comment}", value.to_string()));
    }
    pub fn number(&mut self, keyword: &str, value: f64, comment: &str) {
        self.value(keyword, format!("{value:E}"), comment);
    }
    pub fn text(&mut self, keyword: &str, value: &str, comment: &str) {
        // Quotes are written twice, and no cut parts them.
        let mut text = String::new();
        for c in crate::formats::ascii(value).chars() {
            let written = if c == '\'' { "''".to_owned() } else { c.to_string() };
            if text.len() + written.len() > 66 {
                break;
            }
            text += &written;
        }
        let quoted = format!("'{text:<8}'");
        self.push(format!("{keyword:<8}= {quoted:<20} / {comment}"));
    }
    pub fn keyword(&mut self, keyword: &Keyword) {
        match &keyword.value {
            Value::Text(text) => self.text(keyword.name, text, keyword.comment),
            Value::Number(number) => self.number(keyword.name, *number, keyword.comment),
            Value::Integer(number) => self.value(keyword.name, number, keyword.comment),
        }
    }
    /// Free text, over several cards where it is long, broken between words.
    pub fn history(&mut self, text: &str) {
        const WIDTH: usize = 72;
        let mut line = String::new();
        let text = crate::formats::ascii(text);
        // One word may be longer than a card.
        let pieces = text.split_whitespace().flat_map(|word| word.as_bytes().chunks(WIDTH)).map(String::from_utf8_lossy);
        for word in pieces {
            if !line.is_empty() && line.len() + 1 + word.len() > WIDTH {
                self.push(format!("HISTORY {}", std::mem::take(&mut line)));
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line += &word;
        }
        if !line.is_empty() {
            self.push(format!("HISTORY {line}"));
        }
    }
    pub fn finish(mut self) -> Vec<u8> {
        self.push("END".into());
        self.0.resize(self.0.len().next_multiple_of(BLOCK), b' ');
        self.0
    }
}

//! Fingerprints: 128-bit hashes of content. Equal fingerprints mean equal content.
//!
//! Caches compare the fingerprints of their inputs. The hash is SHA-256, truncated to 128 bits.

use std::fmt;
use std::hash::{BuildHasher, RandomState};
use std::sync::LazyLock;

use sha2::{Digest as _, Sha256};

/// 128-bit hash of content.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Fingerprint([u8; 16]);

impl fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Fingerprint {
    /// As 32 hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl Fingerprint {
    /// The fingerprint of a text.
    pub fn of_text(text: &str) -> Self {
        Digest::new("text").text(text).finish()
    }

    /// The hash as eight integers below 65536, for formats that hold numbers.
    pub fn to_integers(self) -> [u16; 8] {
        std::array::from_fn(|i| u16::from_be_bytes([self.0[2 * i], self.0[2 * i + 1]]))
    }
}

/// Content on its way to a fingerprint.
pub struct Digest(Sha256);

impl Digest {
    /// An empty digest of a type of content; different types never have equal fingerprints.
    pub fn new(kind: &str) -> Self {
        let mut digest = Self(Sha256::new());
        digest.text(kind);
        digest
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Adds a text.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// Adds an integer.
    pub fn integer(&mut self, number: u64) -> &mut Self {
        self.0.update(number.to_le_bytes());
        self
    }

    /// Adds a number, by its bits.
    pub fn number(&mut self, number: f64) -> &mut Self {
        self.integer(number.to_bits())
    }

    /// Adds numbers, by their bits.
    pub fn numbers(&mut self, numbers: &[f64]) -> &mut Self {
        numbers.iter().fold(self.integer(numbers.len() as u64), |digest, number| digest.number(*number))
    }

    /// Adds numbers in single precision, by their bits.
    pub fn singles(&mut self, numbers: &[f32]) -> &mut Self {
        self.integer(numbers.len() as u64);
        let mut buffer = Vec::with_capacity(4 * BUFFER);
        for part in numbers.chunks(BUFFER) {
            buffer.clear();
            part.iter().for_each(|number| buffer.extend_from_slice(&number.to_le_bytes()));
            self.0.update(&buffer);
        }
        self
    }

    /// Adds a part that has a fingerprint of its own.
    pub fn part(&mut self, part: Fingerprint) -> &mut Self {
        self.0.update(part.0);
        self
    }

    /// Adds a plain value: its type, and its derived text for debugging, which has every field with every digit.
    pub fn plain<T: fmt::Debug>(&mut self, value: &T) -> &mut Self {
        self.text(std::any::type_name::<T>()).text(&format!("{value:?}"))
    }

    /// Adds an object of unknown content: its address, its text for debugging, and a random number of the process. Two objects never
    /// pass for the same, not even in two runs of a program.
    pub fn object<T: fmt::Debug + ?Sized>(&mut self, object: &T) -> &mut Self {
        static PROCESS: LazyLock<u64> = LazyLock::new(|| RandomState::new().hash_one(()));
        let address = std::ptr::from_ref(object).cast::<()>().addr();
        self.integer(*PROCESS).integer(address as u64).text(&format!("{object:?}"))
    }

    /// The fingerprint of what was added.
    pub fn finish(&mut self) -> Fingerprint {
        let hash = self.0.clone().finalize();
        Fingerprint(std::array::from_fn(|i| hash[i]))
    }
}

/// Numbers that are hashed together.
const BUFFER: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal content has equal fingerprints; another number, order, boundary or type has another one.
    #[test]
    fn fingerprints_tell_content_apart() {
        let fingerprint = |texts: &[&str], numbers: &[f64]| {
            let mut digest = Digest::new("test");
            for text in texts {
                digest.text(text);
            }
            digest.numbers(numbers).finish()
        };
        let first = fingerprint(&["ab", "c"], &[1.0, 2.0]);
        assert_eq!(first, fingerprint(&["ab", "c"], &[1.0, 2.0]));
        let others = [
            fingerprint(&["a", "bc"], &[1.0, 2.0]),
            fingerprint(&["ab", "c"], &[2.0, 1.0]),
            fingerprint(&["ab", "c"], &[1.0, f64::from_bits(2.0f64.to_bits() + 1)]),
            Digest::new("other").text("ab").text("c").numbers(&[1.0, 2.0]).finish(),
        ];
        assert!(others.iter().all(|other| *other != first));
        assert_eq!(first.to_string().len(), 32);
        // SHA-256 of the empty message begins with e3b0c442 98fc1c14 9afbf4c8 996fb924 (FIPS 180-4).
        assert_eq!(Digest(Sha256::new()).finish().to_string(), "e3b0c44298fc1c149afbf4c8996fb924");
        // An object is known by more than its address and text, which another run of a program may have again.
        let (object, mut digest) = (5, Digest::new("object"));
        let address = std::ptr::from_ref(&object).addr() as u64;
        assert_ne!(digest.object(&object).finish(), Digest::new("object").integer(address).text("5").finish());
        let many: Vec<f32> = (0..10_000).map(|i| i as f32).collect();
        let mut moved = many.clone();
        moved[9_999] += 1.0;
        assert_ne!(Digest::new("").singles(&many).finish(), Digest::new("").singles(&moved).finish());
    }
}

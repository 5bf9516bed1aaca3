//! Immutable numbers in shared memory.

use std::fmt::Debug;
use std::ops::Deref;
use std::sync::Arc;

/// Immutable numbers in shared memory: an array of a file, or one of another program that is not copied. Clones share the memory.
pub struct Shared<T: 'static>(Arc<dyn AsRef<[T]> + Send + Sync>);

impl<T> Shared<T> {
    /// The numbers of `owner`, which must always return the same slice.
    pub fn of(owner: impl AsRef<[T]> + Send + Sync + 'static) -> Self {
        Self(Arc::new(owner))
    }

    /// True if another is the same memory.
    pub fn is(&self, other: &Self) -> bool {
        std::ptr::eq::<[T]>(&**self, &**other)
    }
}

impl<T: Send + Sync> From<Vec<T>> for Shared<T> {
    fn from(numbers: Vec<T>) -> Self {
        Self::of(numbers)
    }
}

impl<T> Deref for Shared<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        (*self.0).as_ref()
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T: Debug> Debug for Shared<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: PartialEq> PartialEq for Shared<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

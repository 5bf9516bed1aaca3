//! A value that a callback of a device sets, and a task awaits.

use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

/// Value that is set once; clones share it.
pub struct Signal<T>(Arc<Mutex<State<T>>>);

struct State<T> {
    value: Option<T>,
    waiting: Option<Waker>,
}

impl<T> Signal<T> {
    pub fn new() -> Self {
        Self(Arc::new(Mutex::new(State { value: None, waiting: None })))
    }

    /// Sets the value and wakes the task.
    pub fn set(&self, value: T) {
        let waiting = {
            let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            state.value = Some(value);
            state.waiting.take()
        };
        waiting.into_iter().for_each(Waker::wake);
    }
}

impl<T> Clone for Signal<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> Future for Signal<T> {
    type Output = T;

    fn poll(self: Pin<&mut Self>, context: &mut Context) -> Poll<T> {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match state.value.take() {
            Some(value) => Poll::Ready(value),
            None => {
                state.waiting = Some(context.waker().clone());
                Poll::Pending
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A task that waits before the value is set, and one that comes later, both receive it.
    #[test]
    fn values_are_awaited() {
        let early = Signal::new();
        let waits = early.clone();
        let task = std::thread::spawn(move || pollster::block_on(waits));
        std::thread::sleep(std::time::Duration::from_millis(20));
        early.set(3);
        assert_eq!(task.join().unwrap(), 3);
        let late = Signal::new();
        late.set(4);
        assert_eq!(pollster::block_on(late), 4);
    }
}

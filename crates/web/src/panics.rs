//! Words of a panic, which a worker reads after the engine has trapped.

use std::cell::RefCell;

use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Has panics leave their words.
#[wasm_bindgen(start)]
pub fn catch_panics() {
    std::panic::set_hook(Box::new(|panic| LAST.set(panic.to_string())));
}

/// Words of the last panic.
#[wasm_bindgen]
#[must_use]
pub fn last_panic() -> String {
    LAST.with_borrow(String::clone)
}

//! Progress of long work, told to the page.

use std::cell::RefCell;

use barnard::control::Control;
use js_sys::Function;
use wasm_bindgen::JsValue;

thread_local! {
    /// Function of the page: stage and finished share \[1\]. A worker has one thread.
    static LISTENER: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// Control whose progress calls a function with the stage and the finished share \[1\].
pub fn control(listener: &Function) -> Control {
    LISTENER.set(Some(listener.clone()));
    Control::with_listener(|stage, done, all| {
        let share = done as f64 / all.max(1) as f64;
        LISTENER.with_borrow(|listener| {
            if let Some(listener) = listener {
                // A page that fails to show progress still gets its picture.
                let _ = listener.call2(&JsValue::NULL, &stage.name().into(), &share.into());
            }
        });
    })
}

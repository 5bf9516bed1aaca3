//! Work off the calling thread: that one waits with the interpreter released, and handles Ctrl-C and progress.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use barnard::control::Control;
use barnard::{Error, Result};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::raised;
use crate::open;

/// Interval between signal checks of the calling thread.
const LOOK: Duration = Duration::from_millis(50);

/// The threads that work; none until somebody works, and in the child of a fork, whose threads stayed behind.
static POOL: Mutex<Option<Arc<ThreadPool>>> = Mutex::new(None);

fn pool(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let mut shared = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(pool) = &*shared {
        return Ok(pool.clone());
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = Arc::new(pool.map_err(|e| PyValueError::new_err(format!("the threads cannot be started: {e}")))?);
    Ok(shared.insert(pool).clone())
}

/// Sets the number of threads of later work; 0 for one per core. The results are the same.
#[pyfunction]
pub fn set_threads(py: Python, threads: usize) -> PyResult<()> {
    if threads > 4096 {
        return Err(PyValueError::new_err(format!("{threads} threads cannot be; give a number from 1 to 4096, or 0 for one a core")));
    }
    py.detach(|| {
        *POOL.lock().unwrap_or_else(PoisonError::into_inner) = None;
        pool(threads).map(|_| ())
    })
}

/// Tells that this process is the child of a fork, in which no thread works.
#[pyfunction]
pub fn after_fork() {
    // The threads of the parent are not there: nobody may wait for them, not even to end them.
    if let Ok(mut pool) = POOL.try_lock() {
        std::mem::forget(pool.take());
    }
    open::after_fork();
}

/// Does `work` on the threads of this module. Meanwhile `progress`, where there is one, is called about twenty times a
/// second as (stage, done, all), and Ctrl-C or an exception of `progress` ends the work.
pub fn run<T: Send>(py: Python, progress: Option<&Bound<PyAny>>, work: impl FnOnce(&Control) -> Result<T> + Send) -> PyResult<T> {
    let pool = py.detach(|| pool(0))?;
    let state = Arc::new(Mutex::new(None));
    let heard = state.clone();
    let control = match progress {
        None => Control::default(),
        Some(_) => Control::with_listener(move |stage, done, all| {
            if let Ok(mut state) = heard.lock() {
                *state = Some((stage, done, all));
            }
        }),
    };
    let (sender, done) = channel::<()>();
    let done = Mutex::new(done);
    let wait = || done.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK);
    let look = || {
        py.check_signals()?;
        let state = state.lock().ok().and_then(|state| *state);
        if let (Some(progress), Some((stage, done, all))) = (progress, state) {
            progress.call1((stage.name(), done, all))?;
        }
        Ok::<(), PyErr>(())
    };
    std::thread::scope(|scope| {
        let control = &control;
        let worker = scope.spawn(move || {
            let result = pool.install(|| work(control));
            // Dropped by a panic as well: the waiting thread is notified.
            drop(sender);
            result
        });
        let mut failed = None;
        while py.detach(wait) == Err(RecvTimeoutError::Timeout) {
            if failed.is_none()
                && let Err(error) = look()
            {
                control.interrupt();
                failed = Some(error);
            }
        }
        let result = py.detach(|| worker.join()).unwrap_or_else(|panic| resume_unwind(panic));
        match (failed, result) {
            (Some(error), _) => Err(error),
            (None, Err(Error::Interrupted)) => Err(raised(py, Error::Interrupted)),
            (None, result) => {
                let last = look();
                result.map_err(|error| raised(py, error)).and_then(|value| last.map(|()| value))
            }
        }
    })
}

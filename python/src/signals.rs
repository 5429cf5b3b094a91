//! Ctrl-C while the library works: Python is asked now and then, and the run ends after its current step.

use catena::simulation::{Observer, ObserverError, Sample, StepEnd};
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How often Python is asked.
const INTERVAL: Duration = Duration::from_millis(50);

/// Asks Python whether the user wants an end. It must be called on the main thread, because signals arrive only there.
pub struct Watcher {
    interrupt: Arc<AtomicBool>,
    asked: Instant,
}

impl Watcher {
    /// Sets this flag.
    pub fn new(interrupt: Arc<AtomicBool>) -> Self {
        Watcher { interrupt, asked: Instant::now() }
    }
}

impl Observer for Watcher {
    fn sample(&mut self, _: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn skips_samples(&self) -> bool {
        true
    }

    fn step(&mut self, _: &StepEnd) {
        if self.asked.elapsed() >= INTERVAL {
            self.asked = Instant::now();
            if Python::attach(|py| py.check_signals()).is_err() {
                self.interrupt.store(true, Ordering::Relaxed);
            }
        }
    }
}

/// Does work on another thread without the lock of Python, while this one asks; sets the flag on Ctrl-C.
pub fn watched<T: Send>(py: Python<'_>, interrupt: &AtomicBool, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| {
        std::thread::scope(|scope| {
            let (ended, wait) = channel::<()>();
            let worker = scope.spawn(move || {
                let done = work();
                // The other end waits for it.
                let _ = ended.send(());
                done
            });
            while let Err(RecvTimeoutError::Timeout) = wait.recv_timeout(INTERVAL) {
                if Python::attach(|py| py.check_signals()).is_err() {
                    interrupt.store(true, Ordering::Relaxed);
                    break;
                }
            }
            worker.join()
        })
    });
    match done {
        Ok(_) if interrupt.load(Ordering::Relaxed) => Err(pyo3::exceptions::PyKeyboardInterrupt::new_err(())),
        Ok(done) => Ok(done),
        Err(_) => Err(pyo3::exceptions::PyRuntimeError::new_err("a thread of the library has panicked")),
    }
}

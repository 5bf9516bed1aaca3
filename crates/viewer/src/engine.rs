//! The worker behind the window: a coarse picture at once, finer ones while nothing moves, at last the one that
//! `barnard render` would write.
//!
//! Orders replace each other: the newest counts. A first look is never given up for a newer order, so that pictures
//! keep coming while somebody drags; all that is finer is.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;

use barnard::backend::{Backend, BackendEntry};
use barnard::cache::Cache;
use barnard::control::Control;
use barnard_gpu::{Auto, Gpu, GpuError, OnDevice, Ordinates, Tuning};

use crate::progress::Progress;
use barnard_explorer::order::{Order, Refinement};
use barnard_explorer::picture::Picture;
use barnard_explorer::studio::{LentDevice, Studio};

/// An answer to an order.
pub struct RenderedFrame {
    /// The number of the order.
    pub number: u64,
    /// The quality that the pictures have reached.
    pub quality: Refinement,
    /// A picture for each view, or why there is none.
    pub pictures: Result<Vec<Picture>, String>,
}

#[derive(Default)]
struct EngineState {
    order: Option<(u64, Order)>,
    number: u64,
    closed: bool,
    /// Stops what may be given up.
    refining: Control,
}

#[derive(Default)]
struct EngineShared {
    state: Mutex<EngineState>,
    wake: Condvar,
    gpu: OnceLock<Gpu>,
    /// Progress of what may be given up.
    progress: Arc<Progress>,
    /// Stops a first look when the window closes.
    closing: Control,
}

impl EngineShared {
    fn state(&self) -> std::sync::MutexGuard<'_, EngineState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next order, with what stops its finer pictures, of whose progress it wakes the window; none once the engine is closed.
    fn next(&self, wake: &Arc<impl Fn() + Send + Sync + 'static>) -> Option<(u64, Order, Control)> {
        let mut state = self.state();
        loop {
            if state.closed {
                return None;
            }
            if let Some((number, order)) = state.order.take() {
                let wake = wake.clone();
                self.progress.reset();
                state.refining = self.progress.control(move || wake());
                return Some((number, order, state.refining.clone()));
            }
            state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// The worker and the way to it.
pub struct Engine {
    shared: Arc<EngineShared>,
    frames: Receiver<RenderedFrame>,
    thread: Option<JoinHandle<()>>,
}

impl Engine {
    /// Starts the worker with a back end and a cache between runs, if any. `wake` is called at every frame and every step of progress.
    pub fn start(backend: BackendEntry, cache: Option<Arc<dyn Cache>>, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let (sender, frames) = channel();
        let shared = Arc::<EngineShared>::default();
        let of_thread = shared.clone();
        let thread =
            std::thread::spawn(move || work(&|closing| Studio::new(backend, cache.clone(), closing), &of_thread, &sender, &Arc::new(wake)));
        Self { shared, frames, thread: Some(thread) }
    }

    /// Has the orders that follow rendered on `gpu`, as long as it does; the first one that is lent stays.
    pub fn lend(&self, gpu: Gpu) {
        // A second one is not needed.
        let _ = self.shared.gpu.set(gpu);
    }

    /// Asks for a picture; returns the order's number.
    pub fn submit(&self, order: Order) -> u64 {
        let mut state = self.shared.state();
        state.number += 1;
        let number = state.number;
        state.order = Some((number, order));
        state.refining.interrupt();
        self.shared.wake.notify_one();
        number
    }

    /// Stage of the picture that is being refined, and the finished share of it \[1\].
    pub fn progress(&self) -> Option<(&'static str, f32)> {
        self.shared.progress.now()
    }

    /// The frames that have come since.
    pub fn frames(&self) -> impl Iterator<Item = RenderedFrame> + '_ {
        self.frames.try_iter()
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        {
            let mut state = self.shared.state();
            state.closed = true;
            state.refining.interrupt();
        }
        self.shared.closing.interrupt();
        self.shared.wake.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the worker was reported already.
            let _ = thread.join();
        }
    }
}

/// The window's device as a studio uses it.
fn lent(gpu: Gpu) -> LentDevice {
    let sweeper = Ordinates::if_faster(&gpu);
    // The device is the window's, as a rule: without it there is none to open again.
    let gone = || Err(GpuError::NoAdapter);
    let backend = move || Box::new(Auto::on(OnDevice::new(gpu.clone(), Tuning::default()).reopened_by(gone))) as Box<dyn Backend>;
    LentDevice { backend: Box::new(backend), sweeper }
}

fn work(
    opened: &dyn Fn(Control) -> Studio,
    shared: &EngineShared,
    sender: &Sender<RenderedFrame>,
    wake: &Arc<impl Fn() + Send + Sync + 'static>,
) {
    let mut studio = opened(shared.closing.clone());
    while let Some((number, order, control)) = shared.next(wake) {
        if let Some(gpu) = shared.gpu.get().filter(|_| !studio.has_device()) {
            studio.take(lent(gpu.clone()));
        }
        let tell = |quality, pictures| {
            // Nobody listens any more once the window is gone.
            let _ = sender.send(RenderedFrame { number, quality, pictures });
            wake();
        };
        let serve = || studio.serve(&order, &control, &mut |quality, pictures| tell(quality, Ok(pictures)));
        match catch_unwind(AssertUnwindSafe(serve)) {
            Ok(Ok(()) | Err(barnard::Error::Interrupted)) => {}
            Ok(Err(error)) => tell(Refinement::Coarse, Err(error.to_string())),
            Err(_) => {
                tell(Refinement::Coarse, Err("internal error while rendering; the scene is unchanged".into()));
                studio = opened(shared.closing.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use barnard::backend::cpu;
    use barnard_explorer::document::Document;
    use barnard_explorer::edit::Edit;
    use barnard_explorer::flight::Flight;
    use barnard_explorer::order::View;

    use super::*;

    /// The last picture of a document by a studio.
    fn last(studio: &mut Studio, document: &Document) -> Picture {
        let camera = Flight::of(document.scene()).seen((48, 32));
        let views = vec![View::of(document)];
        let order = Order { views, camera, moving: false, settles: true, difference: false, exposure: 0, memory_limit: 1 << 32 };
        let mut shown = None;
        studio.serve(&order, &Control::default(), &mut |_, mut pictures| shown = pictures.pop()).unwrap();
        shown.unwrap()
    }

    /// A device of software or a real one, and how to take it away.
    fn device() -> (Gpu, eframe::wgpu::Device) {
        use eframe::wgpu;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let opened = pollster::block_on(async {
            let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await.ok()?;
            let (device, queue) = adapter.request_device(&barnard_gpu::device_descriptor(&adapter)).await.ok()?;
            Some((Gpu::shared(&adapter, device.clone(), queue)?, device))
        });
        opened.expect("this test needs a graphics adapter; software Vulkan (mesa-vulkan-drivers) is one")
    }

    /// The picture of a device is that of the processor to the accuracy that both are planned for. When a device is
    /// lost, the user is notified and the processor takes over.
    #[test]
    #[ignore = "needs a graphics adapter: --include-ignored"]
    fn devices_make_the_same_pictures() {
        let (gpu, device) = device();
        let mut document = Document::builtin("barres_neyret", 1 << 32).unwrap();
        let mut studio = Studio::new(cpu::ENTRY, None, Control::default());
        studio.take(lent(gpu));
        let (on_device, on_processor) =
            (last(&mut studio, &document), last(&mut Studio::new(cpu::ENTRY, None, Control::default()), &document));
        assert!(on_device.backend.starts_with("gpu: ") && on_processor.backend == "cpu", "{}", on_device.backend);
        for band in 0..3 {
            let difference = on_device.image.relative_rmse(band, &on_processor.image, band);
            assert!((1e-9..1e-3).contains(&difference), "band {band}: {difference}");
        }
        device.destroy();
        document.apply(Edit::set("star.0", "temperature", "4000 K")).unwrap();
        let after = last(&mut studio, &document);
        assert!(after.backend.starts_with("cpu, since "), "{}", after.backend);
        assert!(after.image.samples == last(&mut Studio::new(cpu::ENTRY, None, Control::default()), &document).image.samples);
    }
}

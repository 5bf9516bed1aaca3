//! Graphics device of the browser (WebGPU).

use std::cell::RefCell;

use barnard::backend::Backend;
use barnard_explorer::studio::LentDevice;
use barnard_gpu::{Auto, Gpu, GpuError, OnDevice, Tuning};
use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    /// Device of this worker, once it is open.
    static DEVICE: RefCell<Option<Gpu>> = const { RefCell::new(None) };
}

/// Opens the device for explorers of this worker; returns its name, or why pictures are rendered on the processor. Devices in software
/// are slower than the processor, and used `if_software` alone.
#[wasm_bindgen]
pub async fn open_device(if_software: bool) -> String {
    match Gpu::of_browser().await {
        Err(error) => error.to_string(),
        Ok(gpu) if !gpu.adapter.real && !if_software => format!("the only graphics adapter is software ({})", gpu.adapter.name),
        Ok(gpu) => {
            let name = gpu.name();
            DEVICE.set(Some(gpu));
            name
        }
    }
}

/// The device for a studio, if there is one.
pub fn lent() -> Option<LentDevice> {
    let gpu = DEVICE.with_borrow(Clone::clone)?;
    // A browser opens devices later, and not at once.
    let gone = || Err(GpuError::NoAdapter);
    let backend = move || Box::new(Auto::on(OnDevice::new(gpu.clone(), Tuning::default()).reopened_by(gone))) as Box<dyn Backend>;
    Some(LentDevice { backend: Box::new(backend), sweeper: None })
}

//! What becomes of the graphics device: without listeners, its loss would end the program.

use crate::render::Gpu;
use crate::worker::Wake;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What was told about a device. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Lost {
    told: Arc<Mutex<Told>>,
    device: Option<wgpu::Device>,
}

#[derive(Debug, Default)]
struct Told {
    is_lost: bool,
    message: Option<String>,
}

impl Lost {
    /// Listens to a device.
    pub fn of(gpu: &Gpu, wake: Wake) -> Self {
        let own = Self { told: Arc::default(), device: Some(gpu.device.clone()) };
        let (listener, waker) = (own.told.clone(), wake.clone());
        gpu.device.set_device_lost_callback(move |reason, message| {
            let message = if message.is_empty() { format!("{reason:?}") } else { message };
            tell(&listener, true, message);
            waker();
        });
        let listener = own.told.clone();
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            tell(&listener, false, error.to_string());
            wake();
        }));
        own
    }

    /// Whether the device is lost.
    pub fn is_lost(&self) -> bool {
        // It is told when somebody asks the device for anything.
        if let Some(device) = &self.device {
            let _ = device.poll(wgpu::PollType::Poll);
        }
        lock(&self.told).is_lost
    }

    /// What was told since the last call.
    pub fn told(&self) -> Option<String> {
        lock(&self.told).message.take()
    }
}

fn lock(told: &Mutex<Told>) -> MutexGuard<'_, Told> {
    told.lock().unwrap_or_else(PoisonError::into_inner)
}

fn tell(to: &Mutex<Told>, is_lost: bool, message: String) {
    let mut told = lock(to);
    // Once it is lost, what cannot be done with it says nothing new.
    if !told.is_lost {
        *told = Told { is_lost, message: Some(message) };
    }
}

//! What becomes of the graphics device: without listeners, its loss would end the program.

use crate::render::Gpu;
use crate::worker::Wake;
use std::sync::{Arc, Mutex, PoisonError};

/// What was told about a device. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Lost(Arc<Mutex<Told>>);

#[derive(Debug, Default)]
struct Told {
    is_lost: bool,
    message: Option<String>,
}

impl Lost {
    /// Listens to a device.
    pub fn of(gpu: &Gpu, wake: Wake) -> Self {
        let own = Self::default();
        let (listener, waker) = (own.clone(), wake.clone());
        gpu.device.set_device_lost_callback(move |reason, message| {
            let message = if message.is_empty() { format!("{reason:?}") } else { message };
            listener.tell(true, message);
            waker();
        });
        let listener = own.clone();
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            listener.tell(false, error.to_string());
            wake();
        }));
        own
    }

    fn tell(&self, is_lost: bool, message: String) {
        let mut told = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // Once it is lost, what cannot be done with it says nothing new.
        if !told.is_lost {
            *told = Told { is_lost, message: Some(message) };
        }
    }

    /// Whether the device is lost.
    pub fn is_lost(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_lost
    }

    /// What was told since the last call.
    pub fn told(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).message.take()
    }
}

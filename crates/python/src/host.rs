//! Threads and devices of this process. None of them survives a fork, so a child gets its own.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use raggio_render::{CpuOptions, Device, DeviceSelection, OpenOptions, Tracer, open_all};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::{DeviceError, device_error};

/// Threads that read and translate scenes, and devices that were opened.
#[derive(Default)]
struct Host {
    pool: Option<Arc<ThreadPool>>,
    devices: HashMap<(String, Tracer, usize), Arc<dyn Device>>,
}

static HOST: Mutex<Option<Host>> = Mutex::new(None);

/// Runs `work` where parallel iterators find threads that are alive: rayon's own pool dies in forked processes.
pub fn on_threads<T: Send>(work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    let pool = {
        let mut host = HOST.lock().unwrap_or_else(PoisonError::into_inner);
        let host = host.get_or_insert_default();
        match &host.pool {
            Some(pool) => pool.clone(),
            None => {
                let pool = ThreadPoolBuilder::new().build();
                let pool = pool.map_err(|error| DeviceError::new_err(format!("cannot start threads: {error}")))?;
                host.pool.insert(Arc::new(pool)).clone()
            }
        }
    };
    pool.install(work)
}

/// The device that `name` chooses, on which `tracer` finds what rays meet, opened once in each process; `warn` hears why `auto`
/// passes over a GPU.
pub fn device(name: &str, tracer: &str, threads: usize, warn: impl Fn(&str)) -> PyResult<Arc<dyn Device>> {
    let tracer: Tracer = tracer.parse().map_err(|error| PyValueError::new_err(format!("tracer: {error}")))?;
    let choice: DeviceSelection = name.parse().map_err(|error| DeviceError::new_err(format!("device: {error}")))?;
    let key = (choice.to_string(), tracer, threads);
    let known = |host: &Option<Host>| host.as_ref().and_then(|host| host.devices.get(&key).cloned());
    let lock = || HOST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(device) = known(&lock()) {
        return Ok(device);
    }
    let cpu = CpuOptions { threads, ..CpuOptions::default() };
    let options = OpenOptions { cpu, tracer, cache: raggio_render::cache_folder(), ..OpenOptions::default() };
    let device: Arc<dyn Device> = open_all(&choice, &options, warn).map_err(device_error)?.into();
    lock().get_or_insert_default().devices.insert(key, device.clone());
    Ok(device)
}

/// Leaves to the parent what a forked child cannot use: its threads are gone, and so are connections to drivers.
pub fn forget() {
    // A thread of the parent may have held the lock when it was forked, and nobody will give it back.
    if let Ok(mut host) = HOST.try_lock() {
        std::mem::forget(host.take());
    }
}

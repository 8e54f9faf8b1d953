//! A device that is opened while scenes are read: drivers take about as long for the one as files do for the other.

use std::thread::JoinHandle;
use std::time::Instant;

use raggio_render::{Device, DeviceChoice, DeviceError, DeviceSelection, open_all};

use crate::args::MachineArguments;

/// Device that is being opened, or is about to be.
pub struct Opening<'a> {
    machine: &'a MachineArguments,
    thread: Option<JoinHandle<Opened>>,
}

/// Device that was opened, or the reason why it was not.
struct Opened {
    device: Result<Box<dyn Device>, DeviceError>,
    warnings: Vec<String>,
    seconds: f64,
}

impl<'a> Opening<'a> {
    /// Begins to open the device that is asked for, unless that takes no time.
    pub fn begin(machine: &'a MachineArguments) -> Self {
        let (selection, options) = (machine.device.clone(), machine.options());
        let takes_time = selection != DeviceSelection::from(DeviceChoice::Cpu);
        let open = move || Opened::new(&selection, &options);
        let thread = takes_time.then(|| std::thread::Builder::new().name("device".into()).spawn(open).ok()).flatten();
        Self { machine, thread }
    }

    /// Leaves the device to be opened when it is asked for.
    pub fn later(machine: &'a MachineArguments) -> Self {
        Self { machine, thread: None }
    }

    /// The device, and the seconds that it took to open it; `warn` hears why a GPU is passed over.
    ///
    /// # Errors
    /// The errors of [`open_all`].
    pub fn finish(mut self, warn: impl Fn(&str)) -> Result<(Box<dyn Device>, f64), DeviceError> {
        let opened = match self.thread.take() {
            Some(thread) => thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)),
            None => Opened::new(&self.machine.device, &self.machine.options()),
        };
        opened.warnings.iter().for_each(|warning| warn(warning));
        Ok((opened.device?, opened.seconds))
    }
}

impl Drop for Opening<'_> {
    fn drop(&mut self) {
        // No driver bears it that the program ends under it.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

impl Opened {
    fn new(selection: &DeviceSelection, options: &raggio_render::OpenOptions) -> Self {
        let start = Instant::now();
        let warnings = std::cell::RefCell::new(vec![]);
        let device = open_all(selection, options, |warning| warnings.borrow_mut().push(warning.to_owned()));
        Self { device, warnings: warnings.into_inner(), seconds: start.elapsed().as_secs_f64() }
    }
}

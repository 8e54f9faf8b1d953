//! A device that takes its time.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use raggio_render::{
    Answer, Blocks, CpuDevice, CpuOptions, Device, DeviceError, DeviceScene, Display, Feature, Film, FilmPixel, Image,
    Pixels, Probe, Question, Session,
};

/// Numbers of samples of all calls so far, those of all pixels together.
pub type Taken = Arc<Mutex<Vec<u64>>>;

/// The CPU at a speed that is the same on every machine that is faster.
pub struct SlowDevice {
    cpu: CpuDevice,
    samples_per_second: f64,
    taken: Taken,
}

struct SlowSession {
    cpu: Box<dyn Session>,
    width: u32,
    samples_per_second: f64,
    taken: Taken,
}

impl SlowDevice {
    pub fn new(samples_per_second: f64) -> (Self, Taken) {
        let taken = Taken::default();
        let cpu = CpuDevice::new(CpuOptions::default()).expect("the CPU");
        (Self { cpu, samples_per_second, taken: taken.clone() }, taken)
    }
}

impl Device for SlowDevice {
    fn name(&self) -> String {
        "slow".into()
    }

    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        let cpu = self.cpu.load(scene)?;
        let (width, samples_per_second, taken) = (scene.work.width, self.samples_per_second, self.taken.clone());
        Ok(Box::new(SlowSession { cpu, width, samples_per_second, taken }))
    }
}

impl Session for SlowSession {
    fn show(&mut self, feature: Feature) -> Result<(), DeviceError> {
        self.cpu.show(feature)
    }

    fn add_samples_until(
        &mut self,
        rows: Range<u32>,
        samples: Range<u32>,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, DeviceError> {
        let start = Instant::now();
        let mut done = 0;
        // Row by row, so that it can be stopped where its own time says so.
        for row in rows {
            self.cpu.add_samples(row..row + 1, samples.clone())?;
            done += 1;
            let taken = u64::from(done) * u64::from(self.width) * samples.len() as u64;
            let due = start + Duration::from_secs_f64(taken as f64 / self.samples_per_second);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            if stop() {
                break;
            }
        }
        let taken = u64::from(done) * u64::from(self.width) * samples.len() as u64;
        self.taken.lock().expect("no panic").push(taken);
        Ok(done)
    }

    fn set_film(&mut self, film: &Film) -> Result<(), DeviceError> {
        self.cpu.set_film(film)
    }

    fn rest(&mut self, blocks: Option<&Blocks>) -> Result<(), DeviceError> {
        self.cpu.rest(blocks)
    }

    fn restart(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        self.width = scene.work.width;
        self.cpu.restart(scene)
    }

    fn set_reference(&mut self, reference: Option<&Image>) -> Result<(), DeviceError> {
        self.cpu.set_reference(reference)
    }

    fn display(&mut self, display: Display) -> Result<Pixels, DeviceError> {
        self.cpu.display(display)
    }

    fn pixels(&self, columns: Range<u32>, y: u32) -> Result<Vec<FilmPixel>, DeviceError> {
        self.cpu.pixels(columns, y)
    }

    fn film(&self) -> Result<Film, DeviceError> {
        self.cpu.film()
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        self.cpu.ask(probe, questions)
    }

    fn patience_seconds(&self) -> f64 {
        self.cpu.patience_seconds()
    }
}

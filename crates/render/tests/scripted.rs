//! A session that renders nothing and does what a test says.

use std::ops::Range;

use raggio_render::{
    Answer, Blocks, DeviceError, DeviceScene, Display, Feature, Film, FilmPixel, Image, Pixels, Probe, Question,
    Session,
};

/// Parts of a session that a test has a say in.
pub trait Script: Send {
    fn show(&mut self, _feature: Feature) {}

    fn prepare(&mut self) -> Result<(), DeviceError> {
        Ok(())
    }

    fn is_prepared(&self) -> bool {
        true
    }

    fn add_samples(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError>;

    /// Error of reading the film, if there is one.
    fn film(&self) -> Result<(), DeviceError> {
        Ok(())
    }
}

/// A session whose film is always empty.
pub struct Scripted<S> {
    pub size: [u32; 2],
    /// Seconds.
    pub patience: f64,
    pub script: S,
}

impl<S: Script> Session for Scripted<S> {
    fn show(&mut self, feature: Feature) -> Result<(), DeviceError> {
        self.script.show(feature);
        Ok(())
    }

    fn add_samples_until(
        &mut self,
        rows: Range<u32>,
        samples: Range<u32>,
        _: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, DeviceError> {
        let count = rows.len() as u32;
        self.script.add_samples(rows, samples).map(|()| count)
    }

    fn prepare(&mut self) -> Result<(), DeviceError> {
        self.script.prepare()
    }

    fn is_prepared(&self) -> bool {
        self.script.is_prepared()
    }

    fn set_film(&mut self, _: &Film) -> Result<(), DeviceError> {
        Ok(())
    }

    fn rest(&mut self, _: Option<&Blocks>) -> Result<(), DeviceError> {
        Ok(())
    }

    fn restart(&mut self, _: &DeviceScene) -> Result<(), DeviceError> {
        Ok(())
    }

    fn set_reference(&mut self, _: Option<&Image>) -> Result<(), DeviceError> {
        Ok(())
    }

    fn display(&mut self, _: Display) -> Result<Pixels, DeviceError> {
        Ok(Pixels::Host(vec![]))
    }

    fn pixels(&self, _: Range<u32>, _: u32) -> Result<Vec<FilmPixel>, DeviceError> {
        Ok(vec![])
    }

    fn film(&self) -> Result<Film, DeviceError> {
        let [width, height] = self.size;
        self.script.film().map(|()| Film::new(width, height))
    }

    fn ask(&mut self, _: Probe, _: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        Ok(vec![])
    }

    fn patience_seconds(&self) -> f64 {
        self.patience
    }
}

//! The picture, on the screen and in files.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use raggio_render::{Comparison, ImageFile, Metadata, Pixels, View};
use raggio_scene::counted;

use super::{Reading, Viewer};
use crate::clock::Pace;
use crate::command::ExportRequest;
use crate::denoising::{Denoised, Denoising};
use crate::error::ViewError;
use crate::export::{self, Export};
use crate::look::Look;
use crate::tracer::Tracer;

/// Time without input after which nobody waits for an answer.
const UNTOUCHED: Duration = Duration::from_millis(300);

impl Viewer {
    pub(super) fn show(&mut self, look: Look) -> Result<(), ViewError> {
        self.settings.look = look;
        self.tracer.set_view(look.view)
    }

    /// Adds samples for as long as the frame has time: to the film until there is a whole picture, then to an export if
    /// there is one.
    pub(crate) fn sample(&mut self) -> Result<(), ViewError> {
        let pace = match () {
            () if self.tracer.is_coarse() => Pace::Fluent,
            () if self.tracer.is_moving() && self.denoises_in_motion() => Pace::Whole,
            () if self.untouched.elapsed() > UNTOUCHED && self.tracer.settled() => Pace::Alone,
            () => Pace::Display,
        };
        let budget = self.clock.budget(pace);
        let start = Instant::now();
        let whole = self.tracer.is_whole();
        let outcome = match self.export.take() {
            Some(export) if whole => self.advance_export(export, budget),
            export => {
                self.export = export;
                self.trace(whole, budget, self.clock.patience(pace, budget))
            }
        };
        self.clock.sampled(start.elapsed().as_secs_f64(), budget);
        self.notices.ongoing(self.tracer.awaits_kernels().then_some("compiling kernels"));
        outcome
    }

    /// Spends the `budget`, in seconds, on the denoiser's guides before more samples, also where no more are taken.
    fn trace(&mut self, whole: bool, budget: f64, patience: f64) -> Result<(), ViewError> {
        if whole {
            let prepared = self.denoise(|denoising, tracer| denoising.prepare(tracer, budget))?;
            if prepared == Some(true) || self.settings.paused {
                return Ok(());
            }
        }
        self.tracer.trace(budget, patience)
    }

    /// Does something for the denoiser, if there is one; denoising ends where that fails.
    fn denoise<T>(
        &mut self,
        what: impl FnOnce(&mut Denoising, &mut Tracer) -> Result<T, ViewError>,
    ) -> Result<Option<T>, ViewError> {
        let Some(denoising) = &mut self.denoising else { return Ok(None) };
        let outcome = what(denoising, &mut self.tracer).map(Some);
        outcome.inspect_err(|_| {
            self.denoising = None;
            self.tracer.show_again();
        })
    }

    /// Spends the `budget`, in seconds, on an export; one that fails is over.
    fn advance_export(&mut self, mut export: Export, budget: f64) -> Result<(), ViewError> {
        if export.advance(budget)? {
            self.notices.done(format!("wrote {}", export.path().display()));
        } else {
            self.export = Some(export);
        }
        Ok(())
    }

    /// Pixels and size of the picture, if it has changed.
    pub(crate) fn picture(&mut self) -> Result<Option<(Pixels, [u32; 2])>, ViewError> {
        match self.denoised()? {
            Some(Denoised::Changed(pixels, size)) => Ok(Some((pixels, size))),
            Some(Denoised::Unchanged) => Ok(None),
            None => self.tracer.display(self.settings.look),
        }
    }

    /// The picture without its noise, if it is wanted and there is one. Comparisons are with the picture as computed.
    fn denoised(&mut self) -> Result<Option<Denoised>, ViewError> {
        self.denoise(|denoising, tracer| denoising.follow(tracer))?;
        let (look, in_motion) = (self.settings.look, self.settings.denoise_in_motion);
        let shown = look.view == View::Radiance && (self.reference.is_none() || look.comparison == Comparison::Off);
        let found = self.denoise(|denoising, tracer| {
            if shown {
                return denoising.picture(tracer, look.of_files(), in_motion);
            }
            denoising.forget_shown();
            Ok(None)
        })?;
        if let Some(complaint) = self.denoising.as_mut().and_then(Denoising::complaint) {
            self.notices.warn(complaint);
        }
        Ok(found.flatten())
    }

    /// Begins to denoise, or ends it.
    pub(super) fn set_denoising(&mut self, on: bool) -> Result<(), ViewError> {
        let gpu = || raggio_render::gpu_of(self.tracer.device());
        self.denoising = if on { Some(Denoising::begin(gpu(), self.wake.clone())?) } else { None };
        self.tracer.show_again();
        Ok(())
    }

    /// Whether the frame under way has to be denoised, and so to be of full size.
    fn denoises_in_motion(&self) -> bool {
        let wanted = self.settings.denoise_in_motion;
        self.denoising.as_ref().is_some_and(|denoising| denoising.is_in_motion(wanted))
    }

    /// Reads the pixel and the surface under a point of the picture (0 to 1 from the top left), and a row of the film
    /// for the statistics, as long as there is a panel to show them.
    pub(crate) fn read(&mut self, cursor: Option<[f32; 2]>) -> Result<(), ViewError> {
        self.reading = None;
        if !self.shows_panels() {
            return Ok(());
        }
        self.tracer.count_rays()?;
        if let Some([x, y]) = cursor.filter(|_| self.tracer.settled()) {
            let pixel = self.tracer.film_pixel(x, y);
            let film = self.tracer.pixel(pixel)?;
            self.reading = Some(Reading { pixel, film, pick: self.tracer.pick(x, y)? });
        }
        Ok(())
    }

    /// Writes the film as it is, or begins to render another picture for the file.
    pub(super) fn begin_export(&mut self, request: &ExportRequest) -> Result<(), ViewError> {
        if let Some(export) = &self.export {
            let busy = export.path().display();
            self.notices.fail(format!("{busy} is being rendered: {} has to wait", request.path.display()));
            return Ok(());
        }
        let file = ImageFile::new(&request.path)?.with_refuge(Path::new("."));
        file.check_apart(self.document.files())?;
        let display = self.settings.look.of_files();
        let size = request.size.unwrap_or(self.tracer.full_size());
        let (film, has) = self.tracer.radiance()?;
        let samples = request.samples.unwrap_or(has).max(1);
        let name = self.document.source().file_name().unwrap_or_default().to_string_lossy();
        // A film says what it is of, which the window's does not know; and the window shows the background.
        let alpha = self.document.scene().render.alpha;
        if samples == has && !alpha && !file.is_film() && size == [film.width(), film.height()] {
            export::write(&file, &film, display, Metadata::new(self.tracer.scene(), &name))?;
            let samples = counted(samples as usize, "sample");
            self.notices.done(format!("wrote {}, {samples} per pixel", file.path().display()));
        } else {
            self.export = Some(Export::begin(file, &self.tracer, &name, size, samples, alpha, display)?);
        }
        Ok(())
    }

    /// Path in the current folder, named after the scene, with the first free number.
    pub(super) fn screenshot_name(&self) -> PathBuf {
        let stem = self.document.path().file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = |number| PathBuf::from(format!("{stem}-window-{number}.png"));
        (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0))
    }
}

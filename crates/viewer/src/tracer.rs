//! The picture that converges: a renderer that keeps to the display's frames.

use std::time::{Duration, Instant};

use raggio_render::{
    Care, Denoised, Denoiser, Device, DeviceError, DeviceScene, Display, Feature, Features, Film, FilmPixel, Image,
    Pixels, Probe, Progress, Renderer, View,
};
use raggio_scene::{Camera, Scene, Vec3};

use crate::error::ViewError;
use crate::look::Look;

/// Time after the last motion for which the camera counts as moving.
const REST: Duration = Duration::from_millis(120);
/// Greatest factor by which the film is smaller than the picture, in each direction.
const COARSEST: u32 = 32;
/// Most rays along one path where even the coarsest film takes longer than a frame.
const SHORT_PATH: u32 = 3;
/// Part of a frame's time in which a finer film has to be done for its sake to change the resolution.
const SPARE: f64 = 0.85;
/// Seconds that a frame may take to show another view: its first surfaces are quick to find, and the film of radiance
/// is worth more than a coarser film for the view would be.
const GLANCE: f64 = 1.0;
/// Longest time without a frame while kernels are compiled.
const MOMENT: Duration = Duration::from_millis(30);
/// Most samples that a pixel takes, as in scene files.
pub const MOST_SAMPLES: u32 = i32::MAX as u32;

/// A scene on a device, traced at the resolution that the moment allows.
pub struct Tracer {
    device: Box<dyn Device>,
    scene: Scene,
    device_scene: DeviceScene,
    renderer: Renderer,
    /// Size of the picture at rest, in pixels.
    full: [u32; 2],
    /// Factor by which the film is smaller in each direction, so that a frame's time is enough while the camera moves.
    divisor: u32,
    /// Whether paths end after [`SHORT_PATH`] rays.
    shortened: bool,
    moved: Option<Instant>,
    /// Samples per pixel at which to stop.
    limit: Option<u32>,
    /// Whether the film is new, and its resolution not yet chosen.
    begun: bool,
    /// Whether another view has been asked for of which there is nothing to see yet.
    awaited: bool,
    /// Whether the film has changed since it was last displayed.
    fresh: bool,
    shown: Option<Display>,
    samples_per_pass: Option<u32>,
    /// Whether frames go on while a driver compiles kernels; scripts rather wait.
    is_patient: bool,
    /// Whether the last frame went without samples, for there are no kernels yet.
    awaits_kernels: bool,
    reference: Option<Image>,
    /// Size of the film that the device has the reference for, in pixels.
    reference_size: [u32; 2],
    rays: Rays,
    generation: u32,
}

/// Rays per sample, from one row of the film a frame: reading all of it would take longer than tracing it.
#[derive(Default)]
struct Rays {
    rays: f64,
    samples: f64,
    turn: u32,
}

/// The surface under a point of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Position where the camera's ray meets the surface.
    pub position: Vec3,
    /// Unit normal, away from the inside of closed shapes.
    pub normal: Vec3,
    /// Distance from the camera.
    pub distance: f32,
    /// Place of the shape's `[[shapes]]` in the file.
    pub shape: usize,
    /// Index of the material in the scene's list.
    pub material: usize,
}

/// A scene as devices read it, for which none of them is needed.
pub struct Translated {
    scene: Scene,
    device_scene: DeviceScene,
}

impl Translated {
    /// Translates `scene` for a picture of `full` pixels.
    pub fn new(scene: &Scene, full: [u32; 2]) -> Result<Self, ViewError> {
        // The background is left out of files alone.
        let mut scene = scene.clone();
        scene.render.alpha = false;
        [scene.render.width, scene.render.height] = full;
        let device_scene = DeviceScene::new(&scene)?;
        Ok(Self { scene, device_scene })
    }
}

impl Tracer {
    /// Loads `scene` for a picture of `full` pixels.
    pub fn new(device: Box<dyn Device>, scene: &Scene, full: [u32; 2]) -> Result<Self, ViewError> {
        Self::with_translated(device, Translated::new(scene, full)?)
    }

    /// Loads what has been translated.
    pub fn with_translated(device: Box<dyn Device>, translated: Translated) -> Result<Self, ViewError> {
        let Translated { scene, device_scene } = translated;
        let full = [scene.render.width, scene.render.height];
        device.compile_ahead(&device_scene, &[Feature::Radiance]);
        let mut session = device.load(&device_scene)?;
        session.accept_general();
        let renderer = Renderer::new(session, &device_scene, 0..MOST_SAMPLES);
        let tracer = Self {
            device,
            scene,
            device_scene,
            renderer,
            full,
            divisor: 1,
            shortened: false,
            moved: None,
            limit: None,
            begun: true,
            awaited: false,
            fresh: false,
            shown: None,
            samples_per_pass: None,
            is_patient: true,
            awaits_kernels: false,
            reference: None,
            reference_size: [0, 0],
            rays: Rays::default(),
            generation: 1,
        };
        Ok(tracer)
    }

    /// Device that the scene is traced on.
    pub fn device(&self) -> &dyn Device {
        &*self.device
    }

    /// Traces on `device` from now on.
    pub fn set_device(&mut self, device: Box<dyn Device>) -> Result<(), ViewError> {
        device.compile_ahead(&self.device_scene, &[Feature::Radiance]);
        let mut session = device.load(&self.device_scene)?;
        session.accept_general();
        let feature = self.renderer.feature();
        self.renderer = Renderer::new(session, &self.device_scene, 0..self.target());
        self.renderer.show(feature)?;
        self.renderer.set_samples_per_pass(self.samples_per_pass);
        self.device = device;
        self.reference_size = [0, 0];
        self.shown = None;
        self.begin()
    }

    /// Shows the film that `view` looks at.
    pub fn set_view(&mut self, view: View) -> Result<(), ViewError> {
        self.renderer.show(view.feature())?;
        self.awaited = self.renderer.progress().samples == 0;
        Ok(())
    }

    /// Compares with this picture, or with none.
    pub fn set_reference(&mut self, reference: Option<Image>) -> Result<(), ViewError> {
        self.reference = reference;
        self.shown = None;
        self.reference_size = self.film_size();
        Ok(self.renderer.session().set_reference(self.reference.as_ref())?)
    }

    /// Changes to another scene, seen from `camera`. An error leaves the old one in place.
    pub fn set_scene(&mut self, scene: &Scene, camera: &Camera) -> Result<(), ViewError> {
        let mut scene = Scene { camera: camera.clone(), ..scene.clone() };
        scene.render.alpha = false;
        [scene.render.width, scene.render.height] = self.film_size();
        let mut device_scene = self.device_scene.clone();
        device_scene.update(&scene)?;
        self.renderer.restart(&device_scene)?;
        (self.scene, self.device_scene) = (scene, device_scene);
        self.shortened = false;
        self.begin()
    }

    /// Changes to another camera; `moving`: more are to be expected, so responsiveness comes before sharpness.
    pub fn set_camera(&mut self, camera: &Camera, moving: bool) -> Result<(), ViewError> {
        let before = std::mem::replace(&mut self.scene.camera, camera.clone());
        self.restart().inspect_err(|_| self.scene.camera = before)?;
        if moving {
            self.moved = Some(Instant::now());
        }
        Ok(())
    }

    /// Changes the size of the picture, in pixels.
    pub fn set_size(&mut self, full: [u32; 2]) -> Result<(), ViewError> {
        if full == self.full {
            return Ok(());
        }
        raggio_render::check_memory(full[0], full[1])?;
        let before = std::mem::replace(&mut self.full, full);
        self.restart().inspect_err(|_| self.full = before)
    }

    /// Begins the average anew.
    pub fn restart(&mut self) -> Result<(), ViewError> {
        [self.scene.render.width, self.scene.render.height] = self.film_size();
        let max_depth = self.scene.render.max_depth;
        self.scene.render.max_depth = self.film_depth();
        let viewed = self.device_scene.set_view(&self.scene);
        self.scene.render.max_depth = max_depth;
        viewed?;
        self.renderer.restart(&self.device_scene)?;
        self.begin()
    }

    /// Begins a new film: resets all that belongs to the last one.
    fn begin(&mut self) -> Result<(), ViewError> {
        self.begun = true;
        self.awaited = false;
        self.fresh = false;
        self.generation = self.generation.wrapping_add(1);
        self.rays = Rays::default();
        // The device keeps the reference as long as the size stays.
        if self.reference.is_some() && self.reference_size != self.film_size() {
            self.reference_size = self.film_size();
            self.renderer.session().set_reference(self.reference.as_ref())?;
        }
        Ok(())
    }

    /// Stops at so many samples per pixel; `None` goes on.
    pub fn set_limit(&mut self, limit: Option<u32>) {
        self.limit = limit;
        self.renderer.set_target(self.target());
    }

    /// Sets the samples that a pass adds to each pixel; `None`: as many as a frame has time for.
    pub fn set_samples_per_frame(&mut self, samples: Option<u32>) {
        self.samples_per_pass = samples;
        self.renderer.set_samples_per_pass(samples);
    }

    /// Makes frames wait for kernels that a driver compiles, so that each of them has samples.
    pub fn set_impatient(&mut self) {
        self.is_patient = false;
    }

    /// Whether there are no samples because a driver compiles kernels.
    pub fn awaits_kernels(&self) -> bool {
        self.awaits_kernels
    }

    /// Spends about `seconds` on samples. A film that is new gets a whole sample, whatever time that takes: each change
    /// is to be seen before the next one. Frames go on without samples while a driver compiles kernels.
    /// Films are of as fine a resolution as `patience`, in seconds and no less, allows for their first sample.
    pub fn trace(&mut self, seconds: f64, patience: f64) -> Result<(), ViewError> {
        let start = Instant::now();
        let session = self.renderer.session();
        self.awaits_kernels = self.is_patient && !session.is_prepared();
        if self.awaits_kernels {
            session.prepare_ahead()?;
            std::thread::sleep(Duration::from_secs_f64(seconds).min(MOMENT));
            return Ok(());
        }
        if self.settle(patience)? {
            self.add_one_sample(|tracer| tracer.catch_up(patience))?;
        } else if self.awaited {
            self.add_one_sample(|tracer| tracer.glance(seconds.max(GLANCE)))?;
            self.awaited = self.renderer.progress().samples == 0;
        }
        let left = seconds - start.elapsed().as_secs_f64();
        if !self.renderer.finished() && left > 0.0 {
            self.renderer.run_for(left)?;
            self.fresh = true;
        }
        Ok(())
    }

    /// Finds the resolution for this frame: as fine as the frame's time allows after every change, then finer step by
    /// step when the camera rests, so that there is never long nothing new to see. Returns whether there was a change.
    fn settle(&mut self, seconds: f64) -> Result<bool, ViewError> {
        let changed = std::mem::take(&mut self.begun);
        if changed {
            let needed = self.needed_divisor(seconds);
            // A little too coarse stays, unless there is time to spare: changing the resolution back and forth would
            // flicker. So would the light that long paths bring, which may take four times as long.
            let is_spare = self.needed_divisor(SPARE * seconds) <= needed;
            let stays = needed.saturating_add(1) == self.divisor && !is_spare;
            let divisor = if stays { self.divisor } else { needed };
            let bearable = if self.shortened { COARSEST / 2 } else { COARSEST };
            self.change_quality(divisor, needed > bearable)?;
        } else if !self.is_moving() && self.renderer.progress().samples > 0 {
            self.change_quality(self.needed_divisor(seconds).min(self.divisor / 2), false)?;
        }
        Ok(changed)
    }

    /// Smallest divisor with which the device, as fast as it was lately, finishes a sample of every pixel in `seconds`.
    fn needed_divisor(&self, seconds: f64) -> u32 {
        let pixels = f64::from(self.full[0]) * f64::from(self.full[1]);
        (pixels / (self.renderer.rate() * seconds)).sqrt().ceil() as u32
    }

    /// Begins a film of another resolution or length of paths, if these are others.
    fn change_quality(&mut self, divisor: u32, shortened: bool) -> Result<(), ViewError> {
        let divisor = divisor.clamp(1, COARSEST);
        if (divisor, shortened) != (self.divisor, self.shortened) {
            (self.divisor, self.shortened) = (divisor, shortened);
            self.restart()?;
            self.begun = false;
        }
        Ok(())
    }

    /// Lets `trace` add samples in passes of one sample a pixel.
    fn add_one_sample(&mut self, trace: impl FnOnce(&mut Self) -> Result<(), ViewError>) -> Result<(), ViewError> {
        self.renderer.set_samples_per_pass(Some(1));
        let outcome = trace(self);
        self.renderer.set_samples_per_pass(self.samples_per_pass);
        self.fresh = true;
        outcome
    }

    fn glance(&mut self, seconds: f64) -> Result<(), ViewError> {
        self.renderer.run_for(seconds)?;
        Ok(())
    }

    /// Gives every pixel of a new film a sample, on a coarser film where this one would take much more than `seconds`.
    fn catch_up(&mut self, seconds: f64) -> Result<(), ViewError> {
        loop {
            self.renderer.run_for(seconds)?;
            if self.renderer.progress().samples > 0 || self.renderer.finished() {
                return Ok(());
            }
            // What was measured meanwhile tells of this view. A film that is nearly fitting is finished: to begin anew
            // would take as long.
            let needed = self.needed_divisor(seconds);
            if needed <= 2 * self.divisor || (self.divisor == COARSEST && self.shortened) {
                return Ok(self.renderer.finish_pass()?);
            }
            self.change_quality(needed, self.shortened || needed > COARSEST)?;
        }
    }

    /// Pixels and size of the picture, if there is a whole one and it has changed since it was last asked for.
    pub fn display(&mut self, look: Look) -> Result<Option<(Pixels, [u32; 2])>, ViewError> {
        let display = look.display(self.film_size()[0], self.scale(look.view));
        let changed = self.fresh || self.shown != Some(display);
        if !changed || self.renderer.progress().samples == 0 {
            return Ok(None);
        }
        let pixels = self.renderer.session().display(display)?;
        self.fresh = false;
        self.shown = Some(display);
        Ok(Some((pixels, self.film_size())))
    }

    /// The picture without its noise, where `denoiser` works on the tracer's device.
    pub fn denoise(&mut self, denoiser: &Denoiser, care: Care, display: Display) -> Result<Denoised, ViewError> {
        Ok(self.renderer.session().denoise(denoiser, care, display)?)
    }

    /// Makes [`Tracer::display`] return the picture once more, even if it has not changed.
    pub fn show_again(&mut self) {
        self.shown = None;
    }

    /// Finds the surface under a point of the picture; `x` and `y` are 0 to 1 from the top left.
    pub fn pick(&mut self, x: f32, y: f32) -> Result<Option<Pick>, ViewError> {
        let [width, height] = self.film_size().map(|side| side as f32);
        // The ray goes through the middle of the lens.
        let camera = [[x * width, y * height, width, height], [0.0; 4], [0.0; 4]];
        let session = self.renderer.session();
        let ray = answer(session.ask(Probe::Camera, &[camera]))?;
        let trace = [ray[0], ray[1], [0.0; 4]];
        let [found, position, normal] = answer(session.ask(Probe::Trace, &[trace]))?;
        let place = found[1];
        if place < 0.0 {
            return Ok(None);
        }
        let shape = self.scene.shapes[self.device_scene.shape_of_place[place as usize] as usize].entry;
        let vector = |v: [f32; 4]| Vec3::new(v[0], v[1], v[2]);
        let material = found[2] as usize;
        Ok(Some(Pick { position: vector(position), normal: vector(normal), distance: found[0], shape, material }))
    }

    /// The pixel of the film at a point of the picture; `x` and `y` are 0 to 1 from the top left.
    pub fn film_pixel(&self, x: f32, y: f32) -> [u32; 2] {
        let [width, height] = self.film_size();
        let place = |at: f32, side: u32| ((at * side as f32) as u32).min(side - 1);
        [place(x, width), place(y, height)]
    }

    /// Value at which the colours of a view end.
    pub fn scale(&self, view: View) -> f32 {
        match view {
            View::Depth => self.scene.camera.focus_distance,
            // Without a limit, most paths end by themselves before that.
            View::Bounces if self.scene.render.max_depth == 0 => 64.0,
            View::Bounces => self.scene.render.max_depth as f32,
            View::Samples => self.renderer.progress().samples.max(1) as f32,
            _ => 1.0,
        }
    }

    /// Reads another row of the film, for [`Tracer::rays_per_sample`].
    pub fn count_rays(&mut self) -> Result<(), ViewError> {
        let [width, height] = self.film_size();
        if self.renderer.progress().samples == 0 {
            return Ok(());
        }
        // The golden ratio spreads the rows evenly, however many there will be.
        let row = (f64::from(self.rays.turn) * 0.618_033_988_75).fract() * f64::from(height);
        let pixels = self.renderer.session().pixels(0..width, row as u32)?;
        self.rays.turn += 1;
        let each = |pixel: &FilmPixel| f64::from(pixel.rays) / f64::from(pixel.samples + pixel.rejected).max(1.0);
        self.rays.rays += pixels.iter().map(each).sum::<f64>();
        self.rays.samples += f64::from(width);
        Ok(())
    }

    /// Rays per sample, as far as rows have been read; 0 before the first.
    pub fn rays_per_sample(&self) -> f64 {
        self.rays.rays / self.rays.samples.max(1.0)
    }

    /// The film of radiance when the pass under way is finished, and the number of samples that each of its pixels has
    /// then; whatever film is shown.
    pub fn radiance(&mut self) -> Result<(Film, u32), ViewError> {
        let shown = self.renderer.feature();
        self.renderer.show(Feature::Radiance)?;
        self.renderer.finish_pass()?;
        let film = self.renderer.film()?;
        let samples = self.renderer.progress().samples;
        self.renderer.show(shown)?;
        self.fresh = true;
        Ok((film, samples))
    }

    /// Spends about `seconds`, one portion at least, on what `features` lack of `wanted`; true when they have it all.
    pub fn gather(
        &mut self,
        features: &mut Features,
        wanted: &[Feature],
        samples: u32,
        seconds: f64,
    ) -> Result<bool, ViewError> {
        let start = Instant::now();
        let mut left = seconds;
        while !features.advance(&mut self.renderer, wanted, samples, left)? {
            left = seconds - start.elapsed().as_secs_f64();
            if left <= 0.0 {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// A pixel of the film that is shown.
    pub fn pixel(&mut self, [x, y]: [u32; 2]) -> Result<FilmPixel, ViewError> {
        Ok(self.renderer.session().pixel(x, y)?)
    }

    /// Whether the film of radiance is shown, in one view or another.
    pub fn shows_radiance(&self) -> bool {
        self.renderer.feature() == Feature::Radiance
    }

    /// Number of the film, another one for each new film.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Progress of the film.
    pub fn progress(&self) -> Progress {
        self.renderer.progress()
    }

    /// Samples of each pixel of the picture, counted at its full size.
    pub fn samples_of_full_size(&self) -> f64 {
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        f64::from(self.progress().samples) * pixels(self.film_size()) / pixels(self.full)
    }

    /// Whether nothing is left to do.
    pub fn finished(&self) -> bool {
        self.renderer.finished() && self.divisor == 1
    }

    /// Whether there is a picture at full resolution.
    pub fn is_whole(&self) -> bool {
        self.settled() && self.progress().samples > 0
    }

    /// Whether only a small part of the picture's pixels can be traced in a frame.
    pub fn is_coarse(&self) -> bool {
        self.divisor > 2
    }

    /// Whether the film has full resolution, and the camera is at rest.
    pub fn settled(&self) -> bool {
        self.divisor == 1 && !self.is_moving()
    }

    /// Whether the film has full resolution.
    pub fn has_full_size(&self) -> bool {
        self.divisor == 1
    }

    /// Whether the camera has moved a moment ago.
    pub fn is_moving(&self) -> bool {
        self.moved.is_some_and(|at| at.elapsed() < REST)
    }

    /// The scene as it is seen: size and camera are the film's.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Size of the film, in pixels.
    pub fn film_size(&self) -> [u32; 2] {
        self.full.map(|side| ((side + self.divisor / 2) / self.divisor).max(1))
    }

    /// Most rays along one path of the film; 0 is no limit, as in scene files.
    fn film_depth(&self) -> u32 {
        match self.scene.render.max_depth {
            0 if self.shortened => SHORT_PATH,
            depth if self.shortened => depth.min(SHORT_PATH),
            depth => depth,
        }
    }

    /// Size of the picture at rest, in pixels.
    pub fn full_size(&self) -> [u32; 2] {
        self.full
    }

    /// Aspect ratio of the picture, width by height.
    pub fn aspect(&self) -> f32 {
        self.full[0] as f32 / self.full[1] as f32
    }

    fn target(&self) -> u32 {
        self.limit.unwrap_or(MOST_SAMPLES)
    }
}

fn answer(answers: Result<Vec<raggio_render::Answer>, DeviceError>) -> Result<raggio_render::Answer, ViewError> {
    Ok(answers?.into_iter().next().unwrap_or_default())
}

#[cfg(test)]
mod tests;

//! The viewer in a window of the desktop.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use raggio_vulkan::{Instance, Surface};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::raw_window_handle::HasDisplayHandle;
use winit::window::{Window, WindowId};

use crate::error::ViewError;
use crate::options::Options;
use crate::play::WindowStep;
use crate::report::Report;
use crate::stage::{Files, Opener, Stage};

/// Opens the window, and returns when it is closed.
pub fn run(options: &Options, files: Files) -> Result<Report, ViewError> {
    needs_libraries()?;
    let event_loop = EventLoop::<()>::with_user_event().build().map_err(|e| no_display(&e))?;
    let display = event_loop.owned_display_handle();
    let display = display.display_handle().map_err(|e| no_display(&e))?.as_raw();
    let instance = Instance::for_windows(options.open.validate, display)?;
    let mut app = App {
        options,
        instance,
        proxy: event_loop.create_proxy(),
        files: Some(files),
        shown: None,
        outcome: None,
        due: None,
    };
    event_loop.run_app(&mut app).map_err(|e| no_display(&e))?;
    app.outcome.unwrap_or_else(|| Ok(Report::default()))
}

struct App<'a> {
    options: &'a Options,
    instance: Arc<Instance>,
    proxy: EventLoopProxy<()>,
    files: Option<Files>,
    shown: Option<Shown>,
    outcome: Option<Result<Report, ViewError>>,
    /// Time of the next frame.
    due: Option<Instant>,
}

/// The window and what is in it.
struct Shown {
    // The stage goes before its window.
    stage: Stage,
    egui: egui_winit::State,
    window: Arc<Window>,
    title: String,
    /// Text of the unsaved scene that the user was asked about before closing.
    asked: Option<String>,
    /// Scale factor of the command line's `--scale`, or of a script.
    scale: Option<f32>,
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        // The files are taken once: some systems resume a program more often.
        let Some(files) = self.files.take() else { return };
        match self.open(event_loop, files) {
            Ok(shown) => {
                shown.window.request_redraw();
                self.shown = Some(shown);
            }
            Err(error) => self.close(event_loop, Err(error)),
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(shown)) = (cause, &self.shown) {
            shown.window.request_redraw();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, (): ()) {
        // A file has changed; it is looked at when it has been quiet for a moment.
        if let Some(shown) = &self.shown {
            shown.window.request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        // A frame that is due is no reason for another one.
        let asks = shown.egui.on_window_event(&shown.window, &event).repaint;
        if asks && event != WindowEvent::RedrawRequested {
            shown.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested if shown.may_close() => {
                let report =
                    Report::of(&mut shown.stage.viewer, self.options.start, self.instance.validation_messages());
                self.close(event_loop, Ok(report));
            }
            WindowEvent::Resized(PhysicalSize { width, height }) => {
                if let Err(error) = shown.stage.screen.canvas().resize([width, height]) {
                    // The next frame finds out whether it can be mended.
                    shown.stage.viewer.notices.fail(error);
                }
                shown.window.request_redraw();
            }
            WindowEvent::Moved(_) | WindowEvent::ScaleFactorChanged { .. } => shown.follow_monitor(),
            WindowEvent::RedrawRequested => match shown.draw() {
                Ok(None) => {
                    let report =
                        Report::of(&mut shown.stage.viewer, self.options.start, self.instance.validation_messages());
                    self.close(event_loop, Ok(report));
                }
                Ok(Some(next)) => self.due = next.map(|delay| Instant::now() + delay),
                Err(error) => self.close(event_loop, Err(error)),
            },
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(shown) = &self.shown else { return };
        match self.due {
            Some(due) if due <= Instant::now() => {
                shown.window.request_redraw();
                event_loop.set_control_flow(ControlFlow::Wait);
            }
            Some(due) => event_loop.set_control_flow(ControlFlow::WaitUntil(due)),
            None => event_loop.set_control_flow(ControlFlow::Wait),
        }
    }
}

impl App<'_> {
    fn open(&self, event_loop: &ActiveEventLoop, files: Files) -> Result<Shown, ViewError> {
        let [width, height] = self.options.size;
        let attributes =
            Window::default_attributes().with_title("raggio").with_inner_size(LogicalSize::new(width, height));
        let window = event_loop.create_window(attributes).map_err(|e| no_display(&e))?;
        let window = Arc::new(window);
        let PhysicalSize { width, height } = window.inner_size();
        let surface = Surface::new(&self.instance, &window)?;
        let opener = Opener::new(self.options, self.instance.clone());
        let proxy = std::sync::Mutex::new(self.proxy.clone());
        let wake = Arc::new(move || {
            // Sending fails only when the window is closing.
            let _ = proxy.lock().map(|proxy| proxy.send_event(()));
        });
        let stage = Stage::new(self.options, files, opener, Some(surface), [width, height], wake)?;
        let egui = egui_for(&stage, &window);
        let mut shown = Shown { stage, egui, window, title: String::new(), asked: None, scale: self.options.scale };
        shown.follow_monitor();
        Ok(shown)
    }

    fn close(&mut self, event_loop: &ActiveEventLoop, outcome: Result<Report, ViewError>) {
        self.outcome = Some(outcome);
        self.shown = None;
        event_loop.exit();
    }
}

impl Shown {
    /// Draws a frame; returns the delay of the next one, if one is due, or `None` to end the program.
    fn draw(&mut self) -> Result<Option<Option<Duration>>, ViewError> {
        let raw = self.egui.take_egui_input(&self.window);
        let window = self.window.clone();
        let instance = self.stage.instance();
        self.window.pre_present_notify();
        let outcome = self.stage.frame(raw, &|| Ok(Some(Surface::new(&instance, &window)?)))?;
        if outcome.renewed {
            self.egui = egui_for(&self.stage, &self.window);
            self.egui.egui_input_mut().focused = self.window.has_focus();
        }
        self.egui.handle_platform_output(&self.window, outcome.platform);
        for step in outcome.window {
            self.do_to_window(step);
        }
        let title = self.stage.viewer.title();
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
        Ok((!outcome.quit).then_some(outcome.next))
    }

    /// Takes over the rate and the scale of the monitor, for the window may be on another one now.
    fn follow_monitor(&mut self) {
        if let Some(interval) = refresh_interval(&self.window) {
            self.stage.viewer.clock.set_interval(interval);
        }
        if let Some(scale) = self.scale {
            self.stage.screen.ctx().set_zoom_factor(scale / self.window.scale_factor() as f32);
        }
    }

    fn do_to_window(&mut self, step: WindowStep) {
        match step {
            WindowStep::Size([width, height]) => {
                // Some systems answer at once, others with an event.
                let _ = self.window.request_inner_size(PhysicalSize::new(width, height));
            }
            WindowStep::Scale(scale) => {
                self.scale = Some(scale);
                self.follow_monitor();
            }
            WindowStep::Minimise => self.window.set_minimized(true),
            WindowStep::Restore => self.window.set_minimized(false),
        }
    }

    /// Whether the window may close; changes that are not saved are worth a second question.
    fn may_close(&mut self) -> bool {
        let viewer = &mut self.stage.viewer;
        let text = viewer.document.text();
        if viewer.document.is_modified() && self.asked.as_deref() != Some(text) {
            self.asked = Some(text.to_owned());
            viewer.notices.warn("there are changes that are not saved: Ctrl+S saves them, closing again drops them");
            self.window.request_redraw();
            return false;
        }
        true
    }
}

fn egui_for(stage: &Stage, window: &Arc<Window>) -> egui_winit::State {
    let scale = window.scale_factor() as f32;
    egui_winit::State::new(stage.screen.ctx().clone(), ViewportId::ROOT, window, Some(scale), None, None)
}

/// Error with the system's message, without the place in winit's source that says it.
fn no_display(error: &dyn std::fmt::Display) -> ViewError {
    let text = error.to_string();
    let inner = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map(|(_, inner)| inner.to_owned());
    ViewError::NoDisplay(inner.unwrap_or(text))
}

/// Looks for a library that winit needs: where it is missing, winit gives up on the whole program.
#[cfg(all(unix, not(target_os = "macos")))]
fn needs_libraries() -> Result<(), ViewError> {
    let wayland = std::env::var_os("WAYLAND_DISPLAY").is_some_and(|name| !name.is_empty());
    let x11 = std::env::var_os("DISPLAY").is_some_and(|name| !name.is_empty());
    if x11 && !wayland && xkbcommon_dl::x11::xkbcommon_x11_option().is_none() {
        let how = "libxkbcommon-x11 is missing (Debian and Ubuntu: apt install libxkbcommon-x11-0; \
                   Fedora: dnf install libxkbcommon-x11; Arch: pacman -S libxkbcommon-x11)";
        return Err(ViewError::NoDisplay(how.into()));
    }
    Ok(())
}

#[cfg(not(all(unix, not(target_os = "macos"))))]
fn needs_libraries() -> Result<(), ViewError> {
    Ok(())
}

/// Seconds from frame to frame, where the system tells.
fn refresh_interval(window: &Window) -> Option<f64> {
    let millihertz = window.current_monitor()?.refresh_rate_millihertz().filter(|rate| *rate > 0)?;
    Some(1000.0 / f64::from(millihertz))
}

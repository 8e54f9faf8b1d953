//! Steering of the camera by mouse and keys in the picture.

use raggio_scene::{Camera, Scene, Vec3};

use crate::error::ViewError;
use crate::extent::extent;
use crate::navigation::{
    Bookmarks, Button, DragAction, Modifiers, Motion, Preset, Transition, WheelAction, action, axes, default_speed,
    dolly, fly, focus_on, look, orbit, pan, set_focus, step_speed, view_from, wheel,
};
use crate::tracer::Pick;

/// Radians for a drag over the height of the picture.
const ORBIT: f32 = std::f32::consts::PI;
const LOOK: f32 = 2.0;
/// Part of the distance that is left after one notch of the wheel.
const NOTCH: f32 = 0.88;
/// Factor of the flying speed while Shift is held.
const FAST: f32 = 4.0;

/// Input of mouse and keys for the camera during one frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hands {
    /// Position of the cursor, 0 to 1 from the picture's top left; `None` if elsewhere.
    pub cursor: Option<[f32; 2]>,
    /// The button that is held since it was pressed in the picture.
    pub held: Option<Button>,
    /// Modifier keys held.
    pub modifiers: Modifiers,
    /// Movement of the cursor while dragging, right and down, in heights of the picture.
    pub moved: [f32; 2],
    /// Notches of the wheel, positive away from the user.
    pub wheel: f32,
    /// Direction of flight: to the right, up and forward, each -1 to 1.
    pub fly: Vec3,
}

/// Steers the camera.
pub struct Pilot {
    camera: Camera,
    preset: Preset,
    /// Speed of flying, in units a second.
    speed: f32,
    motion: Motion,
    transition: Option<Transition>,
    drag: Option<Drag>,
    bookmarks: Bookmarks,
}

/// A button held in the picture.
struct Drag {
    button: Button,
    action: Option<DragAction>,
    /// The point that was under the cursor.
    pivot: Vec3,
}

impl Pilot {
    /// Creates a pilot at the scene's own camera.
    pub fn new(scene: &Scene) -> Self {
        let diagonal = extent(&scene.shapes).map_or(0.0, |(low, high)| (high - low).length());
        // Ground that is a giant sphere says nothing about the size of what stands on it.
        let seen = 4.0 * (scene.camera.look_at - scene.camera.position).length();
        let extent = if diagonal > 0.0 { diagonal.min(seen) } else { seen };
        Self {
            camera: scene.camera.clone(),
            preset: Preset::Raggio,
            speed: default_speed(extent),
            motion: Motion::default(),
            transition: None,
            drag: None,
            bookmarks: Bookmarks::default(),
        }
    }

    /// The camera as it is now.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Preset of how the mouse steers.
    pub fn preset(&self) -> Preset {
        self.preset
    }

    /// Changes how the mouse steers.
    pub fn set_preset(&mut self, preset: Preset) {
        self.preset = preset;
    }

    /// Speed of flying, in units a second.
    pub fn speed(&self) -> f32 {
        self.speed
    }

    /// Flies at another speed, in units a second.
    pub fn set_speed(&mut self, speed: f32) {
        self.speed = step_speed(speed, 0.0);
    }

    /// Moves to `camera` at once.
    pub fn jump(&mut self, camera: Camera) {
        self.stop();
        self.camera = camera;
    }

    /// Moves to `camera` smoothly.
    pub fn go(&mut self, camera: Camera) {
        self.stop();
        if camera != self.camera {
            self.transition = Some(Transition::new(self.camera.clone(), camera));
        }
    }

    /// Orbits so many radians to the right around the point that the camera looks at.
    pub fn orbit(&mut self, angle: f32) {
        self.stop();
        self.camera = orbit(&self.camera, self.camera.look_at, angle, 0.0);
    }

    /// Moves so that a shape of `scene` fills the picture; without bounds of the shape nothing moves.
    pub fn focus_on(&mut self, scene: &Scene, shape: usize, aspect: f32) {
        if let Some((low, high)) = extent(scene.shapes_of(shape)) {
            self.go(focus_on(&self.camera, (low + high) / 2.0, (high - low).length() / 2.0, aspect));
        }
    }

    /// Puts the plane in focus through `point`.
    pub fn set_focus(&mut self, point: Vec3) {
        self.camera = set_focus(&self.camera, point);
    }

    /// Moves to look from this side of the point that the camera looks at.
    pub fn look_from(&mut self, direction: Vec3) {
        self.go(view_from(&self.camera, direction));
    }

    /// Remembers the view under this number, 1 to 9.
    pub fn store(&mut self, number: usize) {
        self.bookmarks.store(number, self.camera.clone());
    }

    /// Goes to a remembered view; false if there is none.
    pub fn recall(&mut self, number: usize) -> bool {
        let view = self.bookmarks.recall(number).cloned();
        view.map(|camera| self.go(camera)).is_some()
    }

    /// Whether the camera moves by itself, or is flown.
    pub fn is_moving(&self) -> bool {
        self.transition.is_some() || self.motion.is_moving()
    }

    /// Moves as hands say, `seconds` after the last time; true if the camera is another one then. `pick` finds the
    /// surface under a point of the picture.
    pub fn steer(
        &mut self,
        hands: &Hands,
        seconds: f64,
        mut pick: impl FnMut([f32; 2]) -> Result<Option<Pick>, ViewError>,
    ) -> Result<bool, ViewError> {
        let before = self.camera.clone();
        let busy = hands.held.is_some() || hands.wheel != 0.0 || hands.fly != Vec3::ZERO;
        if busy {
            self.transition = None;
        }
        if let Some(transition) = &mut self.transition {
            self.camera = transition.advance(seconds as f32);
            if transition.is_done() {
                self.transition = None;
            }
        }

        let speed = self.speed * if hands.modifiers.shift { FAST } else { 1.0 };
        let step = self.motion.advance(seconds as f32, hands.fly, speed);
        if step != Vec3::ZERO {
            self.camera = fly(&self.camera, step, 1.0);
        }
        self.drag(hands, &mut pick)?;
        self.turn_wheel(hands, &mut pick)?;
        Ok(self.camera != before)
    }

    fn drag(
        &mut self,
        hands: &Hands,
        pick: &mut impl FnMut([f32; 2]) -> Result<Option<Pick>, ViewError>,
    ) -> Result<(), ViewError> {
        let Some(button) = hands.held else {
            self.drag = None;
            return Ok(());
        };
        if self.drag.as_ref().is_none_or(|drag| drag.button != button) {
            let action = action(self.preset, button, hands.modifiers);
            let anchored = action != Some(DragAction::Orbit) || self.preset.orbits_under_cursor();
            let under = if anchored && action.is_some() { self.under(hands.cursor, pick)? } else { None };
            self.drag = Some(Drag { button, action, pivot: under.unwrap_or(self.camera.look_at) });
        }
        let Some(Drag { action: Some(action), pivot, .. }) = self.drag else { return Ok(()) };
        let [dx, dy] = hands.moved;
        if dx == 0.0 && dy == 0.0 {
            return Ok(());
        }
        let camera = &self.camera;
        let depth = (pivot - camera.position).as_dvec3().dot(axes(camera).forward) as f32;
        self.camera = match action {
            DragAction::Orbit => orbit(camera, pivot, -ORBIT * dx, -ORBIT * dy),
            DragAction::Look => look(camera, -LOOK * dx, -LOOK * dy),
            DragAction::Pan => pan(camera, dx, dy, depth),
            DragAction::Dolly => dolly(camera, (3.0 * dy).exp(), pivot),
        };
        Ok(())
    }

    fn turn_wheel(
        &mut self,
        hands: &Hands,
        pick: &mut impl FnMut([f32; 2]) -> Result<Option<Pick>, ViewError>,
    ) -> Result<(), ViewError> {
        if hands.wheel == 0.0 {
            return Ok(());
        }
        match wheel(self.preset, hands.held) {
            WheelAction::Speed => self.speed = step_speed(self.speed, hands.wheel),
            WheelAction::Dolly => {
                let pivot = self.under(hands.cursor, pick)?.unwrap_or(self.camera.look_at);
                self.camera = dolly(&self.camera, NOTCH.powf(hands.wheel), pivot);
            }
        }
        Ok(())
    }

    /// The point under the cursor.
    fn under(
        &self,
        cursor: Option<[f32; 2]>,
        pick: &mut impl FnMut([f32; 2]) -> Result<Option<Pick>, ViewError>,
    ) -> Result<Option<Vec3>, ViewError> {
        let Some(cursor) = cursor else { return Ok(None) };
        Ok(pick(cursor)?.map(|pick| pick.position))
    }

    fn stop(&mut self) {
        self.motion.stop();
        self.transition = None;
    }
}

#[cfg(test)]
mod tests;

//! Actions of the mouse's buttons and wheel, in the ways that people know from other programs.

use raggio_choice::choice;

choice! {
    /// A way to steer the camera with the mouse.
    pub enum Preset: "preset" {
        /// The left button orbits about the point under the cursor, the right one looks around.
        Raggio = "raggio",
        /// Buttons of Blender: the middle one orbits, pans with Shift, and goes closer and farther with Ctrl.
        Blender = "Blender",
        /// Buttons of three.js on web pages: left orbits, middle goes closer and farther, right pans.
        OrbitControls = "OrbitControls",
        /// Buttons of a game seen through the player's eyes: the left and the right one look around, the middle one pans.
        Game = "Game",
    }
}

impl Preset {
    /// Whether an orbit is about the point under the cursor where it began; else it is about `look_at`.
    pub fn orbits_under_cursor(self) -> bool {
        self == Self::Raggio
    }
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Primary button.
    Left,
    /// Middle button, often the wheel.
    Middle,
    /// Secondary button.
    Right,
}

/// Modifier keys held with a button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Modifiers {
    /// Either Shift key.
    pub shift: bool,
    /// Either Ctrl key, or Command.
    pub ctrl: bool,
    /// Either Alt key.
    pub alt: bool,
}

/// Action of dragging.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragAction {
    /// Turns the camera on the spot.
    Look,
    /// Turns the camera about a point.
    Orbit,
    /// Moves parallel to the picture.
    Pan,
    /// Moves towards a point and away.
    Dolly,
}

/// Action of the wheel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WheelAction {
    /// Moves towards a point and away.
    Dolly,
    /// Makes flying faster and slower.
    Speed,
}

/// Action of dragging with a button, if it has one.
pub fn action(preset: Preset, button: Button, modifiers: Modifiers) -> Option<DragAction> {
    use Button::{Left, Middle, Right};
    match (preset, button) {
        (Preset::Raggio, Left) => Some(DragAction::Orbit),
        (Preset::Raggio, Middle) => Some(DragAction::Pan),
        (Preset::Raggio, Right) => Some(DragAction::Look),
        (Preset::Blender, Middle) if modifiers.shift => Some(DragAction::Pan),
        (Preset::Blender, Middle) if modifiers.ctrl => Some(DragAction::Dolly),
        (Preset::Blender, Middle) => Some(DragAction::Orbit),
        (Preset::Blender, Left | Right) => None,
        (Preset::OrbitControls, Left) => Some(DragAction::Orbit),
        (Preset::OrbitControls, Middle) => Some(DragAction::Dolly),
        (Preset::OrbitControls, Right) => Some(DragAction::Pan),
        (Preset::Game, Left | Right) => Some(DragAction::Look),
        (Preset::Game, Middle) => Some(DragAction::Pan),
    }
}

/// Action of the wheel while `held` is the button held down.
pub fn wheel(preset: Preset, held: Option<Button>) -> WheelAction {
    match (preset, held) {
        (Preset::Game, _) | (Preset::Raggio, Some(Button::Right)) => WheelAction::Speed,
        _ => WheelAction::Dolly,
    }
}

/// Keys and what they do, for the help: first those of the mouse, which differ, then those common to all.
pub fn describe(preset: Preset) -> &'static [(&'static str, &'static str)] {
    match preset {
        Preset::Raggio => RAGGIO,
        Preset::Blender => BLENDER,
        Preset::OrbitControls => ORBIT_CONTROLS,
        Preset::Game => GAME,
    }
}

/// A table of the mouse's rows and the common ones.
macro_rules! with_common {
    ($($row:expr),* $(,)?) => {
        &[
            $($row,)*
            ("W A S D", "fly"),
            ("Q E", "fly down, up"),
            ("Shift", "faster"),
            ("Double click", "look at the object"),
            ("F", "focus on the point under the cursor (hold it and click)"),
            ("Home", "the scene's own camera"),
            ("1 - 9", "recall a view"),
            ("Ctrl+1 - 9", "store a view"),
            ("Ctrl+C, Ctrl+V", "copy, paste the camera as text"),
            ("Ctrl+Z", "undo"),
            ("Ctrl+Shift+Z, Ctrl+Y", "redo"),
            ("Ctrl+S", "save"),
            ("Delete", "remove the selected shape"),
            ("Esc", "deselect"),
            ("Space", "pause"),
            ("R", "restart"),
            ("F1", "help"),
            ("F2", "panels"),
            ("F5", "reload the file"),
            ("F12", "screenshot"),
        ]
    };
}

const RAGGIO: &[(&str, &str)] = with_common![
    ("Left drag", "orbit about the point under the cursor"),
    ("Middle drag", "pan"),
    ("Right drag", "look around"),
    ("Wheel", "closer, farther"),
    ("Right button + wheel", "flying speed"),
];

const BLENDER: &[(&str, &str)] = with_common![
    ("Left click", "select"),
    ("Middle drag", "orbit"),
    ("Shift + middle drag", "pan"),
    ("Ctrl + middle drag", "closer, farther"),
    ("Wheel", "closer, farther"),
];

const ORBIT_CONTROLS: &[(&str, &str)] = with_common![
    ("Left drag", "orbit about the point looked at"),
    ("Right drag", "pan"),
    ("Middle drag", "closer, farther"),
    ("Wheel", "closer, farther"),
];

const GAME: &[(&str, &str)] =
    with_common![("Left or right drag", "look around"), ("Middle drag", "pan"), ("Wheel", "flying speed"),];

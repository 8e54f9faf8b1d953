//! Translation of egui's events into input to the picture.

use egui::{Event, Key, Modifiers as Held, PointerButton, Pos2, Rect, Response, Ui, Vec2};
use raggio_scene::Vec3;

use crate::command::{Command, Navigate};
use crate::navigation::{Button, Modifiers};
use crate::pilot::Hands;

/// Pixels of scrolling in a notch of the wheel, as egui counts them.
const NOTCH: f32 = 40.0;

/// Input to the picture during one frame.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// Mouse and keys that move the camera.
    pub hands: Hands,
    /// Position of a click, 0 to 1 from the picture's top left.
    pub clicked: Option<[f32; 2]>,
    /// Position of a double click, 0 to 1 from the picture's top left.
    pub double_clicked: Option<[f32; 2]>,
    /// Commands of keys, of a click with F, and of dropped files.
    pub commands: Vec<Command>,
}

/// Reads the frame's events in the `room` that the panels leave; `area` in it is where the picture is, in points.
pub fn read(ui: &Ui, room: Rect, area: Rect) -> Input {
    let response = ui.interact(room, ui.id().with("picture"), egui::Sense::click_and_drag());
    // Escape ends typing before this is asked, so that what was true a frame ago counts too.
    let was_typing = ui.id().with("typing");
    let now = ui.ctx().text_edit_focused();
    let typing = now || ui.data(|data| data.get_temp(was_typing).unwrap_or(false));
    ui.data_mut(|data| data.insert_temp(was_typing, now));
    let mut input = Input { hands: hands(ui, &response, area, typing), ..Input::default() };
    let pointer = response.interact_pointer_pos();
    let at = pointer.filter(|at| area.contains(*at)).map(|at| part(at - area.min, area));
    if response.double_clicked() {
        input.double_clicked = at;
    } else if response.clicked() {
        input.clicked = at;
        // Beside the picture there is nothing to be selected.
        input.commands.extend(at.is_none().then_some(Command::Select(None)));
    }
    if let Some(at) = input.clicked.filter(|_| !typing && ui.input(|i| i.key_down(Key::F))) {
        input.clicked = None;
        input.commands.push(Command::Navigate(Navigate::FocusAt(at)));
    }
    if !typing {
        ui.input_mut(|i| keys(i, &mut input.commands));
    }
    let dropped = ui.input(|i| i.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect::<Vec<_>>());
    input.commands.extend(dropped.into_iter().map(Command::Open));
    input
}

fn hands(ui: &Ui, response: &Response, area: Rect, typing: bool) -> Hands {
    ui.input(|i| {
        let buttons = [
            (PointerButton::Primary, Button::Left),
            (PointerButton::Middle, Button::Middle),
            (PointerButton::Secondary, Button::Right),
        ];
        let down = buttons.into_iter().find(|(button, _)| i.pointer.button_down(*button)).map(|(_, button)| button);
        let held = down.filter(|_| response.is_pointer_button_down_on());
        // A hand that clicks trembles a little; egui tells a drag from that.
        let moved =
            if held.is_some() && response.dragged() { i.pointer.delta() / area.height().max(1.0) } else { Vec2::ZERO };
        // With Shift the wheel scrolls sideways.
        let scrolled = if response.hovered() { i.smooth_scroll_delta.x + i.smooth_scroll_delta.y } else { 0.0 };
        // A drag goes on where there is no picture, but does not begin at a point of it there.
        let inside = |at: Option<Pos2>| at.is_some_and(|at| area.contains(at));
        let pointer = i.pointer.latest_pos();
        let points =
            if held.is_some() { inside(i.pointer.press_origin()) } else { response.hovered() && inside(pointer) };
        let cursor = pointer.filter(|_| points);
        Hands {
            cursor: cursor.map(|at| part(at - area.min, area)),
            held,
            modifiers: Modifiers { shift: i.modifiers.shift, ctrl: i.modifiers.command, alt: i.modifiers.alt },
            moved: moved.into(),
            wheel: scrolled / NOTCH,
            fly: if typing || i.modifiers.command { Vec3::ZERO } else { flight(i) },
        }
    })
}

fn flight(i: &egui::InputState) -> Vec3 {
    let axis =
        |positive, negative| f32::from(u8::from(i.key_down(positive))) - f32::from(u8::from(i.key_down(negative)));
    Vec3::new(axis(Key::D, Key::A), axis(Key::E, Key::Q), axis(Key::W, Key::S))
}

/// Adds the commands of keys that act once when they are pressed.
fn keys(i: &mut egui::InputState, commands: &mut Vec<Command>) {
    let plain = [
        (Key::F1, Command::Help),
        (Key::F2, Command::Panels),
        (Key::F5, Command::Reload),
        (Key::F12, Command::Screenshot(None)),
        (Key::Space, Command::Pause),
        (Key::R, Command::Restart),
        (Key::Home, Command::Navigate(Navigate::Home)),
        (Key::Delete, Command::RemoveSelected),
        (Key::Escape, Command::Select(None)),
    ];
    let with_control = [
        (Held::COMMAND | Held::SHIFT, Key::Z, Command::Redo),
        (Held::COMMAND, Key::Z, Command::Undo),
        (Held::COMMAND, Key::Y, Command::Redo),
        (Held::COMMAND, Key::S, Command::Save(None)),
    ];
    let plain = plain.into_iter().map(|(key, command)| (Held::NONE, key, command));
    for (held, key, command) in with_control.into_iter().chain(plain) {
        // A key that is held down repeats: only undo and redo are worth that.
        let repeats = |event: &Event| matches!(event, Event::Key { key: k, repeat: true, .. } if *k == key);
        let again = i.events.iter().any(repeats) && !matches!(command, Command::Undo | Command::Redo);
        if i.consume_key(held, key) && !again {
            commands.push(command);
        }
    }
    let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    for (number, key) in (1..).zip(numbers) {
        if i.consume_key(Held::COMMAND, key) {
            commands.push(Command::Navigate(Navigate::Store(number)));
        } else if i.consume_key(Held::NONE, key) {
            commands.push(Command::Navigate(Navigate::Recall(number)));
        }
    }
    commands.extend(i.events.iter().filter_map(|event| match event {
        Event::Copy => Some(Command::CopyCamera),
        Event::Paste(text) => Some(Command::PasteCamera(text.clone())),
        _ => None,
    }));
}

/// Position 0 to 1 from the area's top left; `at` is in points from there.
fn part(at: Vec2, area: Rect) -> [f32; 2] {
    [(at.x / area.width().max(1.0)).clamp(0.0, 1.0), (at.y / area.height().max(1.0)).clamp(0.0, 1.0)]
}

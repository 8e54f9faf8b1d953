//! Undo, redo, gestures.

use crate::document::{HEADERS, ball, check, document};

fn shrink(it: &mut raggio_viewer::document::Document, radius: f32) {
    it.set_shape(0, &ball([0.0, 1.0, 0.0], radius), 0).unwrap();
}

#[test]
fn steps_have_names_and_come_back() {
    let mut it = document(HEADERS);
    shrink(&mut it, 0.5);
    it.set_shape(0, &ball([0.0, 2.0, 0.0], 0.5), 0).unwrap();
    it.set_shape(0, &ball([0.0, 2.0, 0.0], 0.5), 1).unwrap();
    it.remove_shape(1).unwrap();
    let end = it.text().to_string();
    for name in ["remove plane", "paint sphere", "move sphere", "change sphere"] {
        assert_eq!(it.can_undo(), Some(name));
        assert_eq!(it.undo().as_deref(), Some(name));
        assert_eq!(it.can_redo(), Some(name));
        check(&it);
    }
    assert_eq!((it.undo(), it.text()), (None, HEADERS));
    while it.redo().is_some() {}
    assert_eq!(it.text(), end);

    it.undo();
    shrink(&mut it, 0.25);
    assert_eq!(it.can_redo(), None);
}

#[test]
fn a_gesture_is_one_step() {
    let mut it = document(HEADERS);
    for radius in [0.9, 0.8, 0.7] {
        it.begin_gesture("radius");
        shrink(&mut it, radius);
    }
    it.end_gesture();
    let first = it.text().to_string();
    it.begin_gesture("radius");
    shrink(&mut it, 0.6);
    it.begin_gesture("another");
    shrink(&mut it, 0.5);
    it.end_gesture();
    shrink(&mut it, 0.4);
    shrink(&mut it, 0.3);
    for _ in 0..4 {
        it.undo().unwrap();
    }
    assert_eq!(it.text(), first);
    it.undo().unwrap();
    assert_eq!((it.text(), it.can_undo()), (HEADERS, None));
}

#[test]
fn a_gesture_that_returns_is_no_step() {
    let mut it = document(HEADERS);
    it.begin_gesture("radius");
    shrink(&mut it, 0.5);
    shrink(&mut it, 1.0);
    assert_eq!((it.text(), it.can_undo()), (HEADERS, None));
    shrink(&mut it, 0.5);
    shrink(&mut it, 0.25);
    it.undo().unwrap();
    assert_eq!((it.text(), it.can_undo()), (HEADERS, None));
}

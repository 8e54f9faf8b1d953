use super::*;

fn scene() -> Scene {
    let text = "version = 1\n[camera]\nposition = [0, 1, 4]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40\n\
        [materials.clay]\n[[shapes]]\nmaterial = \"clay\"\nsphere = { center = [0, 1, 0], radius = 1 }\n\
        [[shapes]]\nmaterial = \"clay\"\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }\n";
    Scene::parse(text, "test").expect("a scene")
}

/// A pick of the front of the sphere, wherever the cursor is.
fn front(_: [f32; 2]) -> Result<Option<Pick>, ViewError> {
    let position = Vec3::new(0.0, 1.0, 1.0);
    Ok(Some(Pick { position, normal: Vec3::Z, distance: 3.0, shape: 0, material: 0 }))
}

fn nothing(_: [f32; 2]) -> Result<Option<Pick>, ViewError> {
    Ok(None)
}

fn drag(button: Button, moved: [f32; 2]) -> Hands {
    Hands { cursor: Some([0.5, 0.5]), held: Some(button), moved, ..Hands::default() }
}

#[test]
fn hands_that_rest_leave_the_camera_alone() {
    let mut pilot = Pilot::new(&scene());
    for _ in 0..10 {
        assert!(!pilot.steer(&Hands::default(), 0.016, front).expect("no device"));
    }
    assert!(!pilot.is_moving());
    assert_eq!(*pilot.camera(), scene().camera);
}

#[test]
fn an_orbit_keeps_its_distance_to_the_point_that_was_under_the_cursor() {
    let mut pilot = Pilot::new(&scene());
    let pivot = Vec3::new(0.0, 1.0, 1.0);
    // The point is looked up when the button goes down, and not again.
    assert!(!pilot.steer(&drag(Button::Left, [0.0, 0.0]), 0.016, front).expect("no device"));
    for _ in 0..20 {
        assert!(pilot.steer(&drag(Button::Left, [0.02, 0.005]), 0.016, nothing).expect("no device"));
        assert!(((pilot.camera().position - pivot).length() - 3.0).abs() < 1e-4);
    }
    // The mouse moves right and the camera left around the object, which seems to turn with the hand; the mouse moves
    // down and the camera above it.
    assert!(pilot.camera().position.x < -0.5 && pilot.camera().position.y > 1.1);
}

#[test]
fn the_right_button_looks_around_on_the_spot() {
    let mut pilot = Pilot::new(&scene());
    assert!(pilot.steer(&drag(Button::Right, [0.1, 0.0]), 0.016, nothing).expect("no device"));
    assert_eq!(pilot.camera().position, scene().camera.position);
    assert!(pilot.camera().look_at.x > 0.5);
}

#[test]
fn presets_give_buttons_other_meanings() {
    let mut pilot = Pilot::new(&scene());
    pilot.set_preset(Preset::Blender);
    assert!(!pilot.steer(&drag(Button::Left, [0.1, 0.1]), 0.016, front).expect("no device"), "Blender selects");
    pilot.steer(&Hands::default(), 0.016, front).expect("no device");
    pilot.set_preset(Preset::OrbitControls);
    assert!(pilot.steer(&drag(Button::Right, [0.1, 0.0]), 0.016, nothing).expect("no device"));
    let (camera, before) = (pilot.camera(), scene().camera);
    assert!((camera.look_at - camera.position).abs_diff_eq(before.look_at - before.position, 1e-5), "it pans");
}

#[test]
fn the_wheel_approaches_what_is_under_the_cursor_or_sets_the_speed() {
    let mut pilot = Pilot::new(&scene());
    let wheel = Hands { cursor: Some([0.5, 0.5]), wheel: 1.0, ..Hands::default() };
    assert!(pilot.steer(&wheel, 0.016, front).expect("no device"));
    assert!((pilot.camera().position.z - (1.0 + 3.0 * NOTCH)).abs() < 1e-5);

    let (speed, camera) = (pilot.speed(), pilot.camera().clone());
    let held = Hands { held: Some(Button::Right), ..wheel };
    pilot.steer(&held, 0.016, front).expect("no device");
    assert!(pilot.speed() > speed);
    assert_eq!(*pilot.camera(), camera);
}

#[test]
fn flying_is_as_fast_at_any_frame_rate_and_faster_with_shift() {
    let flown = |rate: u32, shift: bool| {
        let mut pilot = Pilot::new(&scene());
        let modifiers = Modifiers { shift, ..Modifiers::default() };
        let hands = Hands { fly: Vec3::Z, modifiers, ..Hands::default() };
        for _ in 0..rate {
            pilot.steer(&hands, 1.0 / f64::from(rate), nothing).expect("no device");
        }
        scene().camera.position.z - pilot.camera().position.z
    };
    assert!((flown(240, false) / flown(20, false) - 1.0).abs() < 0.01);
    assert!((flown(60, true) / flown(60, false) - FAST).abs() < 0.01);
}

#[test]
fn a_hand_stops_what_moves_by_itself() {
    let mut pilot = Pilot::new(&scene());
    pilot.store(3);
    let other = Camera { position: Vec3::new(4.0, 1.0, 0.0), ..scene().camera };
    pilot.go(other.clone());
    assert!(pilot.is_moving());
    for _ in 0..40 {
        pilot.steer(&Hands::default(), 0.016, nothing).expect("no device");
    }
    assert_eq!(*pilot.camera(), other);
    assert!(!pilot.recall(4), "there is no such view");
    assert!(pilot.recall(3));
    pilot.steer(&drag(Button::Right, [0.0, 0.0]), 0.016, nothing).expect("no device");
    assert!(!pilot.is_moving());
}

#[test]
fn what_has_no_bounds_is_not_focused_on() {
    let mut pilot = Pilot::new(&scene());
    pilot.focus_on(&scene(), 1, 1.5);
    pilot.focus_on(&scene(), 7, 1.5);
    assert!(!pilot.is_moving());
    pilot.focus_on(&scene(), 0, 1.5);
    assert!(pilot.is_moving());
}

//! Notation of numbers, and values that are refused.

use raggio_viewer::document::EditError;

use crate::document::{FORMS, HEADERS, ball, check, document, edited, with};

#[test]
fn numbers_are_as_short_as_they_can_be() {
    for (radius, digits) in [
        (0.1, "0.1"),
        (3.0, "3"),
        (1.0 / 3.0, "0.33333334"),
        (16777216.0, "16777216"),
        (1e-7, "0.0000001"),
        (1e9, "1000000000"),
    ] {
        let after = edited(HEADERS, |it| it.set_shape(0, &ball([0.0, 1.0, 0.0], radius), 0).unwrap());
        assert_eq!(after, with(HEADERS, "radius = 1 }", &format!("radius = {digits} }}")));
    }
}

#[test]
fn what_is_no_scene_is_refused_and_changes_nothing() {
    for text in FORMS {
        let mut it = document(text);
        let mut camera = it.scene().camera.clone();
        camera.look_at = camera.position;
        assert!(matches!(it.set_camera(&camera), Err(EditError::Scene(_))));
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(matches!(it.set_shape(0, &ball([0.0; 3], radius), 0), Err(EditError::Scene(_))));
            assert!(it.add_shape(&ball([0.0; 3], radius), 0).is_err());
        }
        assert_eq!(it.remove_shape(2).unwrap_err().to_string(), "there is no shape 3: the scene has 2 shapes");
        assert!(it.set_shape(0, &ball([0.0; 3], 1.0), 2).is_err() && it.add_shape(&ball([0.0; 3], 1.0), 2).is_err());
        let material = it.scene().materials[0].clone();
        assert!(it.set_material(2, &material).is_err() && it.duplicate_shape(2).is_err());
        assert_eq!((it.text(), it.can_undo()), (text, None));
        check(&it);
    }
}

#[test]
fn line_breaks_and_marks_stay() {
    for text in [HEADERS.replace('\n', "\r\n"), format!("\u{feff}{HEADERS}"), HEADERS.trim_end().to_string()] {
        let after = edited(&text, |it| it.set_shape(0, &ball([0.0, 1.0, 0.0], 2.0), 0).unwrap());
        assert_eq!(after, with(&text, "radius = 1 }", "radius = 2 }"));
    }
}

#[test]
fn names_of_materials_are_free_and_quoted() {
    let mut it = document(HEADERS);
    let material = it.scene().materials[0].clone();
    for name in ["red", "red", "red_2", "", "two \"words\"", "a.b", "2"] {
        it.add_material(name, &material).unwrap();
        check(&it);
    }
    let names: Vec<&str> = it.scene().materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["red", "matt white", "red_2", "red_3", "red_4", "material", "two \"words\"", "a.b", "2"]);
}

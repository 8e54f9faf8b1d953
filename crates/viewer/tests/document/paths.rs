//! Edits by path.

use crate::document::{DOTTED, FORMS, HEADERS, document, edited, with};

#[test]
fn paths_lead_to_keys_in_every_form() {
    for text in FORMS {
        let mut it = document(text);
        for (path, value) in [
            ("materials.red.color", "[1, 0, 0]"),
            ("materials.\"matt white\".smoothness", "0.5"),
            ("materials.blue", "{ color = [0, 0, 1] }"),
            ("shapes.1.sphere.radius", "0.5"),
            ("shapes.1.material", "\"blue\""),
            ("shapes.2.plane.point.2", "-1"),
            ("camera.position", "[0, 2, 5]"),
            ("environment.color", "[1, 1, 1]"),
            ("environment", "{ horizon = [1, 1, 1], zenith = [0, 0, 1] }"),
            ("render.samples", "9"),
            ("camera.focus_distance", "3"),
        ] {
            assert!(it.edit_path(path, value).unwrap(), "{path}: {}", it.text());
            crate::document::check(&it);
            assert!(!it.edit_path(path, value).unwrap_or(false), "{path}");
        }
        let scene = it.scene();
        assert_eq!((scene.render.samples, scene.camera.focus_distance, scene.shapes[0].material), (9, 3.0, 2));
        assert_eq!(it.can_undo(), Some("set camera.focus_distance"));
    }
}

#[test]
fn comments_stay() {
    let after = edited(HEADERS, |it| it.edit_path("materials.red.color", "[1, 0, 0]").unwrap());
    assert_eq!(after, with(HEADERS, "[ 0.8, 0.1, 0.1 ]", "[1, 0, 0]"));
    let after =
        edited(DOTTED, |it| it.edit_path("shapes.2.plane", "{ point = [0, 1, 0], normal = [0, 1, 0] }").unwrap());
    assert_eq!(after, DOTTED.replace("point = [0, 0, 0]", "point = [0, 1, 0]").replace("[0, 2, 0]", "[0, 1, 0]"));
}

#[test]
fn wrong_paths_say_what_there_is() {
    for (path, value, message) in [
        ("shapes.7.sphere.radius", "1", "`shapes` has no `7`: it has 2, counted from 1"),
        ("shapes.0.sphere.radius", "1", "`shapes` has no `0`: it has 2, counted from 1"),
        ("shapes.2.plane.point.0", "1", "`shapes.2.plane.point` has no `0`: it has 3, counted from 1"),
        ("shapes.first.material", "\"red\"", "`shapes` has no `first`: it has 2, counted from 1"),
        ("materials.rde.color", "[1, 0, 0]", "`materials` has no `rde`: it has `red`, `matt white`"),
        ("camera.position.1.x", "1", "`camera.position.1` is a single value: it has no `x`"),
        ("camera.", "1", "`camera.` is no path of a key"),
        ("shapes", "[]", "`shapes` is a list of tables: name one of them"),
        ("camera", "1", "`camera` is a table: give all of it in braces, or one of its keys a value"),
    ] {
        let error = document(HEADERS).edit_path(path, value).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    let message = |path: &str, value: &str| document(HEADERS).edit_path(path, value).unwrap_err().to_string();
    assert!(message("materials.red.colour", "[1, 0, 0]").ends_with("did you mean `color`?"));
    assert!(message("camera.position", "[0, 1").starts_with("the value for `camera.position` is not valid TOML: "));
    assert!(message("camera.up", "[0, 1, 0]\nseed = 1").starts_with("the value for `camera.up` is not valid TOML: "));
    assert!(message("camera.position", "[0, 1, 0]").contains("same point"));
}

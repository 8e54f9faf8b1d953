//! Shapes that come and go, and the comments around them.

use raggio_scene::{LightEntry, LightPlace, Shape, Vec3};

use crate::document::{DOTTED, FORMS, HEADERS, INLINE, ball, check, document, edited, with};

#[test]
fn a_shape_is_added_at_the_end() {
    let shape = "material = \"red\"\nsphere = { center = [0, 0.1, 0], radius = 2 }\n";
    for (text, old, new) in [
        (HEADERS, "# The end.", format!("\n[[shapes]]\n{shape}# The end.")),
        (
            INLINE,
            "# floor\n]",
            "# floor\n  { material = \"red\", sphere = { center = [0, 0.1, 0], radius = 2 } },\n]".to_string(),
        ),
        (DOTTED, "normal = [0, 2, 0]\n", format!("normal = [0, 2, 0]\n\n[[shapes]]\n{shape}")),
    ] {
        let after = edited(text, |it| {
            assert_eq!(it.add_shape(&ball([0.0, 0.1, 0.0], 2.0), 0).unwrap(), 2);
            true
        });
        assert_eq!(after, with(text, old, &new));
    }
}

#[test]
fn the_first_shape_can_be_added_and_the_last_removed() {
    let start = HEADERS.split("# A ball.").next().unwrap();
    for text in [start.to_string(), start.replace("version = 1", "version = 1\nshapes = []")] {
        let mut it = document(&text);
        assert_eq!(it.add_shape(&ball([0.0; 3], 1.0), 1).unwrap(), 0);
        check(&it);
        assert!(it.remove_shape(0).unwrap());
        assert_eq!(it.text(), text);
    }
}

#[test]
fn a_copy_comes_last() {
    for text in FORMS {
        for index in 0..2 {
            let mut it = document(text);
            assert_eq!(it.duplicate_shape(index).unwrap(), 2);
            check(&it);
            let copy = Shape { entry: index, ..it.scene().shapes[2].clone() };
            assert_eq!(copy, it.scene().shapes[index], "{}", it.text());
            assert_eq!(it.scene().shapes[..2], document(text).scene().shapes[..], "{}", it.text());
        }
    }
}

#[test]
fn a_removed_shape_takes_its_own_comments() {
    let ball = "# A ball.\n[[shapes]]\nmaterial = \"red\"\nsphere = { center = [0, 1, 0], radius = 1 } # unit\n";
    assert_eq!(edited(HEADERS, |it| it.remove_shape(0).unwrap()), with(HEADERS, &format!("\n{ball}"), ""));

    let (ball, floor) = INLINE.split_once("shapes = [\n").unwrap().1.split_once("\n  # Below it all.\n").unwrap();
    let floor = floor.strip_suffix("\n]\n").unwrap();
    let without_ball = edited(INLINE, |it| it.remove_shape(0).unwrap());
    assert_eq!(without_ball, with(INLINE, &format!("{ball}\n"), ""));
    let without_floor = edited(INLINE, |it| it.remove_shape(1).unwrap());
    assert_eq!(without_floor, with(INLINE, &format!("\n  # Below it all.\n{floor}"), ""));
}

#[test]
fn lists_on_one_line_stay_on_it() {
    let shape = |radius: u32| format!("{{ material = \"red\", sphere = {{ center = [0, 1, 0], radius = {radius} }} }}");
    let start = INLINE.split("shapes").next().unwrap();
    let list = |radii: &[u32]| {
        let shapes = radii.iter().map(|radius| shape(*radius)).collect::<Vec<_>>().join(", ");
        format!("{start}shapes = [{shapes}]\n")
    };
    let removed = |index| edited(&list(&[1, 2, 3]), |it| it.remove_shape(index).unwrap());
    assert_eq!([0, 1, 2].map(removed), [list(&[2, 3]), list(&[1, 3]), list(&[1, 2])]);
    let added = edited(&list(&[1]), |it| it.add_shape(&ball([0.0, 1.0, 0.0], 4.0), 0).is_ok());
    assert_eq!(added, list(&[1, 4]));
}

#[test]
fn tables_in_any_order_stay_in_it() {
    let text = "version = 1\n[[shapes]]\nmaterial = \"a\"\n[shapes.sphere]\ncenter = [0, 0, 0]\nradius = 1\n\
                [materials.a]\n[render]\nseed = 1\n[[shapes]]\nmaterial = \"b\"\nsphere = { center = [0, 0, 0], radius = 2 }\n\
                [camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n[materials.b]\n# The end.\n";
    let removed = edited(text, |it| it.remove_shape(0).unwrap());
    assert_eq!(removed, text.replace(&text[12..text.find("[materials.a]").unwrap()], ""));
    let copied = edited(text, |it| it.duplicate_shape(0).is_ok());
    let copy = "\n[[shapes]]\nmaterial = \"a\"\n[shapes.sphere]\ncenter = [0, 0, 0]\nradius = 1\n";
    assert_eq!(copied, with(text, "[camera]", &format!("{copy}[camera]")));
    let material = document(text).scene().materials[0].clone();
    let added = edited(text, |it| it.add_material("c", &material).is_ok());
    assert_eq!(added, with(text, "[materials.b]\n", "[materials.b]\n\n[materials.c]\n"));
}

#[test]
fn lights_come_and_go() {
    let light = |intensity| LightEntry {
        place: LightPlace::Point { position: Vec3::new(0.0, 2.5, 0.0) },
        color: Vec3::new(1.0, 0.5, 0.25),
        intensity,
    };
    for text in FORMS {
        let mut it = document(text);
        assert_eq!(it.add_light(&light(3.0)).unwrap(), 0);
        assert_eq!(it.add_light(&light(1.0)).unwrap(), 1);
        check(&it);
        let written = "[[lights]]\npoint = { position = [0, 2.5, 0], color = [1, 0.5, 0.25], intensity = 3 }\n";
        assert!(it.text().contains(written), "{}", it.text());
        // What is meant by a key's absence is not written.
        let last = "[[lights]]\npoint = { position = [0, 2.5, 0], color = [1, 0.5, 0.25] }\n";
        assert!(it.text().contains(last), "{}", it.text());
        let sun = LightPlace::Directional { direction: Vec3::NEG_Y, angle_degrees: 0.5 };
        assert!(it.set_light(1, &LightEntry { place: sun, ..light(2.0) }).unwrap());
        assert_eq!(it.scene().light_entries[1].place, sun);
        assert!(it.text().contains("directional = { direction = [0, -1, 0], angle_degrees = 0.5, "), "{}", it.text());
        assert!(it.set_light(0, &LightEntry { color: Vec3::ONE, ..light(3.0) }).unwrap());
        assert!(it.remove_light(1).unwrap() && it.remove_light(0).unwrap());
        assert_eq!(it.remove_light(0).unwrap_err().to_string(), "there is no light 1: the scene has 0 lights");
        assert_eq!(it.scene(), document(text).scene());
        check(&it);
    }
}

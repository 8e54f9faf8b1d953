//! Every edit on every way to write a scene.

use raggio_scene::{Environment, Filter, Geometry, Medium, Projection, Reflection, Sky, SunPlace, Vec3};

use crate::document::{DOTTED, FORMS, HEADERS, INLINE, ball, check, document, edited, with};

#[test]
fn what_is_equal_changes_nothing() {
    for text in FORMS {
        let mut it = document(text);
        let scene = it.scene().clone();
        assert!(!it.set_camera(&scene.camera).unwrap());
        assert!(!it.set_environment(&scene.environment).unwrap());
        assert!(!it.set_render(&scene.render).unwrap());
        for (index, material) in scene.materials.iter().enumerate() {
            assert!(!it.set_material(index, material).unwrap());
        }
        for (index, shape) in scene.shapes.iter().enumerate() {
            assert!(!it.set_shape(index, &shape.geometry, shape.material).unwrap());
        }
        assert_eq!((it.text(), it.can_undo()), (text, None));
    }
}

#[test]
fn a_camera_keeps_what_stays() {
    for (text, old, new) in [
        (HEADERS, "[0, 1.50,  4]   #", "[0, 1.50,  4.1]   #"),
        (INLINE, "[0, 1.50, 4]", "[0, 1.50, 4.1]"),
        (DOTTED, "[0, 1.50, 4]", "[0, 1.50, 4.1]"),
    ] {
        // The focus follows, as its absence says.
        let after = edited(text, |it| {
            let mut camera = it.scene().camera.clone();
            camera.position.z = 4.1;
            camera.focus_distance = (camera.look_at.as_dvec3() - camera.position.as_dvec3()).length() as f32;
            it.set_camera(&camera).unwrap()
        });
        assert_eq!(after, with(text, old, new));
    }
}

/// The window shows a camera that moves as it is at first, and keeps its keyframes whatever else is edited.
#[test]
fn keyframes_stay_as_they_are() {
    let keyframes = "keyframes = [{ time = 1, position = [5, 1.5, 4] }, { time = 2, position = [6, 1.5, 4] }]";
    let tables = "[[camera.keyframes]] # off\ntime = 1\nposition = [5, 1.5, 4]\n[[camera.keyframes]]\ntime = 2\n\
                  position = [6, 1.5, 4]\n";
    let inline = with(INLINE, "_degrees = 40 }", &format!("_degrees = 40, {keyframes} }}"));
    let headers = with(HEADERS, "_degrees = 40\n", &format!("_degrees = 40\n{tables}"));
    let dotted = with(DOTTED, "_degrees = 40\n", &format!("_degrees = 40\ncamera.{keyframes}\n"));
    for text in [inline, headers, dotted] {
        assert_eq!(document(&text).scene().camera.position, Vec3::new(5.0, 1.5, 4.0));
        let after = edited(&text, |it| {
            let mut camera = it.scene().camera.clone();
            camera.position = Vec3::new(-7.0, 1.0, 2.0);
            camera.projection = Projection::Perspective { vertical_fov_degrees: 30.0 };
            camera.aperture_radius = 0.25;
            let changed = it.set_camera(&camera).unwrap();
            assert_eq!(it.scene().camera.position, Vec3::new(5.0, 1.5, 4.0));
            assert_eq!(it.scene().camera.projection, Projection::Perspective { vertical_fov_degrees: 30.0 });
            assert_eq!(it.scene().camera.aperture_radius, 0.25);
            changed
        });
        let after = edited(&after, |it| it.set_environment(&Environment::Constant(Vec3::ONE)).unwrap());
        for part in ["[5, 1.5, 4]", "[6, 1.5, 4]", "time = 1", "time = 2", "[0, 1.50,", "_degrees = 30"] {
            assert!(after.contains(part), "{part} in\n{after}");
        }
        assert!(!after.contains("-7") && !after.contains("focus_distance"), "{after}");
    }
}

#[test]
fn a_focus_that_stays_is_written_when_the_camera_moves() {
    for (text, old, new) in [
        (HEADERS, "_degrees = 40\n", "_degrees = 40\nfocus_distance = 4.031129\n"),
        (INLINE, "_degrees = 40 }", "_degrees = 40, focus_distance = 4.031129 }"),
        (DOTTED, "_degrees = 40\n", "_degrees = 40\ncamera.focus_distance = 4.031129\n"),
    ] {
        let after = edited(text, |it| {
            let mut camera = it.scene().camera.clone();
            camera.position.x = 1.0;
            it.set_camera(&camera).unwrap()
        });
        let expected = with(text, old, new).replace("[0, 1.50", "[1, 1.50");
        assert_eq!(after, expected);
    }
}

#[test]
fn a_material_gets_and_loses_keys() {
    for (text, old, new) in [
        (
            HEADERS,
            "color = [ 0.8, 0.1, 0.1 ] # blood\n",
            "color = [ 1, 0.1, 0.1 ] # blood\nrefractive_index = 1.5\nreflection = 0.25\npriority = -1\n",
        ),
        (INLINE, "[0.8, 0.1, 0.1] }", "[1, 0.1, 0.1], refractive_index = 1.5, reflection = 0.25, priority = -1 }"),
        (
            DOTTED,
            "color = [0.8, 0.1, 0.1]\n",
            "color = [1, 0.1, 0.1]\nmaterials.red.refractive_index = 1.5\n\
             materials.red.reflection = 0.25\nmaterials.red.priority = -1\n",
        ),
    ] {
        let mut material = document(text).scene().materials[0].clone();
        (material.color.x, material.refractive_index, material.priority) = (1.0, Some(1.5), -1);
        material.reflection = Reflection::Probability(0.25);
        let after = edited(text, |it| it.set_material(0, &material).unwrap());
        assert_eq!(after, with(text, old, new));

        let mut it = document(&after);
        (material.refractive_index, material.reflection, material.priority) = (None, Reflection::Fresnel, 0);
        assert!(it.set_material(0, &material).unwrap());
        assert_eq!(it.scene().materials[0], material);
        assert!(it.text().contains("reflection = \"fresnel\"") && !it.text().contains("refractive_index"));
    }
}

#[test]
fn media_come_change_and_go() {
    let fog = Medium { scattering: Vec3::splat(0.5), absorption: Vec3::new(0.1, 0.2, 0.3), anisotropy: 0.25 };
    let thicker = Medium { scattering: Vec3::new(1.0, 2.0, 3.0), absorption: Vec3::ZERO, ..fog };
    for text in FORMS {
        let mut it = document(text);
        // In a body: beside its refractive index.
        let mut material = it.scene().materials[0].clone();
        (material.refractive_index, material.medium) = (Some(1.5), Some(fog));
        assert!(it.set_material(0, &material).unwrap());
        assert_eq!(it.scene().materials[0], material);
        assert!(
            it.text().contains("{ absorption = [0.1, 0.2, 0.3], scattering = 0.5, anisotropy = 0.25 }"),
            "{}",
            it.text()
        );
        material.medium = Some(thicker);
        assert!(it.set_material(0, &material).unwrap());
        assert_eq!(it.scene().materials[0], material);
        material.medium = None;
        assert!(it.set_material(0, &material).unwrap());
        assert_eq!(it.scene().materials[0], material);

        // In the air.
        for air in [Some(fog), Some(thicker), None] {
            assert!(it.set_air(air.as_ref()).unwrap());
            assert_eq!(it.scene().air, air);
            check(&it);
        }
        assert!(!it.text().contains("air"), "{}", it.text());
    }
    // A table of its own keeps its place and its comments.
    let text = format!("{HEADERS}[materials.mist.medium] # thin\nscattering = 0.5 # a little\nanisotropy = 0.25\n");
    let mut it = document(&text);
    let place = it.scene().materials.iter().position(|material| material.name == "mist").unwrap();
    let mut material = it.scene().materials[place].clone();
    material.medium = Some(Medium { scattering: Vec3::splat(0.75), ..material.medium.unwrap() });
    assert!(it.set_material(place, &material).unwrap());
    assert!(it.text().contains("# thin\nscattering = 0.75 # a little\nanisotropy = 0.25"), "{}", it.text());
}

#[test]
fn a_lamp_without_a_color_keeps_the_old_one() {
    for text in FORMS {
        let mut it = document(text);
        let mut material = it.scene().materials[1].clone();
        material.emission_strength = 2.0;
        assert!(it.set_material(1, &material).unwrap());
        assert_eq!(it.scene().materials[1], material, "{}", it.text());
    }
}

#[test]
fn a_new_material_is_written_like_the_others() {
    for (text, old, new) in [
        (HEADERS, "\"matt white\"]\n", "\"matt white\"]\n\n[materials.red_2]\ncolor = [ 0.8, 0.1, 0.1 ]\n"),
        (INLINE, "\"matt white\" = {} }", "\"matt white\" = {}, red_2 = { color = [0.8, 0.1, 0.1] } }"),
        (DOTTED, "white\" = {}\n", "white\" = {}\nmaterials.red_2 = { color = [0.8, 0.1, 0.1] }\n"),
    ] {
        let after = edited(text, |it| {
            let material = it.scene().materials[0].clone();
            assert_eq!(it.add_material("red", &material).unwrap(), 2);
            assert_eq!(it.scene().materials[2].color, material.color);
            true
        });
        assert_eq!(after, with(text, old, &new.replace("[ 0.8, 0.1, 0.1 ]", "[0.8, 0.1, 0.1]")));
    }
}

#[test]
fn a_shape_moves_and_changes_material() {
    for (text, material) in
        [(HEADERS, "material = \"red\"\n"), (INLINE, "{ material = \"red\""), (DOTTED, "material = \"red\"\n")]
    {
        let after = edited(text, |it| it.set_shape(0, &ball([0.0, 1.25, 0.0], 1.0), 1).unwrap());
        let expected = with(text, "center = [0, 1, 0]", "center = [0, 1.25, 0]");
        assert_eq!(after, with(&expected, material, &material.replace("red", "matt white")));
    }
}

#[test]
fn a_plane_keeps_the_length_of_its_normal() {
    for text in FORMS {
        let Geometry::Plane { normal, .. } = document(text).scene().shapes[1].geometry else { panic!() };
        let plane = Geometry::Plane { point: Vec3::new(0.0, -0.1, 0.0), normal };
        let after = edited(text, |it| it.set_shape(1, &plane, 1).unwrap());
        assert_eq!(after, with(text, "point = [0, 0, 0]", "point = [0, -0.1, 0]"));
    }
}

#[test]
fn a_shape_becomes_another() {
    let size = Vec3::new(1.0, 2.0, 0.5);
    for text in FORMS {
        for rotation_degrees in [Vec3::ZERO, Vec3::new(0.0, 45.0, 0.0)] {
            let cuboid = Geometry::Box { center: Vec3::ZERO, size, rotation_degrees };
            for index in 0..2 {
                let after = edited(text, |it| it.set_shape(index, &cuboid, 0).unwrap());
                let it = document(&after);
                assert_eq!((&it.scene().shapes[index].geometry, it.scene().shapes[index].material), (&cuboid, 0));
                assert_eq!(after.contains("rotation"), rotation_degrees != Vec3::ZERO);
                assert!(after.contains("box = { center = [0, 0, 0], size = [1, 2, 0.5]"), "{after}");
            }
        }
    }
}

#[test]
fn an_environment_comes_and_changes() {
    let gradient = Environment::Gradient { horizon: Vec3::ONE, zenith: Vec3::new(0.5, 0.7, 1.0) };
    let gray = Environment::Constant(Vec3::splat(0.1));
    for text in FORMS {
        let after = edited(text, |it| it.set_environment(&gray).unwrap());
        assert!(after.contains("\n[environment]\ncolor = [0.1, 0.1, 0.1]\n"), "{after}");
        let mut it = document(&after);
        assert!(it.set_environment(&gradient).unwrap());
        assert!(it.text().contains("[environment]\nhorizon = [1, 1, 1]\nzenith = [0.5, 0.7, 1]\n"), "{}", it.text());
        assert!(it.set_environment(&Environment::Constant(Vec3::ZERO)).unwrap());
        assert!(it.text().contains("[environment]\ncolor = [0, 0, 0]\n"), "{}", it.text());
        check(&it);
    }
    let after = edited(HEADERS, |it| it.set_environment(&gray).unwrap());
    assert!(after.contains("degrees = 40\n\n[environment]\ncolor = [0.1, 0.1, 0.1]\n\n# The red one."), "{after}");

    for (own, new) in [
        ("environment = { color = [1, 1, 1] }", "environment = { horizon = [1, 1, 1], zenith = [0.5, 0.7, 1] }"),
        ("environment.color = [1, 1, 1]", "environment.horizon = [1, 1, 1]\nenvironment.zenith = [0.5, 0.7, 1]"),
    ] {
        let text = INLINE.replace("shapes = [", &format!("{own}\nshapes = ["));
        let after = edited(&text, |it| it.set_environment(&gradient).unwrap());
        // The keys are new, so that the order of the root's own may differ.
        assert!(after.contains(new), "{after}");
    }
}

#[test]
fn a_sky_by_day_comes_and_changes() {
    let day = Sky::of(SunPlace::Direction(Vec3::Y));
    for text in FORMS {
        let after = edited(text, |it| it.set_environment(&Environment::Sky(day.clone())).unwrap());
        assert!(after.contains("\n[environment]\nsun_direction = [0, 1, 0]\n"), "{after}");
        let mut it = document(&after);
        let hazy = Sky { turbidity: 5.0, ground_albedo: Vec3::splat(0.5), intensity: 2.0, ..day.clone() };
        assert!(it.set_environment(&Environment::Sky(hazy)).unwrap());
        let keys = "sun_direction = [0, 1, 0]\nturbidity = 5\nground_albedo = [0.5, 0.5, 0.5]\nintensity = 2\n";
        assert!(it.text().contains(keys), "{}", it.text());
        check(&it);
        assert!(it.set_environment(&Environment::Constant(Vec3::ONE)).unwrap());
        assert!(it.text().contains("[environment]\ncolor = [1, 1, 1]\n"), "{}", it.text());
    }
    // A sun that is moved by hand is no longer that of a time.
    let moment =
        "[environment]\nlatitude_degrees = 48\nlongitude_degrees = 16\ntime = 2026-06-21T12:00:00Z\nturbidity = 4\n";
    let after = edited(&format!("{HEADERS}\n{moment}"), |it| {
        let Environment::Sky(sky) = it.scene().environment.clone() else { panic!("a sky") };
        let hand = Sky { sun: SunPlace::Direction(Vec3::Y), ..sky };
        it.set_environment(&Environment::Sky(hand)).unwrap()
    });
    assert!(after.contains("turbidity = 4\nsun_direction = [0, 1, 0]\n") && !after.contains("time"), "{after}");
}

#[test]
fn render_settings_come_and_change() {
    for text in FORMS {
        let mut it = document(text);
        let mut render = it.scene().render.clone();
        (render.samples, render.filter, render.surface_offset) = (16, Filter::Point, false);
        assert!(it.set_render(&render).unwrap());
        let keys = "[render]\nsamples = 16\nfilter = \"point\"\nsurface_offset = false\n";
        assert!(it.text().contains(keys), "{}", it.text());
        render.samples = 256;
        assert!(it.set_render(&render).unwrap());
        assert!(it.text().contains("samples = 256\n"));
        assert_eq!(it.scene().render, render);
        check(&it);
    }
    let after = edited(HEADERS, |it| {
        let render = raggio_scene::RenderSettings { seed: 7, ..it.scene().render.clone() };
        it.set_render(&render).unwrap()
    });
    assert!(after.starts_with("# A scene.\nversion = 1\n\n[render]\nseed = 7\n\n[camera] # where from\n"), "{after}");
}

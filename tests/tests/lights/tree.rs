//! Frequency with which the light tree chooses lights: as often as they say.

use raggio_render::{DeviceScene, Probe, Question};
use raggio_scene::{LightKind, Scene};
use raggio_tests::statistics::{Verdict, chi_square};
use raggio_tests::{Pcg, for_each_device, parse};

use crate::lights::{add_light, sky};

/// Scene of spheres, rectangles, spots, points and far lights of very different brightness.
fn motley(count: usize) -> Scene {
    let mut random = Pcg::new(11);
    let mut text = String::from("[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n");
    for i in 0..count {
        let [x, y, z] = random.in_cube(4.0).to_array();
        let strength = random.log_between(0.01, 100.0);
        text += &format!("[materials.m{i}]\nemission_strength = {strength}\n[[shapes]]\nmaterial = \"m{i}\"\n");
        text += &match i % 2 {
            0 => format!("sphere = {{ center = [{x}, {y}, {z}], radius = {} }}\n", random.log_between(0.01, 0.3)),
            _ => format!("rectangle = {{ corner = [{x}, {y}, {z}], edge_u = [0.3, 0, 0], edge_v = [0, 0.1, 0.2] }}\n"),
        };
    }
    let mut scene = parse(&text);
    for _ in 0..count / 4 {
        let (position, direction) = (random.in_cube(4.0).to_array(), random.direction().to_array());
        add_light(&mut scene, LightKind::Point, position, direction, [1.0; 3]);
        add_light(&mut scene, LightKind::Spot { inner: 0.2, outer: 0.6 }, position, direction, [3.0; 3]);
    }
    add_light(&mut scene, LightKind::Directional, [0.0; 3], [1.0, -2.0, 0.5], [0.3; 3]);
    add_light(&mut scene, LightKind::Directional, [0.0; 3], [-1.0, -2.0, 0.5], [0.01; 3]);
    add_light(&mut scene, LightKind::Sun { half_angle: 0.3 }, [0.0; 3], [0.2, -1.0, 0.9], [0.5; 3]);
    scene.environment = sky(8, 4, |x, y| [(x * y) as f32 * 0.01; 3]);
    scene
}

#[test]
fn lights_are_chosen_as_often_as_they_say() {
    let scene = DeviceScene::new(&motley(64)).expect("the scene fits devices");
    let lights = scene.buffers.emitters.len();
    assert_eq!(lights, 64 + 32 + 3 + 1);
    for_each_device(|device| {
        let mut verdict = Verdict::default();
        let mut random = Pcg::new(5);
        for _ in 0..device.pick(24, 6) {
            let (position, normal) = (random.in_cube(5.0).as_vec3(), random.direction().as_vec3());
            let side = (random.bits() & 1) as f32;
            let mut ask = |emitter: usize| -> Question {
                let u = random.unit();
                [
                    position.extend(side).to_array(),
                    normal.extend(u).to_array(),
                    [f32::from_bits(emitter as u32), 0.0, 0.0, 0.0],
                ]
            };
            let count = 40_000;
            let questions: Vec<_> = (0..count).map(|i| ask(i % lights)).collect();
            let answers = device.ask_in(&scene, Probe::ChooseLight, &questions);
            let mut probability: Vec<f64> = answers[..lights].iter().map(|a| f64::from(a[0][0])).collect();
            // Bounds are generous: a branch may turn out to hold nothing that shines here.
            let sum: f64 = probability.iter().sum();
            assert!(sum > 0.1 && sum < 1.0 + 1e-5, "{}: the probabilities add up to {sum}", device.label);
            probability.push((1.0 - sum).max(0.0));

            let mut counts = vec![0; lights + 1];
            for [_, [chosen, claimed, ..], _] in &answers {
                let chosen = (chosen.to_bits() as usize).min(lights);
                counts[chosen] += 1;
                if chosen == lights {
                    assert_eq!(*claimed, 0.0);
                    continue;
                }
                let relative = f64::from(*claimed) / probability[chosen] - 1.0;
                assert!(relative.abs() < 1e-5, "{}: two ways to a probability differ by {relative}", device.label);
            }
            let expected: Vec<f64> = probability.iter().map(|p| p * count as f64).collect();
            verdict.add(format!("{} at {position}", device.label), chi_square(&counts, &expected));
        }
        println!("{}: least p {:.2e}", device.label, verdict.least());
        verdict.assert_all();
    });
}

/// Lights that are nearer, face the point or are brighter are more probable.
#[test]
fn likely_lights_matter() {
    let lamp = |at: f64, z: f64| {
        format!("[[shapes]]\nmaterial = \"lamp\"\nsphere = {{ center = [{at}, 1, {z}], radius = 0.1 }}\n")
    };
    let flat = "[[shapes]]\nmaterial = \"lamp\"\nrectangle = { corner = [-1, 1, 5], edge_u = [0.2, 0, 0], edge_v = [0, 0.2, 0] }\n";
    let text = "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nvertical_fov_degrees = 40\n
        [materials.lamp]\nemission_strength = 1\n";
    let beneath = "[[shapes]]\nmaterial = \"lamp\"\nsphere = { center = [0, -1, 0], radius = 0.1 }\n";
    let scene = parse(&[text, &lamp(0.0, 0.0), &lamp(10.0, 0.0), &lamp(0.0, 3.0), flat, beneath].concat());
    let scene = DeviceScene::new(&scene).expect("the scene fits devices");
    let place =
        |shape: u32| scene.shape_of_place.iter().position(|s| *s == shape).expect("a shape of the scene") as u32;
    let emitter = |shape: u32| scene.buffers.order[place(shape) as usize].first_emitter;
    for_each_device(|device| {
        let questions = [0, 1, 2, 3, 4]
            .map(|shape| [[0.0; 4], [0.0, 1.0, 0.0, 0.5], [f32::from_bits(emitter(shape)), 0.0, 0.0, 0.0]]);
        let p: Vec<f32> = device.ask_in(&scene, Probe::ChooseLight, &questions).iter().map(|a| a[0][0]).collect();
        assert!(p[0] > 5.0 * p[2] && p[2] > 5.0 * p[1] && p[1] > 0.0, "{}: {p:?}", device.label);
        assert_eq!(p[4], 0.0, "{}: a lamp beneath the surface", device.label);
    });
}

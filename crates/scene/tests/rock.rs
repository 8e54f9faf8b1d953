//! The mesh that speed is measured with.

use std::collections::HashMap;

use raggio_scene::{Geometry, Scene};

#[test]
fn rocks_are_closed_and_as_fine_as_asked() {
    for (level, triangles) in [(0, 20), (1, 80), (4, 5120)] {
        let scene = Scene::rock(level);
        let [shape] = &scene.shapes[..] else { panic!("expected one shape, found {}", scene.shapes.len()) };
        let Geometry::Mesh { mesh, .. } = &shape.geometry else { panic!("expected a mesh") };
        assert_eq!(mesh.triangles.len(), triangles + 2);

        // Without the ground, each edge is walked once in each direction.
        let mut edges = HashMap::new();
        for &[a, b, c] in &mesh.triangles[..triangles] {
            for edge in [[a, b], [b, c], [c, a]] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|(&[a, b], &times)| times == 1 && edges.contains_key(&[b, a])), "level {level}");
        assert_eq!(edges.len(), 3 * triangles);
        let highest = mesh.positions.iter().map(|position| position[1]).fold(0.0, f32::max);
        assert!((1.7..2.2).contains(&highest), "level {level} ends at a height of {highest}");
    }
}

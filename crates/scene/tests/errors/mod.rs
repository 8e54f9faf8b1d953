//! Messages that answer every mistake in a scene file, word for word.

mod camera;
mod colors;
mod environment;
mod foreign;
mod groups;
mod keyframes;
mod keys;
mod lights;
mod materials;
mod meshes;
mod principled;
mod render;
mod several;
mod shapes;
mod syntax;
mod types;

use raggio_scene::Scene;

/// Case of a mistake: name, text of the file, message of the error.
pub type Case = (&'static str, &'static str, &'static str);

fn check(cases: &[Case]) {
    let mut failures = Vec::new();
    for (name, text, expected) in cases {
        let message = match Scene::parse(text, "scene.toml") {
            Ok(_) => "no error".to_string(),
            Err(error) => error.to_string(),
        };
        if message != *expected {
            failures.push(format!("{name}\n  expected {expected}\n  found    {message}"));
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

macro_rules! tables {
    ($($table:ident)*) => {$(
        #[test]
        fn $table() {
            check($table::CASES);
        }
    )*};
}

// The tests have the names of the tables' modules, which live in another namespace.
tables! { syntax several keys foreign types render camera colors keyframes environment lights materials principled shapes groups meshes }

//! The JSON Schema says what the reader does.

use crate::assets::files::Folder;
use crate::common::{EXAMPLE, assert_written, project_file, reference_scene};
use raggio_scene::{Assets, Scene};
use serde_json::{Value, json};

fn schema() -> Value {
    serde_json::from_str(&raggio_scene::schema()).unwrap()
}

fn json_of(toml_text: &str) -> Value {
    value(&toml::de::DeTable::parse(toml_text).map(|it| toml::de::DeValue::Table(it.into_inner())).unwrap())
}

fn value(node: &toml::de::DeValue<'_>) -> Value {
    use toml::de::DeValue;
    match node {
        DeValue::String(text) => json!(text),
        DeValue::Integer(number) => json!(number.as_str().parse::<i64>().unwrap()),
        DeValue::Float(number) => json!(number.as_str().parse::<f64>().unwrap()),
        DeValue::Boolean(truth) => json!(truth),
        DeValue::Datetime(date) => json!(date.to_string()),
        DeValue::Array(array) => array.iter().map(|it| value(it.get_ref())).collect(),
        DeValue::Table(table) => {
            let entries = table.iter();
            entries.map(|(key, it)| (key.get_ref().to_string(), value(it.get_ref()))).collect()
        }
    }
}

#[test]
fn it_is_a_schema_and_introduces_itself() {
    let schema = schema();
    assert!(jsonschema::meta::is_valid(&schema));
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["title"], "raggio scene");
    assert!(schema["description"].as_str().unwrap().starts_with("A scene for raggio"));
    assert_eq!(schema.get("$id"), None);
    assert!(!raggio_scene::schema().contains("null"));
}

#[test]
fn the_shipped_one_is_up_to_date() {
    assert_written("docs/scene.schema.json", &raggio_scene::schema());
}

#[test]
fn it_accepts_what_the_reader_accepts() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    validator.validate(&json_of(EXAMPLE)).unwrap();
    for name in ["cornell", "lamp", "nested", "spheres", "weekend"] {
        let text = std::fs::read_to_string(reference_scene(name)).unwrap();
        validator.validate(&json_of(&text)).unwrap();
    }
    let changed = EXAMPLE
        .replace("\"fresnel\"", "0.5")
        .replace("color = [0.7, 0.8, 1.0]", "horizon = \"#fff\"\nzenith = { srgb = [0, 0, 1] }")
        .replace("base_color = [0.8, 0.1, 0.1]", "base_color = \"#Ff8800\"");
    validator.validate(&json_of(&changed)).unwrap();
    let keyframes = "[camera]\ninterpolation = \"linear\"\nkeyframes = [{ time = 1, position = [0, 1, 3] }, \
                     { time = 2, look_at = [0, 1, 0], vertical_fov_degrees = 20, aperture_radius = 0, focus_distance = 1 }]";
    let moving = EXAMPLE.replace("[camera]", keyframes);
    validator.validate(&json_of(&moving)).unwrap();
    Scene::parse(&moving, "scene.toml").unwrap();
}

#[test]
fn it_accepts_every_projection() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    for keys in [
        "orthographic_height = 2",
        "intrinsics = { focal = [50, 60], size = [40, 30] }",
        "intrinsics = { focal = [50, 60], principal_point = [-3, 15.5], skew = 0.5, size = [40, 30] }",
        "panorama = \"latitude-longitude\"",
    ] {
        let mut text = EXAMPLE.replacen("vertical_fov_degrees = 40", keys, 1);
        if keys.starts_with("panorama") {
            let lines = text.lines().filter(|line| !line.starts_with("focus_distance"));
            text = lines.map(|line| format!("{line}\n")).collect();
        }
        validator.validate(&json_of(&text)).unwrap();
        Scene::parse(&text, "scene.toml").unwrap();
    }
}

/// Keys that name files are accepted: a schema knows nothing of files.
#[test]
fn it_accepts_what_names_files() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    for (from, to) in [
        ("color = [0.7, 0.8, 1.0]", "image = \"sky.hdr\"\nrotation_degrees = -90\nintensity = 2"),
        ("normal_scale = 2\n", "normal_map = \"a.png\"\n"),
        ("normal_scale = 2\n", "normal_map = { image = \"a.png\", uv_set = 1, wrap = \"clamp_to_edge\" }\n"),
        (
            "normal_scale = 2\n",
            "normal_map = { image = \"a.png\", offset = [0, 1], rotation_degrees = 90, scale = [2, -1], \
             wrap = [\"repeat\", \"mirrored_repeat\"], filter = \"nearest\" }\n",
        ),
        ("sphere = { center = [0, 1, 0], radius = 1 }", "mesh = { file = \"a.ply\", scale = -1 }"),
        (
            "material = \"glass\"\nsphere = { center = [0, 1, 0], radius = 1 }",
            "mesh = { file = \"a.glb\", translation = [1, 2, 3], rotation_degrees = [0, 90, 0], scale = [1, 2, 3], time = 0.5 }",
        ),
    ] {
        let text = EXAMPLE.replacen(from, to, 1);
        assert_ne!(text, EXAMPLE, "{from}");
        validator.validate(&json_of(&text)).unwrap();
        let error = raggio_scene::Scene::parse(&text, "scene.toml").unwrap_err();
        assert!(error.message.ends_with(": there is no such file"), "{error}");
    }
}

/// Replacements in the example, each of which the reader refuses too.
const WRONG: &[(&str, &str)] = &[
    ("version = 1", "version = 2"),
    ("[camera]", "[camera]\ninterpolation = \"linear\""),
    ("[camera]", "[camera]\nkeyframes = [{ position = [0, 1, 3] }]"),
    ("[camera]", "[camera]\nkeyframes = [{ time = 0, position = [0, 1] }]"),
    ("[camera]", "[camera]\nkeyframes = [{ time = 0, up = [0, 1] }]"),
    ("[camera]", "[camera]\nkeyframes = [{ time = -1, position = [0, 1, 3] }]"),
    ("[camera]", "[camera]\nkeyframes = { time = 0, position = [0, 1, 3] }"),
    ("version = 1", ""),
    ("width = 1280", "width = 0"),
    ("width = 1280", "width = 1.5"),
    ("width = 1280", "widht = 1280"),
    ("filter = \"box\"", "filter = \"gauss\""),
    ("vertical_fov_degrees = 40", "vertical_fov_degrees = 180"),
    ("vertical_fov_degrees = 40", ""),
    ("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\northographic_height = 2"),
    ("vertical_fov_degrees = 40", "vertical_fov_degrees = 40\npanorama = \"latitude-longitude\""),
    ("vertical_fov_degrees = 40", "panorama = \"fisheye\""),
    // The example has the distance of its focus.
    ("vertical_fov_degrees = 40", "panorama = \"latitude-longitude\""),
    ("vertical_fov_degrees = 40", "intrinsics = { focal = [50, 50] }"),
    ("vertical_fov_degrees = 40", "intrinsics = { focal = [50, 0], size = [40, 30] }"),
    ("vertical_fov_degrees = 40", "orthographic_height = 0"),
    ("position = [0, 1, 4]", "position = [0, 1]"),
    ("position = [0, 1, 4]", ""),
    ("[environment]\ncolor = [0.7, 0.8, 1.0]", "[environment]"),
    ("color = [0.7, 0.8, 1.0]", "horizon = [1, 1, 1]"),
    ("color = [0.7, 0.8, 1.0]", "color = [1, 1, 1]\nhorizon = [1, 1, 1]"),
    ("color = [1, 1, 1]\nemission", "color = [1, 1, 2]\nemission"),
    ("color = [1, 1, 1]\nemission", "color = \"red\"\nemission"),
    ("color = [1, 1, 1]\nemission", "color = \"#ff880\"\nemission"),
    ("color = [1, 1, 1]\nemission", "color = { srgb = [255, 0, 0] }\nemission"),
    ("color = [1, 1, 1]\nemission", "color = { rgb = [1, 0, 0] }\nemission"),
    ("color = [1, 1, 1]\nemission", "color = [1, 0]\nemission"),
    ("emission_strength = 0", "emission_strength = -1"),
    ("smoothness = 1", "smoothness = 2"),
    ("refractive_index = 1.5", "refractive_index = 0"),
    ("reflection = \"fresnel\"", "reflection = \"fresnal\""),
    ("reflection = \"fresnel\"", "reflection = 2"),
    ("priority = 0", "priority = 0.5"),
    ("radius = 1", "radius = 0"),
    ("sphere = { center = [0, 1, 0], radius = 1 }", ""),
    ("size = [1, 2, 3]", "size = [1, 0, 3]"),
    ("capped = false", "capped = 0"),
    ("top_radius = 0.25", "top_radius = -0.25"),
    ("top = [0, 3, 0], ", ""),
    ("[[shapes]]\nmaterial = \"glass\"", "[[shapes]]"),
    ("point = { position = [0, 3, 0], ", "point = { "),
    ("point = {", "spot = { position = [0, 0, 0], direction = [0, 0, 1] }\npoint = {"),
    ("[[lights]]\npoint = { position = [0, 3, 0], color = [1, 0.9, 0.8], intensity = 4 }", "[[lights]]"),
    ("outer_degrees = 20", "outer_degrees = 91"),
    ("angle_degrees = 0.5", "angle_degrees = 0.005"),
    ("angle_degrees = 0.5", "angle_degrees = 181"),
    ("intensity = 3", "intensity = -1"),
    ("ior = 1.4", "ior = 0.5"),
    ("metallic = 0.25", "metallic = 1.25"),
    ("alpha_mode = \"mask\"", "alpha_mode = \"cut\""),
    ("roughness = 0.5", "rughness = 0.5"),
    ("thin_walled = true", "thin_walled = 1"),
    ("[materials.lacquer.principled]", "[materials.lacquer]\nsmoothness = 1\n[materials.lacquer.principled]"),
    ("normal_scale = 2\n", "normal_map = 2\n"),
    ("normal_scale = 2\n", "normal_map = { uv_set = 1 }\n"),
    ("normal_scale = 2\n", "normal_map = { image = \"a.png\", uv_set = 2 }\n"),
    ("normal_scale = 2\n", "normal_map = { image = \"a.png\", wrap = [\"repeat\"] }\n"),
    ("color = [0.7, 0.8, 1.0]", "color = [1, 1, 1]\nintensity = 2"),
    ("color = [0.7, 0.8, 1.0]", "color = [1, 1, 1]\nimage = \"a.hdr\""),
    ("sphere = { center = [0, 1, 0], radius = 1 }", "mesh = {}"),
    ("sphere = { center = [0, 1, 0], radius = 1 }", "mesh = { file = \"a.ply\", time = -1 }"),
    ("sphere = {", "plane = { point = [0, 0, 0], normal = [0, 1, 0] }\nsphere = {"),
];

#[test]
fn it_refuses_what_the_reader_refuses() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    for (right, wrong) in WRONG {
        let text = EXAMPLE.replacen(right, wrong, 1);
        assert_ne!(text, EXAMPLE, "{right}");
        assert!(raggio_scene::Scene::parse(&text, "scene.toml").is_err(), "{wrong}");
        assert!(!validator.is_valid(&json_of(&text)), "{wrong}");
    }
}

#[test]
fn every_key_is_in_it_with_a_description() {
    let schema = schema();
    let mut keys: Vec<String> = Vec::new();
    let definitions = schema["$defs"].as_object().unwrap().values();
    for table in definitions.chain([&schema]) {
        for (key, property) in table["properties"].as_object().into_iter().flatten() {
            assert!(property["description"].is_string(), "{key}: {property}");
            keys.push(key.clone());
        }
    }
    let words = "version render camera environment lights materials shapes point spot directional direction inner_degrees \
                 outer_degrees angle_degrees width height samples max_depth \
                 seed filter surface_offset position look_at up vertical_fov_degrees \
                 orthographic_height panorama intrinsics focal principal_point skew \
                 aperture_radius focus_distance color horizon zenith image rotation_degrees \
                 intensity emission_color emission_strength smoothness refractive_index reflection \
                 priority material sphere plane rectangle disk cylinder cone base top top_radius capped box mesh center radius point normal \
                 corner edge_u edge_v size file translation scale time principled base_color \
                 base_color_texture alpha alpha_mode alpha_cutoff metallic roughness \
                 metallic_roughness_texture ior specular specular_texture specular_color \
                 specular_color_texture transmission transmission_texture thin_walled \
                 attenuation_color attenuation_distance dispersion diffuse_transmission \
                 diffuse_transmission_texture diffuse_transmission_color \
                 diffuse_transmission_color_texture clearcoat clearcoat_texture \
                 clearcoat_roughness clearcoat_roughness_texture clearcoat_normal_map \
                 clearcoat_normal_scale sheen_color sheen_color_texture sheen_roughness \
                 sheen_roughness_texture anisotropy anisotropy_rotation anisotropy_texture \
                 iridescence iridescence_texture iridescence_ior iridescence_thickness_minimum \
                 iridescence_thickness_maximum iridescence_thickness_texture emissive \
                 emissive_texture emissive_strength normal_map normal_scale uv_set offset wrap \
                 filter";
    for key in words.split_whitespace() {
        assert!(keys.iter().any(|it| it == key), "{key}");
    }
}

/// Keys of a table of the schema with their defaults, as lines of TOML; `except` have none that may stand there.
fn defaults(table: &str, except: &[&str]) -> Vec<String> {
    let schema = schema();
    let properties = schema["$defs"][table]["properties"].as_object().unwrap();
    let with_default = properties.iter().filter_map(|(key, property)| Some((key, property.get("default")?)));
    with_default.filter(|(key, _)| !except.contains(&key.as_str())).map(|(key, it)| format!("{key} = {it}")).collect()
}

/// Scenes with each table twice: without the keys that have defaults, and with the defaults that the schema names.
#[test]
fn its_defaults_are_those_of_the_reader() {
    let folder = Folder::new();
    let camera = "position = [0, 1, 4]\nlook_at = [0, 1, 0]\nvertical_fov_degrees = 40";
    let scene = |tables: &str| {
        let camera = if tables.contains("[camera]") { String::new() } else { format!("[camera]\n{camera}\n") };
        let text = format!("version = 1\n{camera}{tables}\n");
        let scene = raggio_scene::Scene::parse_with(&text, &folder.path("scene.toml"), &mut Assets::default());
        Scene { warnings: vec![], ..scene.unwrap_or_else(|error| panic!("{error}\nin\n{text}")) }
    };
    let lines = |start: &str, defaults: Vec<String>| {
        assert!(!defaults.is_empty());
        assert_eq!(scene(start), scene(&format!("{start}\n{}", defaults.join("\n"))), "{start}");
    };
    let inline = |start: &str, defaults: Vec<String>| {
        assert!(!defaults.is_empty());
        assert_eq!(scene(&format!("{start} }}")), scene(&format!("{start}, {} }}", defaults.join(", "))), "{start}");
    };
    lines("[render]", defaults("Render", &[]));
    lines(&format!("[camera]\n{camera}"), defaults("Camera", &["interpolation"]));
    let of_skies = ["turbidity", "ground_albedo", "sun_intensity"];
    lines("[environment]\nimage = \"pixel.hdr\"", defaults("Environment", &of_skies));
    lines("[environment]\nsun_direction = [1, 1, 1]", defaults("Environment", &[]));
    for (kind, table, required) in [
        ("point", "Point", "position = [0, 1, 0]"),
        ("spot", "Spot", "position = [0, 1, 0], direction = [0, -1, 0]"),
        ("directional", "Directional", "direction = [0, -1, 0]"),
    ] {
        inline(&format!("[[lights]]\n{kind} = {{ {required}"), defaults(table, &[]));
    }
    lines("[materials.a]", defaults("Material", &[]));
    lines("[materials.a.principled]", defaults("Principled", &[]));
    lines("[materials.a.principled]\nalpha_mode = \"mask\"", defaults("Principled", &["alpha_mode"]));
    inline("[materials.a.principled]\nnormal_map = { image = \"pixel.hdr\"", defaults("TextureTable", &[]));
    inline(
        "[materials.a]\n[[shapes]]\nmaterial = \"a\"\nbox = { center = [0, 0, 0], size = [1, 2, 3]",
        defaults("Box", &[]),
    );
    for (kind, table) in [("cylinder", "Cylinder"), ("cone", "Cone")] {
        let shape = format!("{kind} = {{ base = [0, 0, 0], top = [0, 1, 0], radius = 1");
        inline(&format!("[materials.a]\n[[shapes]]\nmaterial = \"a\"\n{shape}"), defaults(table, &[]));
    }
    inline("[materials.a]\n[[shapes]]\nmaterial = \"a\"\nmesh = { file = \"triangle.ply\"", defaults("Mesh", &[]));
}

/// Every key of the principled material that is no texture and may be absent has a default, but for the one distance that
/// is endless without it.
#[test]
fn principled_keys_have_defaults() {
    let schema = schema();
    let properties = schema["$defs"]["Principled"]["properties"].as_object().unwrap();
    let bare = properties.iter().filter(|(_, it)| it.get("default").is_none() && it["$ref"] != "#/$defs/Texture");
    assert_eq!(bare.map(|(key, _)| key.as_str()).collect::<Vec<_>>(), ["attenuation_distance"]);
}

/// Editors find the schema by the first line of each scene, which the schema accepts.
#[test]
fn shipped_scenes_name_it() {
    let validator = jsonschema::validator_for(&schema()).unwrap();
    let mut count = 0;
    for folder in ["scenes", "scenes/guide", "scenes/notes", "scenes/reference"] {
        for entry in std::fs::read_dir(project_file(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "toml") {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let schema = text.lines().next().unwrap().strip_prefix("#:schema ").unwrap_or_else(|| panic!("{path:?}"));
            let named = path.with_file_name(schema).canonicalize().unwrap();
            assert_eq!(named, project_file("docs/scene.schema.json").canonicalize().unwrap());
            validator.validate(&json_of(&text)).unwrap();
            count += 1;
        }
    }
    assert!(count > 25, "{count}");
}

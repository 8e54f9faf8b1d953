//! docs/scene.md says what the schema says, and its examples are scenes.

use std::collections::BTreeSet;
use std::fs;

use crate::common::{assert_written, project_file};
use raggio_scene::Scene;
use serde_json::Value;

const PAGE: &str = "docs/scene.md";
const BEGIN: &str = "<!-- keys of ";
const END: &str = "<!-- end -->";

fn schema() -> Value {
    serde_json::from_str(&raggio_scene::schema()).unwrap()
}

fn page() -> String {
    fs::read_to_string(project_file(PAGE)).unwrap()
}

/// Tables of the schema that have keys, by their names.
fn tables(schema: &Value) -> Vec<(&str, &Value)> {
    let named = schema["$defs"].as_object().unwrap().iter().map(|(name, table)| (name.as_str(), table));
    std::iter::once(("the scene", schema)).chain(named).filter(|(_, table)| table["properties"].is_object()).collect()
}

/// Rows of a table of Markdown, one for each key.
fn rows(schema: &Value, table: &Value) -> String {
    let required = table["required"].as_array().into_iter().flatten().collect::<Vec<_>>();
    let rows = table["properties"].as_object().unwrap().iter().map(|(key, property)| {
        let default = match &property["default"] {
            _ if required.contains(&&Value::from(key.as_str())) => "required".to_string(),
            Value::Null | Value::Object(_) => "none".to_string(),
            default => format!("`{}`", short(default)),
        };
        let description = property["description"].as_str().unwrap().replace('\n', " ").replace('|', "\\|");
        let unit = unit(key, property).map_or(String::new(), |unit| format!(" ({unit})"));
        format!("| `{key}` | {}{unit} | {default} | {description} |\n", kind(schema, property))
    });
    format!("| key | value | default | |\n|---|---|---|---|\n{}", rows.collect::<String>())
}

/// Unit of the numbers of a key.
fn unit(key: &str, property: &Value) -> Option<&'static str> {
    match key {
        "width" | "height" | "focal" | "principal_point" | "skew" => Some("pixels"),
        "size" if property["items"]["type"] == "integer" => Some("pixels"),
        "time" => Some("seconds"),
        "anisotropy_rotation" => Some("degrees"),
        _ if key.ends_with("_degrees") => Some("degrees"),
        "iridescence_thickness_minimum" | "iridescence_thickness_maximum" => Some("nanometres"),
        "horizon" | "zenith" | "clamp" => Some("radiance"),
        "position"
        | "look_at"
        | "aperture_radius"
        | "focus_distance"
        | "attenuation_distance"
        | "center"
        | "radius"
        | "point"
        | "corner"
        | "edge_u"
        | "edge_v"
        | "size"
        | "translation" => Some("lengths"),
        _ => None,
    }
}

/// Value without a fraction of zero: `[1, 1, 1]` for `[1.0, 1.0, 1.0]`.
fn short(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(short).collect::<Vec<_>>().join(", ")),
        Value::Number(number) => number.as_f64().unwrap().to_string(),
        other => other.to_string(),
    }
}

/// Values that a schema allows, in words.
fn kind(schema: &Value, value: &Value) -> String {
    if let Some(name) = value["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/")) {
        return match (name, heading(name)) {
            ("Color", _) => "[colour](#colours), 0 to 1".to_string(),
            ("Radiance", _) => "[colour](#colours), 0 to 1e9".to_string(),
            (_, Some(heading)) => format!("[table]({heading})"),
            _ => kind(schema, &schema["$defs"][name]),
        };
    }
    if let Some(only) = value.get("const") {
        return format!("`{only}`");
    }
    for choice in ["anyOf", "oneOf"] {
        if let Some(kinds) = value[choice].as_array() {
            let kinds: Vec<String> = kinds.iter().map(|it| kind(schema, it)).collect();
            return kinds.join(" or ");
        }
    }
    match value["type"].as_str() {
        Some("array") if value["items"]["$ref"].is_string() && value.get("minItems").is_none() => {
            format!("list of {}", kind(schema, &value["items"]).replacen("[table]", "[tables]", 1))
        }
        Some("array") if value["maxItems"] != value["minItems"] => {
            let [least, most] = ["minItems", "maxItems"].map(|key| value[key].as_u64().unwrap());
            format!("{least} to {most} times {}", kind(schema, &value["items"]))
        }
        Some("array") => match (value["minItems"].as_u64().unwrap(), kind(schema, &value["items"])) {
            (count, kind) if kind.starts_with("number") => kind.replacen("number", &format!("{count} numbers"), 1),
            (count, kind) if kind.starts_with("whole number") => {
                kind.replacen("whole number", &format!("{count} whole numbers"), 1)
            }
            (count, _) => format!("{count} of these"),
        },
        Some("object") => kind(schema, &value["additionalProperties"]).replacen("[table]", "[tables]", 1) + " by name",
        Some("boolean") => "`true` or `false`".to_string(),
        Some("string") => "text".to_string(),
        Some("integer") => format!("whole number, {}", range(value)),
        Some("number") => match range(value).as_str() {
            "-1000000000000000 to 1000000000000000" => "number".to_string(),
            "0.000000000000001 to 1000000000000000" => "number, greater than 0".to_string(),
            "0 to 1000000000000000" => "number, 0 or more".to_string(),
            "0 to 1000000000" => "number, 0 to 1e9".to_string(),
            "0.001 to 1000000000" => "number, 0.001 to 1e9".to_string(),
            "-1000000000 to 1000000000" => "number, -1e9 to 1e9".to_string(),
            range => format!("number, {range}"),
        },
        other => panic!("a value of type {other:?}"),
    }
}

fn range(value: &Value) -> String {
    format!("{} to {}", short(&value["minimum"]), short(&value["maximum"]))
}

/// Heading below which the page explains a table, as a link.
fn heading(table: &str) -> Option<String> {
    let word = table.to_lowercase();
    match table {
        "Material" => Some("#materialsname".to_string()),
        "Shape" => Some("#shapes".to_string()),
        "Transform" => Some("#transform".to_string()),
        "Light" => Some("#lights".to_string()),
        "Keyframe" => Some("#camerakeyframes".to_string()),
        "TextureTable" => Some("#textures".to_string()),
        _ if ["[", ""].iter().any(|bracket| page().contains(&format!("## `{bracket}{word}"))) => {
            Some(format!("#{word}"))
        }
        _ => None,
    }
}

#[test]
fn the_tables_are_those_of_the_schema() {
    let schema = schema();
    let page = page();
    let mut parts = page.split(BEGIN);
    let mut expected = parts.next().unwrap().to_string();
    let mut explained = Vec::new();
    for part in parts {
        let (name, rest) = part.split_once(" -->").unwrap();
        let (_, rest) = rest.split_once(END).unwrap();
        let tables = tables(&schema);
        let (name, table) = tables.iter().find(|(table, _)| *table == name).unwrap();
        expected += &format!("{BEGIN}{name} -->\n\n{}\n{END}{rest}", rows(&schema, table));
        explained.push(name.to_string());
    }
    for (name, _) in tables(&schema) {
        assert_eq!(explained.iter().filter(|it| *it == name).count(), 1, "{name} is to be explained once");
    }
    assert_written(PAGE, &expected);
}

/// Texts of the page in fences, and the page without them.
fn examples_and_prose() -> (Vec<String>, String) {
    let page = page();
    let parts = page.split("```");
    let (mut examples, mut prose) = (Vec::new(), String::new());
    for (place, part) in parts.enumerate() {
        match part.strip_prefix("toml\n") {
            Some(example) if place % 2 == 1 => examples.push(example.to_string()),
            _ => prose += part,
        }
    }
    (examples, prose)
}

#[test]
fn its_examples_are_right() {
    let (examples, _) = examples_and_prose();
    assert!(examples.len() > 10);
    for example in examples {
        let mut text = String::new();
        for (given, line) in [
            ("version", "version = 1\n"),
            ("[camera]", "camera = { position = [0, 1, 4], look_at = [0, 1, 0], vertical_fov_degrees = 40 }\n"),
            ("[materials.clay]", "materials.clay = {}\n"),
        ] {
            text += if example.contains(given) { "" } else { line };
        }
        text += &example;
        match Scene::parse(&text, "example") {
            Ok(scene) => {
                assert!(!scene.warnings.iter().any(|it| !it.contains("nothing in the scene shines")), "{scene:?}")
            }
            // The files that examples name are nobody's.
            Err(error) => {
                let lines = error.to_string();
                assert!(lines.lines().all(|line| line.ends_with(": there is no such file")), "{lines}\nin\n{text}");
            }
        }
    }
}

/// Every word in backquotes that could be a key or a value of one is.
#[test]
fn its_keys_exist() {
    fn gather(value: &Value, words: &mut BTreeSet<String>) {
        match value {
            Value::Object(entries) => {
                words.extend(
                    entries
                        .get("properties")
                        .and_then(Value::as_object)
                        .into_iter()
                        .flatten()
                        .map(|(key, _)| key.clone()),
                );
                words.extend(entries.get("const").and_then(Value::as_str).map(str::to_string));
                entries.values().for_each(|it| gather(it, words));
            }
            Value::Array(items) => items.iter().for_each(|it| gather(it, words)),
            _ => {}
        }
    }
    let mut words = BTreeSet::from(["true".to_string(), "false".to_string()]);
    gather(&schema(), &mut words);
    let (_, prose) = examples_and_prose();
    let quoted = prose.split('`').skip(1).step_by(2);
    let like_keys = quoted.filter(|it| it.chars().all(|c| c.is_ascii_lowercase() || c == '_'));
    let unknown: Vec<&str> = like_keys.filter(|word| !words.contains(*word)).collect();
    assert_eq!(unknown, [""; 0]);
}

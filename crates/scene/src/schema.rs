//! The JSON Schema of the scene file, for editors that complete and check while one types.

use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::Value;

use crate::file::SceneFile;

/// The JSON Schema (draft 2020-12) of the scene file, as indented JSON.
pub fn schema() -> String {
    let settings = SchemaSettings::draft2020_12().with_transform(WithoutNull);
    let schema = SchemaGenerator::new(settings).into_root_schema_for::<SceneFile>();
    format!("{:#}\n", schema.to_value())
}

/// Keys of a table of the scene file.
pub(crate) fn keys<T: JsonSchema>() -> Vec<String> {
    let table = T::json_schema(&mut SchemaGenerator::default());
    let properties = table.get("properties").and_then(Value::as_object);
    properties.map(|properties| properties.keys().cloned().collect()).unwrap_or_default()
}

/// Transform that leaves nulls out: TOML has none, an optional key is left out.
#[derive(Clone, Debug)]
struct WithoutNull;

impl Transform for WithoutNull {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        let Some(object) = schema.as_object_mut() else {
            return;
        };
        if object.get("default") == Some(&Value::Null) {
            object.remove("default");
        }
        if let Some(Value::Array(types)) = object.get_mut("type") {
            types.retain(|name| name != "null");
            if let [only] = types.as_slice() {
                let only = only.clone();
                object.insert("type".to_string(), only);
            }
        }
        flatten_nullable(object);
    }
}

/// Replaces `anyOf: [X, null]`, the form of an optional X that is defined elsewhere, by X.
fn flatten_nullable(object: &mut serde_json::Map<String, Value>) {
    let Some(Value::Array(choices)) = object.get_mut("anyOf") else {
        return;
    };
    choices.retain(|choice| choice["type"] != "null");
    if let [Value::Object(only)] = choices.as_slice() {
        let only = only.clone();
        object.remove("anyOf");
        // The description beside the choices speaks of this key, the inner one of its type.
        for (key, value) in only {
            object.entry(key).or_insert(value);
        }
    }
}

//! Nulls that stand where a document should have a value or nothing.
//!
//! Programs write what they have no number for, such as infinity, as null.

use serde_json::{Map, Value};

/// Lists of references, from which nothing can be taken away without a change of their meaning.
const REFERENCES: [&str; 4] = ["children", "joints", "nodes", "weights"];

/// Takes away the members that are null, and lists of numbers with a null among them, so that defaults take their place.
/// Returns where they stood.
pub(super) fn remove(document: &mut Value) -> Vec<String> {
    let mut removed = Vec::new();
    descend(document, "", &mut removed);
    removed
}

fn descend(value: &mut Value, path: &str, removed: &mut Vec<String>) {
    match value {
        Value::Object(members) => descend_members(members, path, removed),
        Value::Array(items) => {
            for (i, item) in items.iter_mut().enumerate() {
                descend(item, &format!("{path}[{i}]"), removed);
            }
        }
        _ => {}
    }
}

fn descend_members(members: &mut Map<String, Value>, path: &str, removed: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    members.retain(|key, value| {
        let is_kept = !is_empty(key, value);
        if !is_kept {
            removed.push(below(key));
        }
        is_kept
    });
    // Applications may write into `extras` what they like.
    for (key, value) in members.iter_mut().filter(|(key, _)| *key != "extras") {
        descend(value, &below(key), removed);
    }
}

fn is_empty(key: &str, value: &Value) -> bool {
    match value {
        Value::Null => true,
        Value::Array(items) => {
            let numbers = items.iter().all(|item| item.is_null() || item.is_number());
            numbers && items.iter().any(Value::is_null) && !REFERENCES.contains(&key)
        }
        _ => false,
    }
}

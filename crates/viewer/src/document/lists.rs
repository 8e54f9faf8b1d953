//! The lists of shapes and lights, be they `[[shapes]]` or `shapes = [...]`.

use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value};

use super::tree::{raw, take_suffix};

/// Key of the list of shapes.
pub(super) const SHAPES: &str = "shapes";
/// Key of the list of lights.
pub(super) const LIGHTS: &str = "lights";

/// The table at `index` of the list called `list`, counted as in the file.
pub(super) fn entry<'a>(toml: &'a mut DocumentMut, list: &str, index: usize) -> Option<&'a mut Item> {
    // A number indexes a list and nothing else, and adds no entry to it.
    toml.get_mut(list)?.get_mut(index)
}

/// Adds a table at the end of the list called `list`.
pub(super) fn push(toml: &mut DocumentMut, list: &str, table: InlineTable) {
    match toml.entry(list).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new())) {
        Item::ArrayOfTables(tables) => tables.push(table.into_table()),
        Item::Value(Value::Array(array)) => push_inline(array, table.into()),
        _ => {}
    }
}

/// Adds a copy of the table at `index` at the end of its list, without the comments before it.
pub(super) fn push_copy(toml: &mut DocumentMut, list: &str, index: usize) {
    match toml.get_mut(list) {
        Some(Item::ArrayOfTables(tables)) => {
            if let Some(mut copy) = tables.get(index).cloned() {
                copy.decor_mut().clear();
                forget_places(&mut copy);
                tables.push(copy);
            }
        }
        Some(Item::Value(Value::Array(array))) => {
            if let Some(copy) = array.get(index).cloned() {
                push_inline(array, copy);
            }
        }
        _ => {}
    }
}

/// Clears the places of tables: without them, tables are written where they stand in the list.
fn forget_places(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        if let Some(table) = item.as_table_mut() {
            forget_places(table);
        }
    }
}

/// Removes a table of a list with the comments before it.
pub(super) fn remove(toml: &mut DocumentMut, list: &str, index: usize) {
    match toml.get_mut(list) {
        Some(Item::ArrayOfTables(tables)) if index < tables.len() => {
            tables.remove(index);
        }
        Some(Item::Value(Value::Array(array))) if index < array.len() => remove_inline(array, index),
        _ => {}
    }
}

/// Adds a value on a line of its own if the others have theirs. The comment at the end of the last line stays there,
/// which in TOML is behind the comma that the new value needs.
fn push_inline(array: &mut Array, value: Value) {
    let tail = take_tail(array);
    let separator = match array.iter().last() {
        None => String::new(),
        Some(last) => separator(last),
    };
    let (comment, closing) = tail.split_at(tail.rfind('\n').unwrap_or(0));
    let separator = if comment.contains('#') && !separator.contains('\n') { "\n" } else { &separator };
    array.push_formatted(value.decorated(format!("{comment}{separator}"), ""));
    array.set_trailing(closing);
}

/// A line break with the indentation of `value`, or a space where it does not begin a line.
fn separator(value: &Value) -> String {
    let prefix = prefix(value);
    prefix.rfind('\n').map_or(" ".to_string(), |at| prefix[at..].to_string())
}

fn remove_inline(array: &mut Array, index: usize) {
    let tail = take_tail(array);
    let before = prefix(&array.remove(index));
    match array.get_mut(index) {
        Some(next) => {
            let after = join(&before, &prefix(next)).unwrap_or(before);
            next.decor_mut().set_prefix(after);
            array.set_trailing(tail);
        }
        // A comment of the value before needs the end of its line.
        None if before.contains('#') && !tail.contains('\n') => array.set_trailing(before + &tail),
        None => array.set_trailing(join(&before, &tail).unwrap_or(tail)),
    }
}

/// Text between two neighbours when the value between `before` and `after` is gone: a comment on the line of the first
/// stays, one on the line of the value goes. `None` where the value does not end its line.
fn join(before: &str, after: &str) -> Option<String> {
    let start = after.find('\n')?;
    let end = before.find('\n').unwrap_or(0);
    Some(format!("{}{}", &before[..end], &after[start..]))
}

/// Takes the text before the closing bracket out of the last value and the array, and returns it.
fn take_tail(array: &mut Array) -> String {
    let suffix = array.iter_mut().last().map(take_suffix).unwrap_or_default();
    let tail = suffix + raw(array.trailing());
    array.set_trailing("");
    tail
}

fn prefix(value: &Value) -> String {
    value.decor().prefix().map_or(String::new(), |prefix| raw(prefix).to_string())
}

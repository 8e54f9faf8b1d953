//! Edits by the path of a key, for scripts.

use toml_edit::{DocumentMut, Item, Key, Table, Value};

use super::edits::section;
use super::{Document, EditError, tree};

/// Most names that a message lists; more help nobody.
const MOST_NAMES: usize = 8;

impl Document {
    /// Sets one key to a TOML value: `materials.red.color` to `[1, 0, 0]`, `shapes.2.sphere.radius` to `0.5`. Shapes
    /// and components are counted from 1, names in need of quotes have them as in TOML. Returns whether the text
    /// changed.
    ///
    /// # Errors
    /// [`EditError::Path`] when the path leads nowhere, or the value is not TOML or cannot stand there;
    /// [`EditError::Scene`] when the result would not be a valid scene.
    pub fn edit_path(&mut self, path: &str, value: &str) -> Result<bool, EditError> {
        let keys = Key::parse(path).map_err(|_| EditError::Path(format!("`{path}` is no path of a key")))?;
        let value = value.trim().parse::<Value>();
        let value = value.map_err(|error| {
            EditError::Path(format!("the value for `{path}` is not valid TOML: {}", error.message()))
        })?;
        self.edit(&format!("set {path}"), |toml, _| set(toml, &keys, value))
    }
}

fn set(toml: &mut DocumentMut, keys: &[Key], value: Value) -> Result<(), EditError> {
    let Some((last, way)) = keys.split_last() else { return Ok(()) };
    // The tables that a scene may do without.
    if let Some(first) = way.first().filter(|key| ["environment", "render"].contains(&key.get())) {
        section(toml, first.get());
    }
    let mut item = toml.as_item_mut();
    let mut place = Vec::new();
    for key in way {
        item = step(item, key.get(), &place)?;
        place.push(key.get());
    }
    if item.as_table_like().is_some_and(|table| !table.contains_key(last.get())) {
        tree::insert(item, last.get(), value);
        return Ok(());
    }
    put(step(item, last.get(), &place)?, value, &[place.as_slice(), &[last.get()]].concat())
}

/// Item that `key` leads to from the item at `place`.
fn step<'a>(item: &'a mut Item, key: &str, place: &[&str]) -> Result<&'a mut Item, EditError> {
    let here = named(place);
    if let Some(count) = length(item) {
        let index = key.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        let found = index.and_then(|index| item.get_mut(index));
        return found.ok_or_else(|| EditError::Path(format!("{here} has no `{key}`: it has {count}, counted from 1")));
    }
    let Some(table) = item.as_table_like_mut() else {
        return Err(EditError::Path(format!("{here} is a single value: it has no `{key}`")));
    };
    let keys = table.iter().take(MOST_NAMES).map(|(key, _)| format!("`{key}`")).collect::<Vec<_>>().join(", ");
    table.get_mut(key).ok_or_else(|| EditError::Path(format!("{here} has no `{key}`: it has {keys}")))
}

/// Length of a list; `None` for any other item.
fn length(item: &Item) -> Option<usize> {
    let tables = item.as_array_of_tables().map(toml_edit::ArrayOfTables::len);
    tables.or(item.as_array().map(toml_edit::Array::len))
}

fn put(item: &mut Item, value: Value, place: &[&str]) -> Result<(), EditError> {
    match (item, value) {
        (Item::Value(old), new) => tree::replace(old, new),
        (Item::Table(old), Value::InlineTable(new)) => *old = in_place_of(old, new.into_table()),
        (Item::Table(_), _) => {
            let message = "is a table: give all of it in braces, or one of its keys a value";
            return Err(EditError::Path(format!("{} {message}", named(place))));
        }
        _ => return Err(EditError::Path(format!("{} is a list of tables: name one of them", named(place)))),
    }
    Ok(())
}

/// Gives `new` the comments, the place and the form of `old`.
fn in_place_of(old: &Table, mut new: Table) -> Table {
    *new.decor_mut() = old.decor().clone();
    new.set_position(old.position());
    new.set_dotted(old.is_dotted());
    new
}

fn named(place: &[&str]) -> String {
    if place.is_empty() { "the scene".to_string() } else { format!("`{}`", place.join(".")) }
}

//! Values in TOML's tables, whichever way those are written: under a header, inline or as dotted keys.

use raggio_scene::Intrinsics;
use toml_edit::{Array, InlineTable, Item, RawString, Table, Value};

use super::fields::{self, Datum, Field};

/// Largest number written without a point; beyond it whole numbers are no easier to read than any others.
const LARGEST_WHOLE: f32 = 1e15;

/// Writes the keys that change, each where and as it stands, new ones at the end.
pub(super) fn write_fields(table: &mut Item, fields: &[Field]) {
    for field in fields {
        match child(table, field.key) {
            Some(_) if field.new == field.old => {}
            Some(_) if field.new == Datum::Absent => remove(table, field.key),
            Some(item) => overwrite(item, field.new),
            None if field.new == field.absent => {}
            None => value(field.new).into_iter().for_each(|value| insert(table, field.key, value)),
        }
    }
}

/// The item of a key, if the table has it.
pub(super) fn child<'a>(table: &'a mut Item, key: &str) -> Option<&'a mut Item> {
    table.as_table_like_mut()?.get_mut(key)
}

/// Puts `new` in the place of a value, within its comments.
pub(super) fn replace(old: &mut Value, new: Value) {
    let decor = old.decor().clone();
    *old = new;
    *old.decor_mut() = decor;
}

/// Adds a key at the end of a table; does nothing to what is not a table.
pub(super) fn insert(table: &mut Item, key: &str, value: Value) {
    match table {
        Item::Value(Value::InlineTable(table)) => insert_inline(table, key, value),
        Item::Table(table) => {
            let has_header = !table.is_implicit() || table.is_dotted();
            table.insert(key, if has_header { Item::Value(value) } else { under_header(value) });
        }
        _ => {}
    }
}

/// Removes a key with its comments.
pub(super) fn remove(table: &mut Item, key: &str) {
    if let Item::Value(Value::InlineTable(table)) = table {
        settle(table);
    }
    if let Some(table) = table.as_table_like_mut() {
        table.remove(key);
    }
}

/// Item for a parent without a header, in which a table needs a header of its own.
fn under_header(value: Value) -> Item {
    match value {
        Value::InlineTable(table) => Item::Table(table.into_table()),
        value => Item::Value(value),
    }
}

fn insert_inline(table: &mut InlineTable, key: &str, value: Value) {
    if table.is_empty() {
        table.set_trailing(" ");
    }
    settle(table);
    table.insert(key, value.decorated(" ", ""));
}

/// Moves what stands between the last value and the closing brace from the value to the table, so that it stays there
/// whichever value is the last.
fn settle(table: &mut InlineTable) {
    if table.is_dotted() {
        return;
    }
    let suffix = table.iter_mut().last().map(|(_, last)| take_suffix(last)).unwrap_or_default();
    let tail = suffix + raw(table.trailing());
    table.set_trailing(tail);
}

/// Takes away the space and comments after a value, and returns them.
pub(super) fn take_suffix(value: &mut Value) -> String {
    // A suffix that is not known is a default one, which is written as the place demands.
    let suffix = value.decor().suffix().map_or(String::new(), |suffix| raw(suffix).to_string());
    value.decor_mut().set_suffix("");
    suffix
}

/// Space and comments, as text.
pub(super) fn raw(text: &RawString) -> &str {
    text.as_str().unwrap_or_default()
}

/// A new inline table with the new values of the fields.
pub(super) fn inline_table(fields: &[Field]) -> Value {
    let mut item = Item::Value(Value::InlineTable(InlineTable::new()));
    write_fields(&mut item, fields);
    item.into_value().unwrap_or_else(|_| InlineTable::new().into())
}

/// A new table under a header with the new values of the fields.
pub(super) fn table(fields: &[Field]) -> Item {
    let mut item = Item::Table(Table::new());
    write_fields(&mut item, fields);
    item
}

fn overwrite(item: &mut Item, datum: Datum) {
    let Some(old) = item.as_value_mut() else { return };
    match (old, datum) {
        (old, Datum::Number(number)) => overwrite_number(old, number),
        (Value::Array(array), Datum::Vector(vector)) if array.len() == 3 => {
            let numbers = array.iter_mut().zip(vector.to_array());
            numbers.for_each(|(old, number)| overwrite_number(old, number));
        }
        (old, datum) => value(datum).into_iter().for_each(|new| replace(old, new)),
    }
}

/// Replaces a number; one that is right already keeps its digits.
fn overwrite_number(old: &mut Value, new: f32) {
    let known = old.as_float().or(old.as_integer().map(|whole| whole as f64));
    if known.is_none_or(|known| known as f32 != new) {
        replace(old, number(new));
    }
}

fn value(datum: Datum) -> Option<Value> {
    Some(match datum {
        Datum::Absent => return None,
        Datum::Number(number) => self::number(number),
        Datum::Vector(vector) => array(&vector.to_array()),
        Datum::Whole(whole) => whole.into(),
        Datum::Word(word) => word.into(),
        Datum::Flag(flag) => flag.into(),
        Datum::Intrinsics(intrinsics) => self::intrinsics(&intrinsics).into(),
        Datum::Medium(medium) => inline_table(&fields::medium(&medium, &medium)),
    })
}

fn array(numbers: &[f32]) -> Value {
    numbers.iter().copied().map(number).collect::<Array>().into()
}

fn intrinsics(intrinsics: &Intrinsics) -> InlineTable {
    let Intrinsics { focal, principal_point, skew, size } = intrinsics;
    let mut table = InlineTable::new();
    table.insert("focal", array(focal));
    table.insert("principal_point", array(principal_point));
    if *skew != 0.0 {
        table.insert("skew", number(*skew));
    }
    table.insert("size", size.iter().map(|side| i64::from(*side)).collect::<Array>().into());
    table
}

/// Writes a number with the fewest digits that give the same 32-bit number back, and without a point where it is whole.
fn number(x: f32) -> Value {
    if x == x.trunc() && x.abs() <= LARGEST_WHOLE {
        return (x as i64).into();
    }
    let shortest = x.to_string().parse().unwrap_or(f64::from(x));
    // Rounded to 64 bits first, the shortest digits could be those of a neighbour.
    if shortest as f32 == x { shortest.into() } else { f64::from(x).into() }
}

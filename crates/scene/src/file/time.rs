//! Points in time, as TOML writes them.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};
use toml_datetime::{Datetime, Offset};

use crate::sky::Moment;

/// A date with the time of day and its offset from universal time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Time(pub Moment);

impl Time {
    /// Name by which readers know that TOML's own dates are read here, not texts alone.
    pub const NAME: &'static str = "time";
    /// Description of what is expected.
    pub const EXPECTED: &'static str = "a date and time with its offset, such as 2026-06-21T17:30:00+02:00";
}

/// The moment that `text` names; `None` where it lacks a part, or is beyond the calendar.
fn moment(text: &str) -> Option<Moment> {
    let Datetime { date: Some(date), time: Some(time), offset: Some(offset) } = text.trim().parse().ok()? else {
        return None;
    };
    let minutes = match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => minutes,
    };
    let seconds = f64::from(time.second.unwrap_or(0)) + 1e-9 * f64::from(time.nanosecond.unwrap_or(0));
    let date = [date.year.into(), date.month.into(), date.day.into()];
    Moment::new(date, [time.hour.into(), time.minute.into()], seconds.min(59.999), minutes.into())
}

impl<'de> Deserialize<'de> for Time {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;

        impl<'de> Visitor<'de> for Text {
            type Value = Time;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(Time::EXPECTED)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Time, E> {
                moment(text).map(Time).ok_or_else(|| E::custom(format!("must be {}", Time::EXPECTED)))
            }

            fn visit_newtype_struct<D: Deserializer<'de>>(self, deserializer: D) -> Result<Time, D::Error> {
                deserializer.deserialize_str(self)
            }
        }

        deserializer.deserialize_newtype_struct(Self::NAME, Text)
    }
}

impl JsonSchema for Time {
    fn schema_name() -> Cow<'static, str> {
        "Time".into()
    }

    fn inline_schema() -> bool {
        true
    }

    // Editors read TOML's dates as texts of this format.
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "format": "date-time" })
    }
}

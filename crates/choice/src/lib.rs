//! Choices that users make by name, such as a filter or a tone mapper.
//!
//! The crate that owns a choice spells each name and its description once, in [`choice!`]. Scene files, the command line,
//! menus, scripts and metadata ask for them there.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// A choice among a few, each of which has a name that users write.
pub trait Choice: Copy + Eq + FromStr<Err = UnknownName> + fmt::Display + Send + Sync + 'static {
    /// Noun for messages: `filter`.
    const KIND: &'static str;
    /// All there are, in the order in which they are offered.
    const ALL: &'static [Self];
    /// Names of [`Choice::ALL`], in that order.
    const NAMES: &'static [&'static str];

    /// Name, as users write it.
    fn name(self) -> &'static str;

    /// Description in a sentence, for help texts and schemas.
    fn description(self) -> &'static str;
}

/// A name that none of a choice's kinds has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// Noun of the choice.
    pub kind: &'static str,
    /// Names that there are.
    pub known: &'static [&'static str],
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "unknown {}: give {}", self.kind, listed(self.known))
    }
}

impl std::error::Error for UnknownName {}

/// Words as a sentence has them: `a, b or c`.
pub fn listed(words: &[&str]) -> String {
    match words {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => words.concat(),
    }
}

/// The choice of this name, in upper or lower case.
///
/// # Errors
/// When none has that name; the message lists those there are.
pub fn named<T: Choice>(name: &str) -> Result<T, UnknownName> {
    let found = T::ALL.iter().copied().find(|choice| choice.name().eq_ignore_ascii_case(name));
    found.ok_or(UnknownName { kind: T::KIND, known: T::NAMES })
}

/// Format of a file, told by the ending of its name, in upper or lower case: formats are called as their files end.
pub fn format_of<T: Choice>(path: &Path) -> Option<T> {
    named(path.extension()?.to_str()?).ok()
}

/// Endings of files of a choice of formats, as a sentence has them: `.png or .exr`.
pub fn endings<T: Choice>() -> String {
    let endings: Vec<String> = T::NAMES.iter().map(|name| format!(".{name}")).collect();
    listed(&endings.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Makes an enumeration a [`Choice`], with [`FromStr`] and [`Display`](fmt::Display) by its names. Variants are given as
/// `Variant = "name"` beneath a comment that becomes the description. `impl` in place of the enumeration's attributes and
/// `pub` names one that stands elsewhere.
#[macro_export]
macro_rules! choice {
    ($(#[$meta:meta])* pub enum $type:ident: $kind:literal {
        $($(#[doc = $doc:literal])+ $variant:ident = $name:literal),+ $(,)?
    }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $type {
            $($(#[doc = $doc])+ $variant),+
        }
        $crate::choice! { impl $type: $kind { $($(#[doc = $doc])+ $variant = $name),+ } }
    };
    (impl $type:ident: $kind:literal {
        $($(#[doc = $doc:literal])+ $variant:ident = $name:literal),+ $(,)?
    }) => {
        impl $type {
            /// Name, as users write it.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }
        }

        impl $crate::Choice for $type {
            const KIND: &'static str = $kind;
            const ALL: &'static [Self] = &[$(Self::$variant),+];
            const NAMES: &'static [&'static str] = &[$($name),+];

            fn name(self) -> &'static str {
                $type::name(self)
            }

            fn description(self) -> &'static str {
                match self {
                    $(Self::$variant => concat!($($doc),+).trim_ascii()),+
                }
            }
        }

        impl ::std::str::FromStr for $type {
            type Err = $crate::UnknownName;

            fn from_str(name: &str) -> Result<Self, $crate::UnknownName> {
                $crate::named(name)
            }
        }

        impl ::std::fmt::Display for $type {
            fn fmt(&self, f: &mut ::std::fmt::Formatter<'_>) -> ::std::fmt::Result {
                f.pad($type::name(*self))
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    choice! {
        /// Ways to bend.
        pub enum Bend: "bend" {
            /// To the left,
            /// and on.
            Left = "left",
            /// Straight through.
            Straight = "straight-on",
        }
    }

    #[test]
    fn names_and_descriptions_are_those_that_were_spelled() {
        assert_eq!(Bend::ALL, [Bend::Left, Bend::Straight]);
        assert_eq!(Bend::Straight.to_string(), "straight-on");
        assert_eq!(Bend::Left.description(), "To the left, and on.");
        for bend in Bend::ALL {
            assert_eq!(bend.name().parse(), Ok(*bend));
            assert_eq!(bend.name().to_uppercase().parse(), Ok(*bend));
        }
    }

    #[test]
    fn formats_are_told_by_endings() {
        assert_eq!(format_of(Path::new("a.b/c.LEFT")), Some(Bend::Left));
        assert_eq!(format_of::<Bend>(Path::new("left")), None);
        assert_eq!(endings::<Bend>(), ".left or .straight-on");
    }

    #[test]
    fn unknown_names_are_told_the_known_ones() {
        let error = "right".parse::<Bend>().expect_err("no such bend");
        assert_eq!(error.to_string(), "unknown bend: give left or straight-on");
    }
}

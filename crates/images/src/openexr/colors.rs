//! Which channels of an OpenEXR file make up the colour that is read.

use std::collections::HashMap;

use exr::meta::attribute::Text;
use exr::meta::header::Header;

/// Layers that are preferred to others, by the last part of their names and in this order; one without a name comes first.
const PREFERRED: [&str; 8] = ["combined", "beauty", "rgba", "rgb", "color", "colour", "image", "diffuse"];
/// Most layers that a warning names.
const MOST_NAMED: usize = 20;

/// Channels that share a name up to the last dot.
pub(super) struct Group {
    /// Index of the header that lists the channels.
    pub(super) header: usize,
    name: String,
    /// Places of the channels in the header's list, in the order of [`Role`].
    members: [Option<usize>; ROLES],
}

/// Part that a channel plays in a colour.
#[derive(Clone, Copy)]
enum Role {
    Red,
    Green,
    Blue,
    Luminance,
    RedChroma,
    BlueChroma,
    /// Part in a vector, whose y is no luminance.
    Vector,
}

const ROLES: usize = 7;

/// Meaning of the samples of a colour, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Rgb,
    /// Luminance Y with (R - Y) / Y and (B - Y) / Y.
    LuminanceChroma,
    Luminance,
    /// Red, green or blue, but not all of them.
    Partial,
}

impl Role {
    fn of(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "r" | "red" => Some(Self::Red),
            "g" | "green" => Some(Self::Green),
            "b" | "blue" => Some(Self::Blue),
            "y" => Some(Self::Luminance),
            "ry" => Some(Self::RedChroma),
            "by" => Some(Self::BlueChroma),
            "x" => Some(Self::Vector),
            _ => None,
        }
    }
}

impl Group {
    fn has(&self, role: Role) -> bool {
        self.members[role as usize].is_some()
    }

    pub(super) fn kind(&self) -> Option<Kind> {
        let colors = [Role::Red, Role::Green, Role::Blue].into_iter().filter(|role| self.has(*role)).count();
        match colors {
            3 => Some(Kind::Rgb),
            0 if !self.has(Role::Luminance) || self.has(Role::Vector) => None,
            0 if self.has(Role::RedChroma) || self.has(Role::BlueChroma) => Some(Kind::LuminanceChroma),
            0 => Some(Kind::Luminance),
            _ => Some(Kind::Partial),
        }
    }

    /// Components of a pixel that take the samples of the channel at a place of the header's list.
    pub(super) fn components(&self, channel: usize) -> &'static [usize] {
        let role = self.members.iter().position(|member| *member == Some(channel));
        match (self.kind(), role) {
            (Some(Kind::Luminance), Some(3)) => &[0, 1, 2],
            (Some(Kind::LuminanceChroma), Some(3)) => &[0],
            (Some(Kind::LuminanceChroma), Some(4)) => &[1],
            (Some(Kind::LuminanceChroma), Some(5)) => &[2],
            (Some(Kind::Rgb | Kind::Partial), Some(0)) => &[0],
            (Some(Kind::Rgb | Kind::Partial), Some(1)) => &[1],
            (Some(Kind::Rgb | Kind::Partial), Some(2)) => &[2],
            _ => &[],
        }
    }

    /// Order of preference: by name, then by what there is of a colour.
    fn rank(&self) -> (usize, Option<Kind>) {
        let last = self.name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
        let preferred = PREFERRED.iter().position(|name| *name == last);
        let by_name = if self.name.is_empty() { 0 } else { 1 + preferred.unwrap_or(PREFERRED.len()) };
        (by_name, self.kind())
    }
}

/// The colour to read, and a warning where it was chosen among several that all have names.
pub(super) fn choose(headers: &[Header]) -> Option<(Group, Option<String>)> {
    let mut groups: Vec<Group> = groups(headers).into_iter().filter(|group| group.kind().is_some()).collect();
    let chosen = (0..groups.len()).min_by_key(|group| groups[*group].rank())?;
    let names = groups.iter().take(MOST_NAMED).map(|group| format!("`{}`", group.name));
    let names: Vec<_> = names.collect();
    let is_told = groups.len() > 1 && !groups[chosen].name.is_empty();
    let warning = || format!("it has the layers {}: `{}` is taken", names.join(", "), groups[chosen].name);
    let warning = is_told.then(warning);
    Some((groups.swap_remove(chosen), warning))
}

/// All groups of channels, in the order of the file.
fn groups(headers: &[Header]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (header, listed) in headers.iter().enumerate() {
        // The name of an only part says nothing of its channels.
        let part =
            listed.own_attributes.layer_name.as_ref().filter(|_| headers.len() > 1).map_or_else(String::new, text);
        let mut known = HashMap::new();
        for (place, channel) in listed.channels.list.iter().enumerate() {
            let channel = text(&channel.name);
            let (prefix, last) = channel.rsplit_once('.').unwrap_or(("", &channel));
            let Some(role) = Role::of(last) else { continue };
            let dot = if part.is_empty() || prefix.is_empty() { "" } else { "." };
            let name = format!("{part}{dot}{prefix}");
            let group = *known.entry(name.clone()).or_insert(groups.len());
            if group == groups.len() {
                groups.push(Group { header, name, members: [None; ROLES] });
            }
            groups[group].members[role as usize] = Some(place);
        }
    }
    groups
}

/// A name in UTF-8, which the library takes for Latin-1.
fn text(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

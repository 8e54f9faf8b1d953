//! Animations sampled at a time.

use std::collections::HashSet;

use glam::{DQuat, DVec3};

use super::asset::Asset;
use super::document::{Animation, AnimationSampler, Channel, Interpolation, Path};
use super::fault::at;
use super::nodes::{Pose, rotation};
use crate::error::Fault;
use crate::text::quoted;

/// Animations of the file, each from its first keyframe to its last; what is wrong with one is told when it is applied.
pub(super) fn listed(asset: &Asset<'_>) -> Vec<crate::model::Animation> {
    let listed = |animation: &Animation| {
        let times = |sampler: &AnimationSampler| {
            let (times, _) = asset.warnings.apart(|| asset.floats_as_stored::<1>(sampler.input, None, ""));
            let times = times.unwrap_or_default().into_iter().map(|[time]| f64::from(time));
            let times: Vec<_> = times.filter(|time| time.is_finite()).collect();
            Some([*times.first()?, *times.last()?])
        };
        let spans = animation.samplers.iter().filter_map(times);
        let seconds = spans.reduce(|[start, end], [from, to]| [start.min(from), end.max(to)]).unwrap_or_default();
        crate::model::Animation { name: animation.name.clone(), seconds }
    };
    asset.document.animations.iter().map(listed).collect()
}

/// Moves the nodes to their places at `seconds`. Animations that move different things are applied together; among
/// those that move one thing, the first counts.
pub(super) fn apply(asset: &Asset<'_>, seconds: f64, pose: &mut Pose) -> Result<(), Fault> {
    let mut moved = HashSet::new();
    for (number, animation) in asset.document.animations.iter().enumerate() {
        let targets: Vec<_> = animation.channels.iter().filter_map(|c| Some((c.target.node?, c.target.path))).collect();
        if targets.iter().any(|target| moved.contains(target)) {
            let name = quoted(animation.name.as_bytes());
            asset.warnings.push(format!("animation {number}, {name}, is left out: another one moves the same nodes"));
            continue;
        }
        moved.extend(targets);
        for (i, channel) in animation.channels.iter().enumerate() {
            apply_channel(asset, animation, channel, seconds, pose, &format!("animations[{number}].channels[{i}]"))?;
        }
    }
    Ok(())
}

fn apply_channel(
    asset: &Asset<'_>,
    animation: &Animation,
    channel: &Channel,
    seconds: f64,
    pose: &mut Pose,
    path: &str,
) -> Result<(), Fault> {
    let sampler = &animation.samplers[channel.sampler];
    let curve = |width, elements| Curve { asset, sampler, path, width, elements };
    if channel.target.path == Path::Pointer {
        asset.warnings.push("animations of properties other than a node's (KHR_animation_pointer) are not applied");
    }
    let Some(node) = channel.target.node else { return Ok(()) };
    match channel.target.path {
        Path::Translation => pose.place(node).translation = DVec3::from(curve(3, 1).vector(seconds)?),
        Path::Scale => pose.place(node).scale = DVec3::from(curve(3, 1).vector(seconds)?),
        Path::Rotation => pose.place(node).rotation = curve(4, 1).rotation(seconds)?,
        Path::Weights => {
            let targets = super::nodes::morph_targets(&asset.document, node);
            let weights = curve(targets, targets).sample(seconds)?;
            pose.weights.insert(node, weights.iter().map(|weight| *weight as f32).collect());
        }
        Path::Pointer => {}
    }
    Ok(())
}

/// Curve through the keys of one property.
struct Curve<'a> {
    asset: &'a Asset<'a>,
    sampler: &'a AnimationSampler,
    path: &'a str,
    /// Number of components of the property.
    width: usize,
    /// Number of elements of the output accessor that hold them: weights are stored one by one.
    elements: usize,
}

/// Two neighbouring keys and the time between them; before the first key and after the last both are that key.
struct Span {
    keys: [usize; 2],
    /// Time from the first key to the second, in seconds.
    seconds: f64,
    /// Fraction of that time that has passed: 0 at the first key, 1 at the second.
    fraction: f64,
}

impl Curve<'_> {
    fn vector(&self, seconds: f64) -> Result<[f64; 3], Fault> {
        let values = self.sample(seconds)?;
        Ok([values[0], values[1], values[2]])
    }

    fn rotation(&self, seconds: f64) -> Result<DQuat, Fault> {
        let span = self.span(seconds)?;
        let quaternion = |v: Vec<f64>| DQuat::from_xyzw(v[0], v[1], v[2], v[3]);
        let unit = |v| rotation(quaternion(v), format_args!("{}: a rotation", self.path), &self.asset.warnings);
        if self.sampler.interpolation == Interpolation::Linear {
            let [a, b] = span.keys.map(|key| self.value(key, 0).map(unit));
            return Ok(a?.slerp(b?, span.fraction));
        }
        Ok(unit(self.interpolated(&span)?))
    }

    fn sample(&self, seconds: f64) -> Result<Vec<f64>, Fault> {
        let values = self.interpolated(&self.span(seconds)?)?;
        let finite = values.iter().all(|value| value.is_finite());
        if finite { Ok(values) } else { Err(at(self.path, "the values should be finite")) }
    }

    fn interpolated(&self, span: &Span) -> Result<Vec<f64>, Fault> {
        let [first, second] = span.keys;
        let t = span.fraction;
        let mix = |parts: &[(f64, Vec<f64>)]| {
            (0..self.width).map(|i| parts.iter().map(|(factor, values)| factor * values[i]).sum()).collect()
        };
        match self.sampler.interpolation {
            Interpolation::Step => self.value(first, 0),
            Interpolation::Linear => Ok(mix(&[(1.0 - t, self.value(first, 0)?), (t, self.value(second, 0)?)])),
            // Hermite's cubic (khronos2021gltf, appendix C); tangents are per second.
            Interpolation::CubicSpline => Ok(mix(&[
                (2.0 * t.powi(3) - 3.0 * t.powi(2) + 1.0, self.value(first, 1)?),
                (span.seconds * (t.powi(3) - 2.0 * t.powi(2) + t), self.value(first, 2)?),
                (3.0 * t.powi(2) - 2.0 * t.powi(3), self.value(second, 1)?),
                (span.seconds * (t.powi(3) - t.powi(2)), self.value(second, 0)?),
            ])),
        }
    }

    fn span(&self, seconds: f64) -> Result<Span, Fault> {
        let times = self.asset.floats_as_stored::<1>(self.sampler.input, None, self.path)?;
        let increase = times.is_sorted_by(|a, b| a[0] < b[0]) && times.iter().all(|time| time[0].is_finite());
        if times.is_empty() || !increase {
            return Err(at(self.path, "the times of the keys should increase, and there should be some"));
        }
        let time = |key: usize| f64::from(times[key][0]);
        let after = times.partition_point(|time| f64::from(time[0]) <= seconds);
        let keys = [after.saturating_sub(1), after.min(times.len() - 1)];
        let length = time(keys[1]) - time(keys[0]);
        let fraction = if length > 0.0 { (seconds - time(keys[0])) / length } else { 0.0 };
        self.check_values(times.len())?;
        Ok(Span { keys, seconds: length, fraction })
    }

    /// Rows of values that each key has: three for cubic splines, which store two tangents, too.
    fn rows(&self) -> usize {
        if self.sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 }
    }

    fn check_values(&self, keys: usize) -> Result<(), Fault> {
        let output = self.asset.accessor(self.sampler.output);
        let width = output.kind.width() * self.elements;
        let needed = keys.saturating_mul(self.rows()).saturating_mul(self.elements);
        if width == self.width && output.count >= needed {
            return Ok(());
        }
        let message = format!("the output should have {needed} elements for {keys} keys of {} numbers", self.width);
        Err(at(
            self.path,
            format!("{message}: accessor {} has {} of {:?}", self.sampler.output, output.count, output.kind),
        ))
    }

    /// One of the vectors that are stored for a key.
    fn value(&self, key: usize, row: usize) -> Result<Vec<f64>, Fault> {
        let elements = self.elements;
        let start = (key * self.rows() + row) * elements;
        let used: Vec<u32> = (start..start + elements).map(|element| element as u32).collect();
        let (accessor, used) = (self.sampler.output, Some(&used[..]));
        let wide = |numbers: &[f32]| numbers.iter().map(|number| f64::from(*number)).collect();
        match self.asset.accessor(accessor).kind.width() {
            1 => Ok(wide(self.asset.floats_as_stored::<1>(accessor, used, self.path)?.as_flattened())),
            3 => Ok(wide(self.asset.floats_as_stored::<3>(accessor, used, self.path)?.as_flattened())),
            _ => Ok(wide(self.asset.floats_as_stored::<4>(accessor, used, self.path)?.as_flattened())),
        }
    }
}

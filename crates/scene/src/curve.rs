//! Curves through values at moments.

use raggio_choice::choice;

choice! {
    /// Way from one keyframe to the next.
    pub enum Interpolation: "interpolation" {
        /// straight, at one speed between two keyframes
        Linear = "linear",
        /// along a cubic curve whose speed does not jump, and which goes beyond no keyframe where it turns round or rests
        Smooth = "smooth",
    }
}

/// Values at moments that follow each other.
#[derive(Clone, Debug)]
pub(crate) struct Curve<const N: usize> {
    points: Vec<(f64, [f64; N])>,
}

impl<const N: usize> Curve<N> {
    /// Curve through `points`, each a moment and a value; `None` where there are none. Moments ascend.
    pub fn through(points: impl Iterator<Item = (f64, [f64; N])>) -> Option<Self> {
        let points: Vec<_> = points.collect();
        (!points.is_empty()).then_some(Self { points })
    }

    /// Value at a moment: the first or the last before and after all of them.
    pub fn at(&self, seconds: f64, interpolation: Interpolation) -> [f64; N] {
        let points = &self.points;
        let next = points.partition_point(|(moment, _)| *moment <= seconds);
        let Some((start, from)) = next.checked_sub(1).map(|last| points[last]) else { return points[0].1 };
        let Some((end, to)) = points.get(next).copied() else { return from };
        let (length, part) = (end - start, (seconds - start) / (end - start));
        std::array::from_fn(|axis| match interpolation {
            Interpolation::Linear => from[axis] + part * (to[axis] - from[axis]),
            Interpolation::Smooth => {
                let [leaving, arriving] = [next - 1, next].map(|place| length * self.speed(place, axis));
                hermite(part, from[axis], to[axis], leaving, arriving)
            }
        })
    }

    /// Speed at a keyframe: that of the parabola through it and its neighbours (which at equal intervals is Catmull and
    /// Rom's), limited so that the curve is monotone wherever the values are [steffen1990interpolation].
    fn speed(&self, place: usize, axis: usize) -> f64 {
        let slope = |place: usize| {
            let [(start, from), (end, to)] = [self.points[place], self.points[place + 1]];
            (end - start, (to[axis] - from[axis]) / (end - start))
        };
        let last = self.points.len() - 1;
        match place {
            0 if last == 1 => slope(0).1,
            0 => end_speed(slope(0), slope(1)),
            _ if place == last && last == 1 => slope(0).1,
            _ if place == last => end_speed(slope(last - 1), slope(last - 2)),
            _ => {
                let ((before, arriving), (after, leaving)) = (slope(place - 1), slope(place));
                let parabola = (arriving * after + leaving * before) / (before + after);
                let least = arriving.abs().min(leaving.abs()).min(0.5 * parabola.abs());
                (sign(arriving) + sign(leaving)) * least
            }
        }
    }
}

/// Speed at an end, from lengths and slopes of the interval there and of the next one.
fn end_speed((length, slope): (f64, f64), (next_length, next_slope): (f64, f64)) -> f64 {
    let share = length / (length + next_length);
    let parabola = slope * (1.0 + share) - next_slope * share;
    if parabola * slope <= 0.0 {
        0.0
    } else if parabola.abs() > 2.0 * slope.abs() {
        2.0 * slope
    } else {
        parabola
    }
}

/// Sign of a number; 0 for none.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Cubic from one value to another with these speeds at its ends, where `part` goes from 0 to 1.
fn hermite(part: f64, from: f64, to: f64, leaving: f64, arriving: f64) -> f64 {
    let rest = 1.0 - part;
    let turned = part * part * (3.0 - 2.0 * part);
    from + turned * (to - from) + part * rest * (rest * leaving - part * arriving)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> Curve<1> {
        Curve::through(points.iter().map(|(moment, value)| (*moment, [*value]))).expect("points")
    }

    fn smooth(points: &[(f64, f64)], seconds: f64) -> f64 {
        curve(points).at(seconds, Interpolation::Smooth)[0]
    }

    const MOMENTS: [f64; 5] = [0.5, 1.0, 1.75, 4.0, 4.25];

    #[test]
    fn lines_are_lines_either_way() {
        let line = MOMENTS.map(|t| (t, 3.0 - 2.0 * t));
        for step in 0..=100 {
            let t = 0.5 + 3.75 * f64::from(step) / 100.0;
            for interpolation in [Interpolation::Linear, Interpolation::Smooth] {
                let [found] = curve(&line).at(t, interpolation);
                assert!((found - (3.0 - 2.0 * t)).abs() < 1e-12, "{interpolation} at {t}: {found}");
            }
        }
        let [half] = curve(&[(1.0, 10.0), (3.0, 20.0), (4.0, 0.0)]).at(3.25, Interpolation::Linear);
        assert_eq!(half, 15.0);
    }

    /// The speeds are those of parabolas, so that a parabola comes out as it is, at unequal intervals too.
    #[test]
    fn parabolas_are_parabolas() {
        let parabola = [1.0, 2.0, 4.0, 5.0, 9.0].map(|t: f64| (t, 0.5 * t * t - 7.0));
        for step in 0..=100 {
            let t = 1.0 + 8.0 * f64::from(step) / 100.0;
            let found = smooth(&parabola, t);
            assert!((found - (0.5 * t * t - 7.0)).abs() < 1e-12, "at {t}: {found}");
        }
    }

    /// The cubic between 0 and 1 whose speeds are 0 at the turning points: 3 t^2 - 2 t^3.
    #[test]
    fn what_turns_round_slows_down_there() {
        let zigzag = [(0.0, 1.0), (1.0, 0.0), (2.0, 1.0), (3.0, 0.0)];
        for step in 0..=10 {
            let t = f64::from(step) / 10.0;
            assert!((smooth(&zigzag, 1.0 + t) - t * t * (3.0 - 2.0 * t)).abs() < 1e-12);
        }
    }

    #[test]
    fn what_rests_does_not_move() {
        let rest = [(0.0, 4.0), (1.0, 5.0), (3.0, 5.0), (3.5, -1.0)];
        for step in 0..=50 {
            assert_eq!(smooth(&rest, 1.0 + 2.0 * f64::from(step) / 50.0), 5.0);
        }
    }

    #[test]
    fn ends_hold_and_keyframes_are_met() {
        let points = MOMENTS.map(|t| (t, (7.3 * t).sin()));
        for interpolation in [Interpolation::Linear, Interpolation::Smooth] {
            let at = |t: f64| curve(&points).at(t, interpolation)[0];
            assert!(points.iter().all(|(t, value)| at(*t) == *value));
            assert_eq!([at(0.0), at(-3.0), at(5.0)], [points[0].1, points[0].1, points[4].1]);
        }
        assert_eq!(smooth(&[(2.0, 9.0)], 1.0), 9.0);
        assert!(Curve::<1>::through(std::iter::empty()).is_none());
    }

    /// Between two keyframes the curve stays between their values, and its speed is the same on both sides of each.
    #[test]
    fn nothing_overshoots_and_speeds_do_not_jump() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1u32 << 24)
        };
        for _ in 0..200 {
            let mut t = 0.0;
            let points: Vec<_> = (0..6)
                .map(|_| {
                    t += 0.05 + random();
                    (t, (4.0 * random()).floor() + random())
                })
                .collect();
            let curve = curve(&points);
            let at = |t: f64| curve.at(t, Interpolation::Smooth)[0];
            for pair in points.windows(2) {
                let [(start, from), (end, to)] = [pair[0], pair[1]];
                for step in 0..=40 {
                    let value = at(start + (end - start) * f64::from(step) / 40.0);
                    assert!(value >= from.min(to) - 1e-12 && value <= from.max(to) + 1e-12, "{points:?}");
                }
            }
            for (t, value) in &points[1..5] {
                let step = 1e-7;
                let [before, after] = [(value - at(t - step)) / step, (at(t + step) - value) / step];
                assert!(
                    (before - after).abs() < 1e-3 * (1.0 + before.abs()),
                    "{points:?}: {before} and {after} at {t}"
                );
            }
        }
    }
}

//! Several devices that share a picture.

use std::ops::Range;
use std::time::{Duration, Instant};

use raggio_kernels::{Feature, FilmPixel, Probe};

use crate::devices::adaptive::Blocks;
use crate::devices::device::{Answer, Device, DeviceError, Question, Session};
use crate::devices::tracer::Tracer;
use crate::pictures::display::{Display, Pixels};
use crate::pictures::film::Film;
use crate::pictures::linear_image::Image;
use crate::translation::device_scene::DeviceScene;

/// Devices that share the samples of one picture.
///
/// Each has the whole scene and a film of its own, and the picture's film is their sum, which is exact. Of devices that
/// agree bit for bit with one another, as those of one kind and driver do, the picture is the same as of one of them; of
/// others it agrees to rounding, and depends on who was how fast.
pub struct DeviceGroup {
    devices: Vec<Box<dyn Device>>,
}

impl DeviceGroup {
    /// Group of `devices`, of which there is at least one.
    pub fn new(devices: Vec<Box<dyn Device>>) -> Self {
        Self { devices }
    }
}

impl Device for DeviceGroup {
    fn name(&self) -> String {
        self.devices.iter().map(|device| device.name()).collect::<Vec<_>>().join(" + ")
    }

    fn validation_messages(&self) -> Vec<String> {
        self.devices.iter().flat_map(|device| device.validation_messages()).collect()
    }

    fn compile_ahead(&self, scene: &DeviceScene, features: &[Feature]) {
        self.devices.iter().for_each(|device| device.compile_ahead(scene, features));
    }

    fn load(&self, scene: &DeviceScene) -> Result<Box<dyn Session>, DeviceError> {
        let sessions = at_once(&self.devices, |device| device.load(scene))?;
        let members = sessions.into_iter().zip(&self.devices).map(|(session, device)| {
            let name = device.name();
            Member { name, session, rate: None, has_failed: false, failures: 0 }
        });
        let members = members.collect();
        let (width, height) = (scene.work.width, scene.work.height);
        Ok(Box::new(GroupSession { members, width, height, feature: Feature::Radiance, broken: None }))
    }
}

struct GroupSession {
    members: Vec<Member>,
    width: u32,
    height: u32,
    feature: Feature,
    /// Name of the member that has failed while others added their share: nobody knows which samples there are.
    broken: Option<String>,
}

/// A device's session and its speed.
struct Member {
    name: String,
    session: Box<dyn Session>,
    /// Samples per second as lately measured.
    rate: Option<f64>,
    /// Whether it has failed since all began anew.
    has_failed: bool,
    /// Number of times that it has failed.
    failures: u32,
}

/// Samples of rows.
#[derive(Clone, Debug, PartialEq)]
struct Piece {
    rows: Range<u32>,
    samples: Range<u32>,
}

/// Failures of a member after which the others go on without it.
const MOST_FAILURES: u32 = 2;
/// Weight of the last measurement of a device's speed beside those before.
const NEWEST: f64 = 0.5;
/// Shortest time that says something about a device's speed, in seconds.
const SHORTEST_MEASURE: f64 = 1e-3;

impl Member {
    /// Adds the samples of `pieces`; none of them takes longer than the device has patience for.
    fn add(&mut self, pieces: &[Piece], width: u32) -> Result<(), DeviceError> {
        let start = Instant::now();
        let mut total = 0.0;
        for Piece { rows, samples } in pieces {
            let pixels = f64::from(width) * rows.len() as f64;
            let affordable = self.rate.map_or(f64::INFINITY, |rate| rate * self.session.patience_seconds() / pixels);
            for first in samples.clone().step_by(affordable.clamp(1.0, f64::from(u32::MAX)) as usize) {
                let end = samples.end.min(first.saturating_add(affordable.max(1.0) as u32));
                match self.session.add_samples(rows.clone(), first..end) {
                    // Less of it may fit.
                    Err(error) if error.is_out_of_memory() => self.add_row_by_row(rows.clone(), first..end)?,
                    added => added?,
                }
            }
            total += pixels * samples.len() as f64;
        }
        let seconds = start.elapsed().as_secs_f64();
        if seconds > SHORTEST_MEASURE {
            let measured = total / seconds;
            self.rate = Some(self.rate.map_or(measured, |rate| rate + NEWEST * (measured - rate)));
        }
        Ok(())
    }

    fn add_row_by_row(&mut self, rows: Range<u32>, samples: Range<u32>) -> Result<(), DeviceError> {
        for row in rows {
            for sample in samples.clone() {
                self.session.add_samples(row..row + 1, sample..sample + 1)?;
            }
        }
        Ok(())
    }

    /// Begins anew with `scene`, opened again where it was lost. Returns what has been done about a failure, in words.
    fn begin_anew(&mut self, scene: &DeviceScene) -> Result<Option<String>, DeviceError> {
        let has_failed = std::mem::take(&mut self.has_failed);
        let restart = |session: &mut dyn Session| session.restart(scene).and_then(|()| session.show(Feature::Radiance));
        if !has_failed && restart(&mut *self.session).is_ok() {
            return Ok(None);
        }
        self.failures += 1;
        if self.failures >= MOST_FAILURES {
            return Err(DeviceError::Host("it has failed before".into()));
        }
        let done = self.session.revive(scene)?;
        Ok(Some(format!("{}: {done}", self.name)))
    }
}

impl GroupSession {
    fn check(&self) -> Result<(), DeviceError> {
        let broken =
            |name| DeviceError::Host(format!("{name} has failed, and the samples of the others are not whole"));
        self.broken.as_ref().map_or(Ok(()), |name| Err(broken(name)))
    }

    /// Part of the work for each member, so that all end at once: whoever has not been measured is taken for average.
    fn shares(&self) -> Vec<f64> {
        let known: Vec<f64> = self.members.iter().filter_map(|member| member.rate).collect();
        let average = if known.is_empty() { 1.0 } else { known.iter().sum::<f64>() / known.len() as f64 };
        self.members.iter().map(|member| member.rate.unwrap_or(average)).collect()
    }

    fn sessions(&mut self) -> impl Iterator<Item = &mut Box<dyn Session>> {
        self.members.iter_mut().map(|member| &mut member.session)
    }

    /// Gathers all samples in the first member's film.
    fn gather(&mut self) -> Result<(), DeviceError> {
        let film = self.film()?;
        self.set_film(&film)
    }
}

impl Session for GroupSession {
    fn show(&mut self, feature: Feature) -> Result<(), DeviceError> {
        let before = self.feature;
        let shown = self.sessions().try_for_each(|session| session.show(feature));
        if shown.is_err() {
            // All show the same film, whatever happens; that of before is there.
            self.sessions().try_for_each(|session| session.show(before))?;
        } else {
            self.feature = feature;
        }
        shown
    }

    fn prepare(&mut self) -> Result<(), DeviceError> {
        at_once(&mut self.members, |member| member.session.prepare()).map(|_| ())
    }

    fn is_prepared(&self) -> bool {
        self.members.iter().all(|member| member.session.is_prepared())
    }

    fn prepare_ahead(&mut self) -> Result<(), DeviceError> {
        self.sessions().try_for_each(|session| session.prepare_ahead())
    }

    fn accept_general(&mut self) {
        self.sessions().for_each(|session| session.accept_general());
    }

    fn tracer(&self) -> Option<Tracer> {
        let first = self.members.first()?.session.tracer();
        first.filter(|_| self.members.iter().all(|member| member.session.tracer() == first))
    }

    fn compile_time(&self) -> Duration {
        self.members.iter().map(|member| member.session.compile_time()).max().unwrap_or_default()
    }

    fn add_samples_until(
        &mut self,
        rows: Range<u32>,
        samples: Range<u32>,
        _: &(dyn Fn() -> bool + Sync),
    ) -> Result<u32, DeviceError> {
        // Nobody is stopped: of the others' samples none may be missing in the rows that are done.
        self.check()?;
        let (count, width) = (rows.len() as u32, self.width);
        let parts = divide(rows, samples, &self.shares());
        let work: Vec<_> = self.members.iter_mut().zip(parts).collect();
        let added = at_once(work, |(member, pieces)| {
            member.add(&pieces, width).map_err(|error| {
                member.has_failed = true;
                (member.name.clone(), error)
            })
        });
        added.map(|_| count).map_err(|(name, error)| {
            self.broken = Some(name);
            error
        })
    }

    fn set_film(&mut self, film: &Film) -> Result<(), DeviceError> {
        let empty = Film::new(self.width, self.height);
        let films = std::iter::once(film).chain(std::iter::repeat(&empty));
        self.sessions().zip(films).try_for_each(|(session, film)| session.set_film(film))
    }

    fn rest(&mut self, blocks: Option<&Blocks>) -> Result<(), DeviceError> {
        self.sessions().try_for_each(|session| session.rest(blocks))
    }

    fn restart(&mut self, scene: &DeviceScene) -> Result<(), DeviceError> {
        // Until all have the scene, none of them is any use.
        self.broken = Some("a device".into());
        at_once(&mut self.members, |member| member.session.restart(scene))?;
        (self.width, self.height, self.broken) = (scene.work.width, scene.work.height, None);
        Ok(())
    }

    fn revive(&mut self, scene: &DeviceScene) -> Result<String, DeviceError> {
        self.broken = Some("a device".into());
        let members = std::mem::take(&mut self.members);
        let begun = at_once(members, |mut member| Ok::<_, DeviceError>((member.begin_anew(scene), member)))?;
        if begun.iter().all(|(begun, _)| begun.is_err()) {
            let (failures, members): (Vec<_>, _) = begun.into_iter().unzip();
            self.members = members;
            let failure = failures.into_iter().find_map(Result::err);
            return Err(failure.unwrap_or_else(|| DeviceError::Host("there is no device".into())));
        }
        let mut done = vec![];
        for (begun, member) in begun {
            match begun {
                Ok(words) => {
                    done.extend(words);
                    self.members.push(member);
                }
                Err(error) => done.push(format!("the others go on without {}, for {error}", member.name)),
            }
        }
        (self.width, self.height) = (scene.work.width, scene.work.height);
        (self.feature, self.broken) = (Feature::Radiance, None);
        Ok(if done.is_empty() { "all devices begin anew".into() } else { done.join(", ") })
    }

    fn may_be_lost(&self) -> bool {
        // With any of its members.
        true
    }

    fn set_reference(&mut self, reference: Option<&Image>) -> Result<(), DeviceError> {
        // The first member alone displays.
        self.members[0].session.set_reference(reference)
    }

    fn display(&mut self, display: Display) -> Result<Pixels, DeviceError> {
        self.gather()?;
        self.members[0].session.display(display)
    }

    fn pixels(&self, columns: Range<u32>, y: u32) -> Result<Vec<FilmPixel>, DeviceError> {
        self.check()?;
        let mut sums = vec![FilmPixel::default(); columns.len()];
        for member in &self.members {
            let pixels = member.session.pixels(columns.clone(), y)?;
            sums.iter_mut().zip(&pixels).for_each(|(sum, pixel)| sum.merge(pixel));
        }
        Ok(sums)
    }

    fn film(&self) -> Result<Film, DeviceError> {
        self.check()?;
        let mut sum = Film::new(self.width, self.height);
        for member in &self.members {
            sum.merge(&member.session.film()?).map_err(|error| DeviceError::Host(error.to_string()))?;
        }
        Ok(sum)
    }

    fn ask(&mut self, probe: Probe, questions: &[Question]) -> Result<Vec<Answer>, DeviceError> {
        self.members[0].session.ask(probe, questions)
    }

    fn rows_at_once(&self) -> u32 {
        self.members.iter().map(|member| member.session.rows_at_once()).sum()
    }

    fn patience_seconds(&self) -> f64 {
        // Long enough that waiting for the slowest costs little; each member's own calls are as short as it needs.
        0.2
    }
}

/// Calls `work` for all items, each on a thread of its own, and returns its results; the first error if there is one.
fn at_once<I: IntoIterator, T: Send, E: Send>(
    items: I,
    work: impl Fn(I::Item) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E>
where
    I::Item: Send,
{
    let work = &work;
    std::thread::scope(|scope| {
        let threads: Vec<_> = items.into_iter().map(|item| scope.spawn(move || work(item))).collect();
        let results: Vec<_> = threads.into_iter().map(std::thread::ScopedJoinHandle::join).collect();
        results.into_iter().map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    })
}

/// The samples of rows in parts as large as `shares` say: each a run of rows in the order of samples, then rows, so that
/// most of it is whole pictures of samples, which devices do fastest.
fn divide(rows: Range<u32>, samples: Range<u32>, shares: &[f64]) -> Vec<Vec<Piece>> {
    let height = rows.len() as u64;
    let all = height * samples.len() as u64;
    let sum: f64 = shares.iter().sum();
    let mut end = 0.0;
    let mut next = 0;
    let last = shares.len() - 1;
    let mut parts = vec![];
    for (i, share) in shares.iter().enumerate() {
        end += share / sum * all as f64;
        let run = next..if i == last { all } else { (end.round() as u64).clamp(next, all) };
        next = run.end;
        parts.push(pieces(&rows, &samples, run));
    }
    parts
}

/// A run of rows in the order of samples, then rows: what is left of a sample, whole samples, and the beginning of one.
fn pieces(rows: &Range<u32>, samples: &Range<u32>, run: Range<u64>) -> Vec<Piece> {
    let height = rows.len() as u64;
    let place = |at: u64| (samples.start + (at / height) as u32, rows.start + (at % height) as u32);
    let ((first, first_row), (last, last_row)) = (place(run.start), place(run.end));
    let piece = |rows: Range<u32>, samples: Range<u32>| Piece { rows, samples };
    let pieces = if first == last {
        vec![piece(first_row..last_row, first..first + 1)]
    } else {
        let whole = if first_row == rows.start { first } else { first + 1 };
        vec![
            piece(first_row..rows.end, first..whole),
            piece(rows.clone(), whole..last),
            piece(rows.start..last_row, last..last + 1),
        ]
    };
    pieces.into_iter().filter(|piece| !piece.rows.is_empty() && !piece.samples.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_each_sample_once() {
        for (rows, samples) in [(0..1, 0..1), (3..10, 5..6), (0..7, 0..3), (2..9, 10..23), (0..64, 0..100)] {
            for shares in [vec![1.0], vec![1.0, 1.0], vec![1.0, 50.0, 3.0], vec![1e-9, 1.0], vec![1.0; 9]] {
                let parts = divide(rows.clone(), samples.clone(), &shares);
                assert_eq!(parts.len(), shares.len());
                let mut found: Vec<(u32, u32)> = parts
                    .iter()
                    .flatten()
                    .flat_map(|piece| {
                        piece.samples.clone().flat_map(|sample| piece.rows.clone().map(move |row| (sample, row)))
                    })
                    .collect();
                found.sort_unstable();
                let all: Vec<_> = samples.clone().flat_map(|s| rows.clone().map(move |row| (s, row))).collect();
                assert_eq!(found, all);
            }
        }
    }

    #[test]
    fn parts_are_as_large_as_their_shares() {
        let parts = divide(0..64, 0..100, &[3.0, 1.0]);
        let size = |part: &[Piece]| part.iter().map(|p| p.rows.len() * p.samples.len()).sum::<usize>();
        assert_eq!(parts.iter().map(|part| size(part)).collect::<Vec<_>>(), [4800, 1600]);
        // Whole pictures of samples, where the shares are such.
        assert_eq!(parts[1], [Piece { rows: 0..64, samples: 75..100 }]);
    }
}

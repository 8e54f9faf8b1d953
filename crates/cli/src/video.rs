//! Videos of frames, which ffmpeg encodes.

use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use raggio_render::{DisplayedImage, FrameRate, ImageFile, OutputFile};
use raggio_scene::display_name;

use crate::error::Failure;
use crate::files::{Files, output_file};
use crate::signals::Stopped;

/// Program that encodes, by its name on the PATH.
const FFMPEG: &str = "ffmpeg";
/// Encoder of H.264 that it has to have.
const ENCODER: &str = "libx264";

/// Video to be made.
pub struct Video {
    file: OutputFile,
    rate: FrameRate,
}

impl Video {
    /// Finds out, before any time is spent, whether the video can be made and written.
    pub fn new(path: &Path, rate: FrameRate) -> Result<Self, Failure> {
        if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mp4")) {
            return Err(Failure::Input(format!("--video {}: the ending must be .mp4", display_name(path))));
        }
        let file = output_file(path)?;
        if file.place().is_none() {
            return Err(Failure::Input(format!("--video {} is a device: give a file", display_name(path))));
        }
        let encoders = Command::new(FFMPEG).args(["-hide_banner", "-encoders"]).stdin(Stdio::null()).output();
        let encoders = encoders.map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => Failure::Input(
                "--video needs the program ffmpeg, which is not on the PATH: install it, or leave --video out".into(),
            ),
            _ => Failure::Input(format!("--video needs the program ffmpeg, which does not start: {error}")),
        })?;
        if !String::from_utf8_lossy(&encoders.stdout).split_whitespace().any(|word| word == ENCODER) {
            return Err(Failure::Input(format!(
                "--video needs an ffmpeg with the encoder {ENCODER}, which the one on the PATH lacks"
            )));
        }
        Ok(Self { file, rate })
    }

    pub fn file(&self) -> &OutputFile {
        &self.file
    }

    /// Makes the video of the frames, whose files are all there, unless a signal comes.
    pub fn make(&self, frames: &[&Files], stopped: &Stopped) -> Result<(), Failure> {
        let mut failure = None;
        let written = self.file.write_by(|to| {
            self.encode(frames, to, stopped).map_err(|error| {
                failure = Some(error);
                io::ErrorKind::Other.into()
            })
        });
        match (failure, written) {
            (Some(failure), _) => Err(failure),
            (None, written) => written.map_err(|error| self.failed(&error)),
        }
    }

    fn failed(&self, reason: &dyn std::fmt::Display) -> Failure {
        Failure::Unwritten(format!("cannot write {}: {reason}", display_name(self.file.path())))
    }

    fn encode(&self, frames: &[&Files], to: &Path, stopped: &Stopped) -> Result<(), Failure> {
        let mut encoder: Option<(Child, [usize; 2])> = None;
        let mut fed = Ok(());
        for files in frames {
            if let Some(signal) = stopped.signal() {
                if let Some((mut child, _)) = encoder {
                    let _ = child.kill();
                    let _ = child.wait();
                }
                return Err(Failure::Interrupted(signal));
            }
            let frame = evened(read(files)?);
            let size = [frame.width, frame.height];
            if encoder.is_none() {
                encoder = Some((self.start(size, to).map_err(|error| self.failed(&error))?, size));
            }
            let Some((child, first)) = &mut encoder else { break };
            if size != *first {
                fed = Err(io::Error::other("its frames have different sizes"));
                break;
            }
            fed = child.stdin.as_mut().map_or(Ok(()), |stdin| stdin.write_all(&frame.pixels));
            if fed.is_err() {
                break;
            }
        }
        let Some((mut child, _)) = encoder else { return Ok(()) };
        // Its end is the end of the video.
        drop(child.stdin.take());
        let mut said = String::new();
        let _ = child.stderr.take().map(|mut errors| errors.read_to_string(&mut said));
        let status = child.wait().map_err(|error| self.failed(&error))?;
        match fed {
            _ if !status.success() => {
                let last = said.lines().rfind(|line| !line.trim().is_empty()).map(|line| display_name(line.as_ref()));
                Err(self.failed(&format!("ffmpeg has failed: {}", last.unwrap_or_else(|| status.to_string()))))
            }
            fed => fed.map_err(|error| self.failed(&error)),
        }
    }

    /// Starts ffmpeg, which then waits for frames.
    fn start(&self, [width, height]: [usize; 2], to: &Path) -> io::Result<Child> {
        let mut command = Command::new(FFMPEG);
        command.args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"]);
        command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &self.rate.per_second().to_string(), "-i", "-"]);
        // High definition's matrix, said and used, so that players show the colours of the pictures.
        command.args(["-vf", "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"]);
        command.args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"]);
        command.args(["-color_range", "tv", "-c:v", ENCODER, "-preset", "medium", "-crf", "16"]);
        command.args(["-movflags", "+faststart", "-f", "mp4"]).arg(to);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()
    }
}

/// Reads a frame as it is looked at: without its noise if it is there so, and as a PNG if it is there as one.
fn read(files: &Files) -> Result<DisplayedImage, Failure> {
    let shown = |files: &[ImageFile]| files.iter().min_by_key(|file| !file.is_png()).cloned();
    let Some(file) = shown(&files.denoised).or_else(|| shown(&files.pictures)) else {
        return Err(Failure::Input("there is no picture for the video".into()));
    };
    let frame = DisplayedImage::load(file.path(), files.display);
    frame.map_err(|error| Failure::Input(format!("the video lacks a frame: {error}")))
}

/// The picture with an even number of rows and columns, as yuv420p has them: odd ones get one more, a copy of the last.
fn evened(DisplayedImage { width, height, pixels }: DisplayedImage) -> DisplayedImage {
    let [even_width, even_height] = [width, height].map(|side| side.next_multiple_of(2));
    if [even_width, even_height] == [width, height] {
        return DisplayedImage { width, height, pixels };
    }
    let mut evened = Vec::with_capacity(3 * even_width * even_height);
    for y in 0..even_height {
        let row = &pixels[3 * width * y.min(height - 1)..][..3 * width];
        evened.extend_from_slice(row);
        if even_width > width {
            evened.extend_from_slice(&row[3 * (width - 1)..]);
        }
    }
    DisplayedImage { width: even_width, height: even_height, pixels: evened }
}

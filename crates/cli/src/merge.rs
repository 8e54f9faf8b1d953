//! The command `raggio merge`: films in, their sum out.

use raggio_render::{Display, Film, Picture};
use raggio_scene::{counted, display_name};

use crate::args::MergeArguments;
use crate::error::Failure;
use crate::files::{Files, Wanted, denoiser};
use crate::output::say;
use crate::run::{both, write};

/// Runs `raggio merge`.
pub fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let tell = |line: &str| {
        if !arguments.quiet {
            say(line);
        }
    };
    let look = &arguments.look;
    let wanted = Wanted {
        pictures: &arguments.output,
        png_bits: look.png_bits,
        display: Display { exposure: look.exposure, tone_mapper: look.tone_mapper, ..Display::default() },
        has_layers: false,
        denoise: arguments.denoise,
        stats: None,
        checkpoint: None,
    };
    let files = Files::new(&wanted, &arguments.films)?;
    let denoiser = denoiser(wanted.denoise)?;

    let [first, others @ ..] = &arguments.films[..] else {
        return Err(Failure::Input("there is no film to merge".into()));
    };
    let mut film = Film::read(first)?;
    for path in others {
        let added = film.merge(&Film::read(path)?);
        added.map_err(|error| Failure::Input(format!("cannot add {}: {error}", display_name(path))))?;
    }
    for missing in film.missing() {
        tell(&format!("warning: {} are missing", missing.within(film.height())));
    }
    if film.lacks_coverage() {
        tell(
            "warning: the background is left out and there is no alpha in its place: films that are not finished, as checkpoints, \
             have none",
        );
    }
    let (fewest, most) = film.sample_range();
    let range = if fewest < most { format!("{fewest} to ") } else { String::new() };
    let films = counted(arguments.films.len(), "film");
    tell(&format!("{films}, {range}{} per pixel", counted(most as usize, "sample")));

    let picture = Picture::of_film(film);
    let mut outcome = write(&picture, &files.pictures, files.display, &tell);
    if let Some(denoiser) = &denoiser {
        tell("denoising");
        let denoised = picture.denoised(denoiser).map_err(Failure::from);
        outcome = both(outcome, denoised.and_then(|picture| write(&picture, &files.denoised, files.display, &tell)));
    }
    outcome
}

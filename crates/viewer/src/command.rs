//! What can be done to the viewer: panels, keys and scripts all say it in these words.

use std::path::PathBuf;

use raggio_render::{Comparison, ToneMapper, View};
use raggio_scene::{Camera, Environment, Geometry, Material, Placement, RenderSettings};

use crate::look::Look;
use crate::navigation::Preset;

/// One thing to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Changes the scene.
    Edit(Edit),
    /// The control that was being dragged is let go: the next edit is an undo step of its own.
    EndGesture,
    /// Takes the last edit back.
    Undo,
    /// Does again what was taken back.
    Redo,
    /// Writes the scene to its file, or to another.
    Save(Option<PathBuf>),
    /// Reads the scene's file again.
    Reload,
    /// Shows another scene, or compares with a picture: whatever the file is.
    Open(PathBuf),
    /// Moves the camera.
    Navigate(Navigate),
    /// How the mouse moves the camera.
    Preset(Preset),
    /// Flies so many times as fast.
    Speed(f32),
    /// How radiance is shown.
    Look(Look),
    /// What of the film is shown.
    View(View),
    /// Stops: each doubles the brightness.
    Exposure(f32),
    /// The curve from radiance to the display.
    Tones(ToneMapper),
    /// Shows the picture without its noise, or as it is.
    Denoise(bool),
    /// How the reference is compared with.
    Compare(Comparison),
    /// Compares with the picture in this file, or with none.
    Reference(Option<PathBuf>),
    /// Chooses a shape, by its place in the scene's list.
    Select(Option<usize>),
    /// One shape less.
    RemoveSelected,
    /// A copy of the chosen shape.
    DuplicateSelected,
    /// Stops sampling, or goes on.
    Pause,
    /// Begins the average anew.
    Restart,
    /// Stops at so many samples per pixel.
    StopAt(Option<u32>),
    /// Samples per pixel and frame; `None`: as many as there is time for.
    SamplesPerFrame(Option<u32>),
    /// The picture is as large as the window leaves room for, or as the scene says.
    SceneSize(bool),
    /// Writes the picture to a file.
    Export(ExportRequest),
    /// Gives up an export that is being rendered.
    CancelExport,
    /// Writes what the window shows to a file; `None`: one with a free name.
    Screenshot(Option<PathBuf>),
    /// Shows or hides the panels.
    Panels,
    /// Shows or hides the table of keys.
    Help,
    /// Puts the camera on the clipboard, as text.
    CopyCamera,
    /// Takes the camera from this text.
    PasteCamera(String),
    /// Frames from here on belong to this section of the measurement.
    Section(Option<String>),
    /// Behaves as if the driver had reset the device.
    LoseDevice,
    /// Says that something could not be done.
    Complain(String),
    /// Closes the window.
    Quit,
}

/// A change of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Edit {
    /// A material, by its place in the scene's list.
    Material(usize, Material),
    /// A new material for a shape.
    NewMaterial { shape: usize },
    /// A shape and its material; shapes are counted as in the file.
    Shape(usize, Geometry, usize),
    /// Where a model stands, and its material unless that is its own.
    Model(usize, Placement, Option<usize>),
    /// A new shape, of this material if the scene has it.
    Add(Geometry, usize),
    /// The sky.
    Environment(Environment),
    /// The camera that the scene's file names.
    Camera(Camera),
    /// Size, depth and the like.
    Render(RenderSettings),
    /// One key of the file, as TOML.
    Key(String, String),
}

/// A movement of the camera.
#[derive(Clone, Debug, PartialEq)]
pub enum Navigate {
    /// There at once.
    Jump(Camera),
    /// There smoothly.
    Go(Camera),
    /// So many degrees around what the camera looks at.
    Orbit(f32),
    /// To the scene's own camera.
    Home,
    /// So that this shape fills the picture.
    FocusOn(usize),
    /// The point of the picture (0 to 1 from the top left) becomes sharp.
    FocusAt([f32; 2]),
    /// Looks in this direction.
    From([f32; 3]),
    /// Remembers the view under this number, 1 to 9.
    Store(usize),
    /// Goes to the view of this number.
    Recall(usize),
}

/// A picture to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportRequest {
    /// Ends in .png or .exr.
    pub path: PathBuf,
    /// In pixels; `None`: the picture's own.
    pub size: Option<[u32; 2]>,
    /// Per pixel; `None`: those it has.
    pub samples: Option<u32>,
}

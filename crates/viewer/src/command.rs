//! Commands to the viewer, the words that panels, keys and scripts share.

use std::path::PathBuf;

use raggio_render::{Comparison, ToneMapper, View};
use raggio_scene::{Camera, Environment, Geometry, LightEntry, Material, Medium, Placement, RenderSettings, Transform};

use crate::denoising::InMotion;
use crate::look::Look;
use crate::navigation::Preset;

/// A command to the viewer.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Changes the scene.
    Edit(Edit),
    /// Ends the gesture of a control that is let go: the next edit is an undo step of its own.
    EndGesture,
    /// Takes the last edit back.
    Undo,
    /// Redoes the edit that was taken back.
    Redo,
    /// Writes the scene to its file, or to another.
    Save(Option<PathBuf>),
    /// Reads the scene's file again.
    Reload,
    /// Shows another scene, or compares with a picture: whatever the file is.
    Open(PathBuf),
    /// Moves the camera.
    Navigate(Navigate),
    /// Chooses how the mouse moves the camera.
    Preset(Preset),
    /// Sets the speed of flying, in units a second.
    Speed(f32),
    /// Sets everything about how the film is shown.
    Look(Look),
    /// Chooses the quantity that is shown: radiance, normals, depth and the like.
    View(View),
    /// Sets the exposure in stops, each of which doubles the brightness.
    Exposure(f32),
    /// Chooses the tone mapper, the curve from radiance to the display.
    Tones(ToneMapper),
    /// Shows the picture without its noise, or as it is.
    Denoise(bool),
    /// Chooses whether it does so while the camera moves.
    DenoiseInMotion(InMotion),
    /// Chooses how the picture is compared with the reference.
    Compare(Comparison),
    /// Compares with the picture in this file, or with none.
    Reference(Option<PathBuf>),
    /// Selects a shape by its place in the scene's list; `None`: none.
    Select(Option<usize>),
    /// Removes the selected shape.
    RemoveSelected,
    /// Adds a copy of the selected shape.
    DuplicateSelected,
    /// Stops sampling, or goes on.
    Pause,
    /// Begins the average anew.
    Restart,
    /// Stops at so many samples per pixel; `None`: never.
    StopAt(Option<u32>),
    /// Sets the samples per pixel and frame; `None`: as many as there is time for.
    SamplesPerFrame(Option<u32>),
    /// Gives the picture the size that the scene says, or that the window leaves room for.
    SceneSize(bool),
    /// Fills the window with the picture, or shows the scene's own frame.
    Fill(bool),
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
    /// Begins a section of the measurement, to which frames from here on belong; `None`: they belong to none.
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
    /// A copy of a shape's material, for that shape alone.
    NewMaterial { shape: usize },
    /// A shape and its material; shapes are counted as in the file.
    Shape(usize, Geometry, usize),
    /// A model's placement, and its material unless that is its own.
    Model(usize, Placement, Option<usize>),
    /// The material of all shapes of a group, or `None` for their own.
    Group(usize, Option<usize>),
    /// The transform of a shape or of a group.
    Transform(usize, Transform),
    /// A new shape, of this material if the scene has it.
    Add(Geometry, usize),
    /// A light of the file, by its place there.
    Light(usize, LightEntry),
    /// A new light.
    AddLight(LightEntry),
    /// A light of the file, by its place there, that is to be no more.
    RemoveLight(usize),
    /// The sky.
    Environment(Environment),
    /// Change of the medium that fills the scene, or with `None` its end.
    Air(Option<Medium>),
    /// The camera that the scene's file names.
    Camera(Camera),
    /// The settings of the picture: size, depth and the like.
    Render(RenderSettings),
    /// A key of the file by its path, and its value as TOML.
    Key(String, String),
}

/// A movement of the camera.
#[derive(Clone, Debug, PartialEq)]
pub enum Navigate {
    /// Moves to a camera at once.
    Jump(Camera),
    /// Moves to a camera smoothly.
    Go(Camera),
    /// Orbits so many degrees around the point that the camera looks at.
    Orbit(f32),
    /// Moves to the scene's own camera.
    Home,
    /// Moves so that this shape fills the picture.
    FocusOn(usize),
    /// Focuses on the point of the picture (0 to 1 from the top left).
    FocusAt([f32; 2]),
    /// Looks at the same point from this side.
    From([f32; 3]),
    /// Remembers the view under this number, 1 to 9.
    Store(usize),
    /// Goes to the view of this number.
    Recall(usize),
}

/// A picture to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportRequest {
    /// File to write, whose name ends in .png or .exr.
    pub path: PathBuf,
    /// Width and height in pixels; `None`: those of the picture that is shown.
    pub size: Option<[u32; 2]>,
    /// Samples per pixel; `None`: as many as the picture that is shown has.
    pub samples: Option<u32>,
}

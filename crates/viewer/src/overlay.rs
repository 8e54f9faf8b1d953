//! Overlay of the picture: the selected shape's box, and the notices.

use std::f64::consts::{PI, TAU};

use egui::{Align2, Area, Color32, Frame, Pos2, Rect, RichText, Stroke, Ui, pos2, vec2};
use raggio_scene::{Camera, Intrinsics, Projection, Vec3};

use crate::navigation::axes;
use crate::notices::Kind;
use crate::viewer::Viewer;

/// Colour around the picture: dark, and without a hue that would tinge what is seen beside it.
const SURROUND: Color32 = Color32::from_gray(0x1a);

/// Pieces of a line that is bent in a panorama.
const PIECES: usize = 32;

/// Rectangle of the picture in the room that the panels leave, in points.
pub fn place(room: Rect, viewer: &Viewer) -> Rect {
    let [width, height] = viewer.proportions(room.width(), room.height());
    Rect::from_center_size(room.center(), vec2(width, height))
}

/// Draws what is around the picture in `area`, up to the edges of `room`, and the selected shape's box over it.
pub fn show(ui: &Ui, room: Rect, area: Rect, viewer: &Viewer) {
    for side in around(room, area) {
        ui.painter().rect_filled(side, 0.0, SURROUND);
    }
    if let Some((low, high)) = viewer.outline {
        let painter = ui.painter().with_clip_rect(area);
        for line in edges(low, high) {
            for line in pieces(line, viewer.camera()).filter_map(|line| seen(line, viewer.camera(), area)) {
                painter.line_segment(line, Stroke::new(3.0, Color32::from_black_alpha(120)));
                painter.line_segment(line, Stroke::new(1.2, Color32::from_rgb(0xff, 0xb0, 0x40)));
            }
        }
    }
}

/// What `area` leaves of `room`, above, below, to the left and to the right.
fn around(room: Rect, area: Rect) -> [Rect; 4] {
    [
        Rect::from_min_max(room.min, pos2(room.right(), area.top())),
        Rect::from_min_max(pos2(room.left(), area.bottom()), room.max),
        Rect::from_min_max(pos2(room.left(), area.top()), area.left_bottom()),
        Rect::from_min_max(area.right_top(), pos2(room.right(), area.bottom())),
    ]
}

/// Draws the notices at the bottom left of `room`.
pub fn notices(ui: &Ui, room: Rect, viewer: &mut Viewer) {
    let mut dismissed = None;
    let corner = room.left_bottom() + vec2(12.0, -12.0);
    Area::new("notices".into()).pivot(Align2::LEFT_BOTTOM).fixed_pos(corner).show(ui.ctx(), |ui| {
        ui.set_max_width((room.width() - 24.0).clamp(120.0, 620.0));
        for (index, notice) in viewer.notices.current().iter().enumerate() {
            let color = match notice.kind {
                Kind::Done | Kind::Ongoing => Color32::from_rgb(0xd8, 0xd8, 0xd4),
                Kind::Warning | Kind::Scene => Color32::from_rgb(0xff, 0xd0, 0x70),
                Kind::Error | Kind::Fault => Color32::from_rgb(0xff, 0x90, 0x80),
            };
            ui.set_opacity(notice.opacity());
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.horizontal(|ui| {
                    if !matches!(notice.kind, Kind::Done | Kind::Ongoing) && ui.small_button("x").clicked() {
                        dismissed = Some(index);
                    }
                    ui.add(egui::Label::new(RichText::new(&notice.text).color(color)).wrap());
                });
            });
        }
    });
    if let Some(index) = dismissed {
        viewer.notices.dismiss(index);
    }
}

/// The twelve edges of a box.
fn edges(low: Vec3, high: Vec3) -> impl Iterator<Item = [Vec3; 2]> {
    let corner = move |i: usize| {
        let side = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Vec3::new(side(0), side(1), side(2))
    };
    (0..8).flat_map(move |i| {
        (0..3).filter(move |axis| i >> axis & 1 == 0).map(move |axis| [corner(i), corner(i | 1 << axis)])
    })
}

/// The line in pieces that are straight in the picture.
fn pieces([a, b]: [Vec3; 2], camera: &Camera) -> impl Iterator<Item = [Vec3; 2]> {
    let count = if camera.is_panoramic() { PIECES } else { 1 };
    (0..count).map(move |i| [i, i + 1].map(|end| a.lerp(b, end as f32 / count as f32)))
}

/// Projects a line of the scene into `area`; `None` if it is behind the camera, or around the edge of a panorama.
fn seen(line: [Vec3; 2], camera: &Camera, area: Rect) -> Option<[Pos2; 2]> {
    if camera.is_panoramic() {
        return seen_around(line, camera, area);
    }
    let axes = axes(camera);
    let from = camera.position.as_dvec3();
    let near = 1e-3 * f64::from((camera.look_at - camera.position).length());
    let [a, b] = line.map(|point| point.as_dvec3() - from);
    let [depth_a, depth_b] = [a.dot(axes.forward), b.dot(axes.forward)];
    if depth_a < near && depth_b < near {
        return None;
    }
    // The part behind the camera is cut off.
    let cut = a.lerp(b, (near - depth_a) / (depth_b - depth_a));
    let ends = [if depth_a < near { cut } else { a }, if depth_b < near { cut } else { b }];
    Some(ends.map(|point| {
        // Nothing grows smaller with the distance where rays are parallel.
        let depth = if camera.orthographic_height().is_none() { point.dot(axes.forward).max(near) } else { 1.0 };
        let [x, y] = in_heights(camera, point.dot(axes.right) / depth, point.dot(axes.up) / depth);
        area.center() + vec2(x as f32, -y as f32) * area.height()
    }))
}

/// Place in the picture of what is `x` to the right and `y` up at the distance 1, from the middle and in the picture's
/// heights.
fn in_heights(camera: &Camera, x: f64, y: f64) -> [f64; 2] {
    let Projection::Calibrated(Intrinsics { focal, principal_point, skew, size }) = camera.projection else {
        return [x, y].map(|at| at / (2.0 * camera.half_height()));
    };
    let [[fx, fy], [cx, cy], [width, height]] =
        [focal, principal_point, size.map(|side| side as f32)].map(|pair| pair.map(f64::from));
    let u = fx * x - f64::from(skew) * y + cx - 0.5 * width;
    let v = cy - fy * y - 0.5 * height;
    [u / height, -v / height]
}

/// Projects a short line into a panorama.
fn seen_around(line: [Vec3; 2], camera: &Camera, area: Rect) -> Option<[Pos2; 2]> {
    let axes = axes(camera);
    let [a, b] = line.map(|point| {
        let point = point.as_dvec3() - camera.position.as_dvec3();
        let [x, y, z] = [axes.right, axes.up, axes.forward].map(|axis| point.dot(axis));
        let [u, v] = [x.atan2(z) / TAU, y.atan2(x.hypot(z)) / PI];
        area.center() + vec2(u as f32 * area.width(), -v as f32 * area.height())
    });
    ((a.x - b.x).abs() < 0.5 * area.width()).then_some([a, b])
}

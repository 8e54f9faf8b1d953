//! Look of the panels: dark and quiet, for the picture is what matters.

use egui::{Color32, Context, CornerRadius, Stroke, Theme, Visuals};

/// Colour of controls that can be changed, and of what is chosen.
pub const ACCENT: Color32 = Color32::from_rgb(0xe8, 0x9c, 0x3c);

/// Sets the colours, whatever the system's are.
pub fn apply(ctx: &Context) {
    ctx.set_theme(Theme::Dark);
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_rgb(0x1c, 0x1d, 0x20);
    visuals.window_fill = Color32::from_rgb(0x22, 0x23, 0x27);
    visuals.extreme_bg_color = Color32::from_rgb(0x12, 0x13, 0x15);
    visuals.override_text_color = Some(Color32::from_rgb(0xd8, 0xd8, 0xd4));
    visuals.selection.bg_fill = Color32::from_rgb(0x6a, 0x4a, 0x20);
    visuals.selection.stroke = Stroke::new(1.0, ACCENT);
    visuals.hyperlink_color = ACCENT;
    for widget in [
        &mut visuals.widgets.noninteractive,
        &mut visuals.widgets.inactive,
        &mut visuals.widgets.hovered,
        &mut visuals.widgets.active,
    ] {
        widget.corner_radius = CornerRadius::same(3);
    }
    ctx.set_visuals_of(Theme::Dark, visuals);
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        style.spacing.slider_width = 140.0;
    });
}

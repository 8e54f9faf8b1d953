//! Colours as files store them, made linear.

/// Inverse of the sRGB transfer function (IEC 61966-2-1), for values of 0 to 1; others stay what they are.
pub(crate) fn linear_from_srgb(value: f32) -> f32 {
    if !(0.0..=1.0).contains(&value) {
        value
    } else if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// Decodes red, green and blue; alpha is coverage, which is linear everywhere.
pub(crate) fn make_linear(colors: &mut [[f32; 4]]) {
    for [r, g, b, _] in colors {
        for value in [r, g, b] {
            *value = linear_from_srgb(*value);
        }
    }
}

//! KTX2: Basis Universal, ASTC and uncompressed formats.
//!
//! The files in `data` were made by basisu 1.16 from one picture of 8 x 4 pixels: red at full alpha on the left, blue at
//! half alpha on the right; with mipmaps, but for `uastc.ktx2`.

use crate::common::{ETC1S, UASTC, UASTC_ZSTD, decoded, ktx2};
use raggio_images::{Limits, Problem, Texels, decode};

fn rgba8(bytes: &[u8]) -> Vec<[u8; 4]> {
    match decoded(bytes).texels {
        Texels::Rgba8(texels) => texels,
        _ => panic!("expected 8 bits"),
    }
}

#[test]
fn basis_universal_is_near_what_was_encoded() {
    // ETC1S has five bits a colour and alpha in steps, UASTC is exact for blocks of one colour.
    for (file, tolerance) in [(ETC1S, 8), (UASTC, 0), (UASTC_ZSTD, 0)] {
        let bitmap = decoded(file);
        assert_eq!((bitmap.width, bitmap.height), (8, 4));
        for (i, texel) in rgba8(file).iter().enumerate() {
            let expected = if i % 8 < 4 { [255, 0, 0, 255] } else { [0, 0, 255, 128] };
            assert!((0..4).all(|c| texel[c].abs_diff(expected[c]) <= tolerance), "{i}: {texel:?}");
        }
    }
}

/// A block of one colour: the header of a void extent, no extent, four 16-bit colours.
#[test]
fn astc_of_one_colour() {
    let mut block = vec![0xfc, 0xfd, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff];
    block.extend([0xffffu16, 0x8080, 0, 0x4040].iter().flat_map(|color| color.to_le_bytes()));
    let file = ktx2(157, 0, (4, 3), (162, 4), 16, &block, "rd");
    assert_eq!(rgba8(&file), [[255, 128, 0, 64]; 12]);
}

#[test]
fn uncompressed_formats() {
    let plain = |format, size, level: &[u8]| ktx2(format, 0, size, (1, 1), level.len() as u64, level, "rd");
    assert_eq!(rgba8(&plain(9, (2, 1), &[1, 2])), [[1, 0, 0, 255], [2, 0, 0, 255]]);
    assert_eq!(rgba8(&plain(16, (1, 1), &[1, 2])), [[1, 2, 0, 255]]);
    assert_eq!(rgba8(&plain(29, (1, 2), &[1, 2, 3, 4, 5, 6])), [[1, 2, 3, 255], [4, 5, 6, 255]]);
    assert_eq!(rgba8(&plain(43, (1, 1), &[1, 2, 3, 4])), [[1, 2, 3, 4]]);
    assert_eq!(rgba8(&plain(44, (1, 1), &[1, 2, 3, 4])), [[3, 2, 1, 4]]);
    let sixteen = decoded(&plain(91, (1, 1), &[1, 2, 0, 1, 255, 255, 4, 0]));
    assert!(sixteen.texels == Texels::Rgba16(vec![[0x201, 0x100, 0xffff, 4]]));
    let halves = [0x3c00u16, 0xbc00, 0x7c00, 0x3c00].map(u16::to_le_bytes);
    let half = decoded(&plain(97, (1, 1), halves.as_flattened()));
    assert!(half.texels == Texels::Rgb32F(vec![[1.0, 0.0, 65504.0]]));
    let floats = [0.5, f32::NAN, f32::INFINITY].map(f32::to_le_bytes);
    let float = decoded(&plain(106, (1, 1), floats.as_flattened()));
    assert!(float.texels == Texels::Rgb32F(vec![[0.5, 0.0, f32::MAX]]));
}

#[test]
fn zstandard_and_orientation() {
    // A frame of Zstandard with one raw block of eight bytes.
    let level = [1, 2, 3, 4, 5, 6, 7, 8];
    let frame = [&[0x28, 0xb5, 0x2f, 0xfd, 0x20, 8, 0x41, 0, 0], level.as_slice()].concat();
    assert_eq!(rgba8(&ktx2(43, 2, (1, 2), (1, 1), 8, &frame, "rd")), [[1, 2, 3, 4], [5, 6, 7, 8]]);
    assert_eq!(rgba8(&ktx2(43, 0, (1, 2), (1, 1), 8, &level, "ru")), [[5, 6, 7, 8], [1, 2, 3, 4]]);
}

#[test]
fn what_is_not_read_says_what_to_write() {
    let problem = |bytes: &[u8]| decode(bytes, &Limits::default()).unwrap_err().problem;
    let bc1 = ktx2(131, 0, (4, 4), (128, 4), 8, &[0; 8], "rd");
    assert!(matches!(problem(&bc1), Problem::Unsupported { reason, .. } if reason.contains("`ktx create`")));
    let zlib = ktx2(43, 3, (1, 1), (1, 1), 4, &[0; 8], "rd");
    assert!(matches!(problem(&zlib), Problem::Unsupported { reason, .. } if reason.contains("`ktx deflate --zstd`")));
    let mut cube = ktx2(43, 0, (1, 1), (1, 1), 4, &[0; 24], "rd");
    cube[36] = 6;
    assert!(matches!(problem(&cube), Problem::Unsupported { reason, .. } if reason.contains("cube map")));
    let short = ktx2(43, 0, (2, 2), (1, 1), 16, &[0; 15], "rd");
    assert!(matches!(problem(&short), Problem::Malformed { reason, .. } if reason.contains("15 bytes")));
}

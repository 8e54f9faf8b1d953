//! Hostile bytes never lead to a panic, and whatever is read fits together and is not much larger than the file.
//!
//! `RAGGIO_FUZZ_SECONDS` says how long each format is mutated; the default is two seconds.

use std::time::{Duration, Instant};

use proptest::collection::vec;
use proptest::prelude::*;
use raggio_models::{LoadOptions, MeshFile, ModelError, load, parse_mtl, parse_obj, parse_ply, parse_stl};

/// Reader of one format: bytes and the file's name in messages.
type Parse = fn(&[u8], &str) -> Result<MeshFile, ModelError>;

const FORMATS: [Parse; 3] = [parse_ply, parse_stl, parse_obj];

fn seeds() -> Vec<Vec<u8>> {
    let vertex = "property float x\nproperty float y\nproperty float z\n";
    let ascii = format!(
        "ply\nformat ascii 1.0\nelement vertex 5\n{vertex}property uchar red\nproperty uchar green\n\
         property uchar blue\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n\
         2 0 0 1 2 3\n1 1 0 1 2 3\n0 2 0 1 2 3\nnan 1 1 9 9 9\n4 0 1 2 3\n3 1 2 4\n"
    );
    let mut seeds = vec![ascii.into_bytes()];
    seeds.push(
        format!(
            "ply\nformat ascii 1.0\ncomment TextureFile a\nelement vertex 3\n{vertex}element face 1\n\
             property list uchar float texcoord\nproperty list uchar int vertex_indices\nelement tristrips 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n6 0 0 1 0 1 1\n3 0 1 2\n3 0 1 2"
        )
        .into_bytes(),
    );
    for kind in ["little", "big"] {
        let header = format!(
            "ply\nformat binary_{kind}_endian 1.0\nelement vertex 3\n{vertex}element odd 1\n\
             property list int double d\nelement face 1\nproperty list uchar uchar vertex_indices\nelement tristrips 1\n\
             property list uchar char vertex_indices\nend_header\n"
        );
        let one = if kind == "big" { 1f32.to_be_bytes() } else { 1f32.to_le_bytes() };
        let zero = [0; 4];
        let body = [zero, zero, zero, one, zero, zero, zero, one, zero, zero].concat();
        seeds.push([header.as_bytes(), &body, &[3, 0, 1, 2, 4, 0, 1, 2, 0xff]].concat());
    }
    let mut stl = vec![b'x'; 80];
    stl.extend(2u32.to_le_bytes());
    stl.extend((0..100u8).map(|i| i.wrapping_mul(37)));
    seeds.push(stl);
    seeds.push(
        b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
          endsolid a\n"
            .to_vec(),
    );
    seeds.push(
        b"mtllib a.mtl\nv 0 0 0\nv 2 0 0 1 1 1\nv 1 1 0\nv 0 2 0\nvt 0 0\nvn 0 0 1\ng a\nusemtl m\nf 1/1/1 2//1 3 -1\\\n\
          \nusemtl n\nf 1 2 3\n"
            .to_vec(),
    );
    seeds.push(b"newmtl a\nKd 1 1 1\nTr 0.5\nd -halo 1\nmap_Kd -s 1 1 -bm 2 a b.png\nKs spectral a\n".to_vec());
    let colored = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\n{vertex}element face 2\nproperty uchar red\nproperty float green\n\
         property uchar blue\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n\
         0 0 0\n1 0 0\n0 1 0\n9 0.5 9 3 0 1 2 6 0 0 1 0 1 1\n8 0.5 9 3 0 1 2 0\n"
    );
    seeds.push(colored.into_bytes());
    seeds.push(
        b"# a\nSOLID a\rfacet\nouter loop\nvertex 0 0 0 ; b\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\n\
          endsolid a\nsolid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop"
            .to_vec(),
    );
    let smooth = "v 0 0 0\nv 2 0 0\nv 1 1 0\nv 0 2 1\ns 1\nf 1 2 3\ns -3\nf 1//0 3 4\nf 1/7 3 4\ns off\nf 1 2 4\n";
    seeds.push(smooth.as_bytes().to_vec());
    seeds.push(format!("\u{feff}{smooth}").encode_utf16().flat_map(u16::to_le_bytes).collect());
    seeds
}

fn check(model: &MeshFile, bytes: usize) {
    let mesh = &model.mesh;
    let vertices = mesh.positions.len();
    assert!(mesh.triangles.as_flattened().iter().all(|index| (*index as usize) < vertices));
    assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    assert!(mesh.normals.as_ref().is_none_or(|list| list.len() == vertices));
    assert!(mesh.normals.iter().flatten().flatten().all(|x| x.is_finite()));
    assert!(mesh.colors.as_ref().is_none_or(|list| list.len() == vertices));
    assert!(mesh.uvs.iter().flatten().all(|list| list.len() == vertices));
    assert_eq!(mesh.parts.iter().map(|part| part.triangles.len()).sum::<usize>(), mesh.triangles.len());
    assert!(mesh.positions.capacity() <= 2 * bytes + 64 && mesh.triangles.capacity() <= 2 * bytes + 64);
}

fn read_all(bytes: &[u8]) {
    for parse in FORMATS {
        match parse(bytes, "a") {
            Ok(model) => check(&model, bytes.len()),
            Err(error) => assert!(!error.to_string().chars().any(char::is_control), "{error:?}"),
        }
    }
    let _ = parse_mtl(bytes, "a");
}

#[test]
fn truncated_at_every_length() {
    for seed in seeds() {
        (0..=seed.len()).for_each(|length| read_all(&seed[..length]));
    }
}

#[test]
fn seeds_are_valid() {
    let formats: [Parse; 7] = [parse_ply, parse_ply, parse_ply, parse_ply, parse_stl, parse_stl, parse_obj];
    let later: [Parse; 4] = [parse_ply, parse_stl, parse_obj, parse_obj];
    let seeds = seeds();
    for (seed, parse) in seeds.iter().zip(formats).chain(seeds[8..].iter().zip(later)) {
        assert!(!parse(seed, "a").unwrap().mesh.triangles.is_empty());
    }
}

#[test]
fn huge_counts_are_refused_before_memory_is_reserved() {
    for (from, to) in
        [("vertex 5", "vertex 18446744073709551615"), ("face 2", "face 9223372036854775807"), ("\n4 0", "\n4e18 0")]
    {
        let text = String::from_utf8(seeds().swap_remove(0)).unwrap().replace(from, to);
        let error = parse_ply(text.as_bytes(), "a").unwrap_err();
        assert!(error.message.contains("at most"), "{error}");
    }
}

#[test]
fn elements_without_properties_take_no_time() {
    let text = "ply\nformat ascii 1.0\nelement a 18446744073709551615\nelement vertex 0\nproperty float x\n\
                property float y\nproperty float z\nend_header\n";
    assert_eq!(parse_ply(text.as_bytes(), "a").unwrap().warnings.len(), 1);
}

/// Edges that cross everywhere are none that a sweep could follow; cutting ears would take hours without a budget.
#[test]
fn enormous_concave_polygons_end() {
    let count = 200_000;
    let mut text = String::new();
    for i in 0..count {
        text += &format!("v {} {} 0\n", i % 1000, (i * 7919) % 1009);
    }
    text += "f";
    (1..=count).for_each(|i| text += &format!(" {i}"));
    let model = parse_obj(text.as_bytes(), "a").unwrap();
    check(&model, text.len());
}

/// SplitMix64, a generator of random numbers.
struct Rng(u64);

impl Rng {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 32) as usize % count
    }
}

/// Makes one to eight changes: bytes replaced, words of the formats set in, parts removed or repeated.
fn mutate(bytes: &mut Vec<u8>, rng: &mut Rng) {
    const WORDS: [&str; 12] = [
        "-1",
        "0",
        "9",
        "4294967296",
        "1e99",
        "nan",
        "inf",
        " ",
        "\n",
        "/",
        "-s 2",
        "property list int int vertex_indices\n",
    ];
    for _ in 0..=rng.below(8) {
        if bytes.is_empty() {
            return;
        }
        let at = rng.below(bytes.len());
        let end = bytes.len().min(at + 1 + rng.below(24));
        match rng.below(5) {
            0 => bytes[at] = rng.below(256) as u8,
            1 => bytes[at] ^= 1 << rng.below(8),
            2 => drop(bytes.splice(at..end, [])),
            3 => {
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
            _ => drop(bytes.splice(at..at, WORDS[rng.below(WORDS.len())].bytes())),
        }
    }
}

/// Runs something that has to be over within a second; once more if it was not, because another program may have had the
/// processor meanwhile.
fn within_a_second(what: &str, run: impl Fn()) {
    let takes = || {
        let start = Instant::now();
        run();
        start.elapsed()
    };
    let limit = Duration::from_secs(1);
    let first = takes();
    if first >= limit {
        let second = takes();
        assert!(second < limit, "{what}: {first:?}, then {second:?}");
    }
}

/// Mutates files for a while; each run makes the same changes for as far as it gets.
fn fuzz(seeds: &[Vec<u8>], read: impl Fn(&[u8])) {
    let seconds = std::env::var("RAGGIO_FUZZ_SECONDS").ok().and_then(|seconds| seconds.parse().ok()).unwrap_or(2.0);
    let (mut rng, start, mut files) = (Rng(1), Instant::now(), 0u64);
    while start.elapsed().as_secs_f64() < seconds {
        let mut bytes = seeds[rng.below(seeds.len())].clone();
        mutate(&mut bytes, &mut rng);
        within_a_second(&format!("file {files}"), || read(&bytes));
        files += 1;
    }
    println!("{files} files");
}

#[test]
fn fuzz_ply() {
    fuzz(&[&seeds()[..4], &seeds()[8..9]].concat(), read_all);
}

#[test]
fn fuzz_stl() {
    fuzz(&[&seeds()[4..6], &seeds()[9..10]].concat(), read_all);
}

#[test]
fn fuzz_obj() {
    fuzz(&[&seeds()[6..7], &seeds()[10..]].concat(), read_all);
}

/// Libraries are read through the file system, so that materials are translated and textures looked for.
#[test]
fn fuzz_mtl() {
    let folder = tempfile::tempdir().unwrap();
    let object = folder.path().join("a.obj");
    std::fs::write(&object, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n").unwrap();
    for (name, size) in [("a.png", (3, 2)), ("b.png", (2, 5))] {
        image::RgbaImage::from_pixel(size.0, size.1, image::Rgba([9, 8, 7, 6])).save(folder.path().join(name)).unwrap();
    }
    let all = b"newmtl a\nKd 1 0 0\nmap_Kd -s 2 2 a.png\nmap_d b.png\nKs 1 1 1\nNs 9\nmap_Ks a.png\nPr 0.5\nPm 1\n\
        map_Pr a.png\nmap_Pm b.png\nNi 1.5\nTf 1 1 1\nd 0.5\nillum 7\nKe 1 1 1\nmap_Ke -clamp on b.png\nnorm -bm 2 a.png\n";
    let bumps = b"newmtl a\nTr 1\nmap_Bump -bm 2 A.PNG\nbump -clamp on C:\\x\\b.png\nmap_Kd \"../a.png\"\nNs nan\n";
    fuzz(&[all.to_vec(), bumps.to_vec(), seeds().swap_remove(7)], |bytes| {
        std::fs::write(folder.path().join("a.mtl"), bytes).unwrap();
        let model = load(&object, &LoadOptions::default()).expect("an object that is valid");
        let surface = &model.materials[0].surface;
        let numbers = [surface.alpha, surface.roughness, surface.metallic, surface.transmission, surface.clearcoat];
        assert!(numbers.iter().chain(&surface.base_color).all(|x| (0.0..=1.0).contains(x)), "{surface:?}");
        let positive = surface.emissive.iter().chain(&surface.specular_color);
        assert!(positive.chain([&surface.ior]).all(|x| x.is_finite() && *x >= 0.0), "{surface:?}");
        assert!(surface.base_color_texture.iter().all(|t| t.transform.as_flattened().iter().all(|x| x.is_finite())));
        assert!(!model.warnings.concat().chars().any(char::is_control));
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn mutated(
        seed in 0..12usize,
        changes in vec((any::<prop::sample::Index>(), any::<u8>(), 0..4u8), 1..8),
    ) {
        let mut bytes = seeds().swap_remove(seed);
        for (index, byte, kind) in changes {
            if bytes.is_empty() {
                break;
            }
            let at = index.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => bytes[at] = b"0123456789-/ \nnife.\xff"[byte as usize % 20],
                2 => bytes.insert(at, byte),
                _ => drop(bytes.remove(at)),
            }
        }
        read_all(&bytes);
    }

    #[test]
    fn arbitrary(bytes in vec(any::<u8>(), 0..300)) {
        read_all(&bytes);
    }
}

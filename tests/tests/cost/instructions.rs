//! Instructions that kernels run for a sample, as `valgrind --tool=callgrind` counts them: they tell worse code of the
//! compiler, which counts of rays and nodes do not.

use std::process::Command;

use raggio_kernels::cpu::COMPILER;
use raggio_render::{CpuDevice, CpuOptions, InstructionSet};
use raggio_scene::Integrator;
use raggio_tests::devices::{lacks, long};
use raggio_tests::render::load;

use crate::cost::scene;

/// Variable by which this program tells itself which scene to render under valgrind.
const SCENE: &str = "RAGGIO_TEST_INSTRUCTIONS_OF";
const SIZE: [u32; 2] = [96, 64];
const SAMPLES: u32 = 16;
/// Compiler that the figures are stated for.
const STATED_FOR: &str = "clang 19";
/// Relative difference to the stated figures that is allowed: releases of one version of the compiler may differ a little.
const TOLERANCE: f64 = 0.02;
/// Instructions of x86-64-v3, the highest level that valgrind knows, for a sample.
const STATED: [(&str, f64); 3] = [("cornell", 4810.0), ("weekend", 2744.0), ("rock", 1964.0)];

#[test]
fn samples_take_as_few_instructions_as_stated() {
    if let Ok(name) = std::env::var(SCENE) {
        return render(&name);
    }
    if !long() {
        return;
    }
    if !InstructionSet::available().contains(&InstructionSet::X86V3) {
        return lacks("instructions are stated for x86-64-v3, which this processor or this build does not have");
    }
    if !COMPILER.starts_with(STATED_FOR) {
        eprintln!("skipped: instructions are stated for {STATED_FOR}, and kernels are by {COMPILER}");
        return;
    }
    if !Command::new("valgrind").arg("--version").output().is_ok_and(|output| output.status.success()) {
        return lacks("valgrind, which counts instructions, is not installed: apt install valgrind");
    }
    for (name, stated) in STATED {
        let found = instructions(name) as f64 / f64::from(SIZE[0] * SIZE[1] * SAMPLES);
        assert!(
            (found - stated).abs() <= TOLERANCE * stated,
            "{name}: {stated} instructions of a sample are stated, and there are {found:.0}. If this is meant, and \
             `make bench` says that it is no slower, put it into tests/tests/cost/instructions.rs"
        );
    }
}

/// Renders on one thread, without what varies in length with the time that it takes.
fn render(name: &str) {
    let mut scene = scene(name);
    scene.render.integrator = Integrator::Path;
    [scene.render.width, scene.render.height] = SIZE;
    let options = CpuOptions { threads: 1, instruction_set: Some(InstructionSet::X86V3), ..CpuOptions::default() };
    let device = CpuDevice::new(options).expect("valgrind knows the level");
    let mut session = load(&device, &scene);
    session.add_samples(0..SIZE[1], 0..SAMPLES).expect("the device renders");
    let film = session.film().expect("the film can be read");
    assert!(film.pixels().iter().all(|pixel| pixel.samples == SAMPLES));
}

/// Runs this test in a process of its own, under valgrind, which counts while the path tracer's kernels run.
fn instructions(name: &str) -> u64 {
    let folder = tempfile::tempdir().expect("a folder");
    let program = std::env::current_exe().expect("this program has a path");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--toggle-collect=raggio_path_*v3"])
        .arg(format!("--callgrind-out-file={}", folder.path().join("counts").display()))
        .arg(program)
        .args(["--exact", "cost::instructions::samples_take_as_few_instructions_as_stated"])
        .env(SCENE, name)
        .output()
        .expect("valgrind runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{name}: valgrind fails:\n{}\n{said}", String::from_utf8_lossy(&output.stdout));
    let collected = said.lines().find_map(|line| line.split_once("Collected : "));
    let count = collected.and_then(|(_, count)| count.trim().parse().ok());
    count.unwrap_or_else(|| panic!("{name}: valgrind does not say how much it has collected:\n{said}"))
}

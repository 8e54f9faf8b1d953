//! The SPIR-V modules, by Khronos' validator.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// Both variants.
fn modules() -> [Cow<'static, [u8]>; 2] {
    [raggio_kernels::SPIRV.full, raggio_kernels::SPIRV.simple]
}

#[test]
fn spirv_is_valid() {
    modules().iter().for_each(|module| validate(module));
}

fn validate(module: &[u8]) {
    let from_setup = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.venv/bin/spirv-val");
    let validator = if from_setup.exists() { from_setup } else { "spirv-val".into() };
    let child = Command::new(&validator)
        .args(["--target-env", "vulkan1.2", "--scalar-block-layout", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(error) if std::env::var_os("RAGGIO_TEST_EVERYTHING").is_none() => {
            eprintln!("not checked: spirv-val is missing ({error}); `make setup` installs it");
            return;
        }
        Err(error) => panic!("spirv-val is missing: {error}"),
    };
    child.stdin.take().expect("a pipe").write_all(module).expect("spirv-val reads");
    let output = child.wait_with_output().expect("spirv-val ends");
    let messages = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&messages));
}

#[test]
fn kernels_need_no_optional_capability() {
    // Anything but `Shader` would have to be among the features that a device is checked for.
    const OP_CAPABILITY: u32 = 17;
    const SHADER: u32 = 1;
    for module in modules() {
        let words: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(&module);
        let mut rest = &words[5..];
        while let Some(&first) = rest.first() {
            if first & 0xffff == OP_CAPABILITY {
                assert_eq!(rest[1], SHADER, "capability {}", rest[1]);
            }
            rest = &rest[first as usize >> 16..];
        }
    }
}

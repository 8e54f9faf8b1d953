//! Validity of the SPIR-V modules, by Khronos' validator.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use raggio_kernels::{SPIRV, Variant};

/// SPIR-V of all variants, and the capabilities that they may need.
fn modules() -> impl Iterator<Item = (Vec<u8>, Vec<u32>)> {
    const SHADER: u32 = 1;
    const PHYSICAL_STORAGE_BUFFER_ADDRESSES: u32 = 5347;
    const RAY_QUERY: u32 = 4472;
    Variant::ALL.into_iter().map(|variant| {
        let wide = variant.is_wide().then_some(PHYSICAL_STORAGE_BUFFER_ADDRESSES);
        let queries = variant.has_queries().then_some(RAY_QUERY);
        (SPIRV.code(variant).to_vec(), [SHADER].into_iter().chain(wide).chain(queries).collect())
    })
}

#[test]
fn spirv_is_valid() {
    modules().for_each(|(module, _)| validate(&module));
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
fn kernels_need_no_other_capability() {
    // Any other capability would have to be among the features that a device is checked for.
    const OP_CAPABILITY: u32 = 17;
    for (module, known) in modules() {
        let words: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(&module);
        let mut rest = &words[5..];
        while let Some(&first) = rest.first() {
            if first & 0xffff == OP_CAPABILITY {
                assert!(known.contains(&rest[1]), "capability {}", rest[1]);
            }
            rest = &rest[first as usize >> 16..];
        }
    }
}

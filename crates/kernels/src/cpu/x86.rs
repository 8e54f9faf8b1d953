//! Levels of the instruction set x86-64; the build script asks for that of the machine that builds.

use std::arch::is_x86_feature_detected as has;

/// Highest of the levels x86-64-v1 to -v4 that this processor has, 1 to 4.
pub fn level() -> u32 {
    let v2 = has!("sse4.2") && has!("popcnt") && has!("cmpxchg16b");
    let v3 = v2
        && has!("avx2")
        && has!("fma")
        && has!("bmi1")
        && has!("bmi2")
        && has!("f16c")
        && has!("lzcnt")
        && has!("movbe");
    let v4 = v3 && has!("avx512f") && has!("avx512bw") && has!("avx512cd") && has!("avx512dq") && has!("avx512vl");
    1 + u32::from(v2) + u32::from(v3) + u32::from(v4)
}

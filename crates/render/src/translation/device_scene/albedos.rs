//! Tables of what rough surfaces lose to a single bounce, for all scenes; `kernels/materials/albedo.slang` reads them.

use std::sync::{Arc, OnceLock};

/// Tables that `scripts/tabulate_albedos.py` writes: numbers of 16 bits, little-endian, four to a node.
const TABLES: &[u8] = include_bytes!("albedos.bin");

/// The tables, shared among all scenes.
pub fn albedos() -> Arc<Vec<[u32; 2]>> {
    static SHARED: OnceLock<Arc<Vec<[u32; 2]>>> = OnceLock::new();
    SHARED.get_or_init(|| Arc::new(TABLES.as_chunks().0.iter().map(|node: &[u8; 8]| words(*node)).collect())).clone()
}

fn words([a, b, c, d, e, f, g, h]: [u8; 8]) -> [u32; 2] {
    [u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h])]
}

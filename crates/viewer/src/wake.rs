//! Frames that no input asks for.

use std::sync::Arc;

/// Makes a frame happen even though no input arrives.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

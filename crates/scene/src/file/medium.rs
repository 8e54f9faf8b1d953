//! Media that fill bodies, or the scene.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::number::{Asymmetry, NonNegative};

/// A homogeneous medium, which absorbs and scatters light: fog, smoke, milk, wax. After a distance d a part exp(-c d) of the
/// light is left, c the sum of `absorption` and `scattering`.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Medium")]
pub(crate) struct MediumFile {
    /// Part of the light that is absorbed per unit of length: a number, or red, green and blue.
    #[schemars(extend("default" = 0.0))]
    pub absorption: Option<CoefficientFile>,
    /// Part of the light that is scattered per unit of length: a number, or red, green and blue.
    #[schemars(extend("default" = 0.0))]
    pub scattering: Option<CoefficientFile>,
    /// Mean cosine of the angle by which light is scattered, as Henyey and Greenstein have it: 0 to all sides alike, towards 1 forward, towards -1 back.
    #[schemars(extend("default" = 0.0))]
    pub anisotropy: Option<Asymmetry>,
}

/// A coefficient per unit of length, for all colours or for each.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "must be a number, or three numbers, of 0 or more")]
#[schemars(rename = "Coefficient")]
pub(crate) enum CoefficientFile {
    /// Coefficient of all colours.
    Grey(NonNegative),
    /// Coefficients of red, green and blue.
    Colored([NonNegative; 3]),
}

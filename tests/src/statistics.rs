//! Chi-square tests.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Result of a chi-square test.
#[derive(Clone, Copy, Debug)]
pub struct ChiSquare {
    /// Sum of the squared deviations, each over its expectation.
    pub statistic: f64,
    /// Number of bins less one.
    pub degrees_of_freedom: f64,
    /// Probability of a statistic this large or larger if the expectation is true.
    pub p_value: f64,
}

/// Fewest counts that a bin must expect for its deviation to be about normal.
const FEWEST_EXPECTED: f64 = 5.0;

/// Compares counts with what was expected of them. Bins that expect too little are pooled; where nothing at all is
/// expected, one count is a failure.
pub fn chi_square(observed: &[u64], expected: &[f64]) -> ChiSquare {
    let pairs = || observed.iter().zip(expected).map(|(&o, &e)| (o as f64, e));
    let (statistic, bins) = pairs()
        .filter(|(_, e)| *e >= FEWEST_EXPECTED)
        .fold((0.0, 0.0), |(sum, bins), (o, e)| (sum + (o - e) * (o - e) / e, bins + 1.0));
    let (pooled_observed, pooled_expected) =
        pairs().filter(|(_, e)| *e < FEWEST_EXPECTED).fold((0.0, 0.0), |(a, b), (o, e)| (a + o, b + e));
    // A pool that itself expects too little is held against the count that it makes improbable.
    let pool = (pooled_observed - pooled_expected).powi(2) / pooled_expected.max(1.0);
    let has_pool = pooled_observed > 0.0 || pooled_expected > 0.0;
    let degrees_of_freedom = f64::max(bins + if has_pool { 1.0 } else { 0.0 } - 1.0, 1.0);
    let statistic = statistic + pool;
    let distribution = ChiSquared::new(degrees_of_freedom).expect("positive degrees of freedom");
    ChiSquare { statistic, degrees_of_freedom, p_value: distribution.sf(statistic) }
}

/// Significance of each of `tests` independent tests, for all of them together to fail by chance with probability
/// `overall` (Sidak).
pub fn sidak(overall: f64, tests: usize) -> f64 {
    1.0 - (1.0 - overall).powf(1.0 / tests as f64)
}

/// Collects p-values and judges them together.
#[derive(Default)]
pub struct Verdict {
    results: Vec<(String, ChiSquare)>,
}

impl Verdict {
    /// Adds the result of the test called `name`.
    pub fn add(&mut self, name: String, result: ChiSquare) {
        self.results.push((name, result));
    }

    /// Fails if any p-value is too small for as many as there are, at an overall significance of one in a thousand.
    pub fn assert_all(&self) {
        let significance = sidak(1e-3, self.results.len());
        let bad: Vec<_> = self.results.iter().filter(|(_, r)| r.p_value.is_nan() || r.p_value < significance).collect();
        assert!(
            bad.is_empty(),
            "{} of {} chi-square tests have p below {significance:.2e}:\n{bad:#?}",
            bad.len(),
            self.results.len()
        );
    }

    /// Least of the p-values.
    pub fn least(&self) -> f64 {
        self.results.iter().map(|(_, r)| r.p_value).fold(1.0, f64::min)
    }
}

//! Values that belong to each of a session's films.

use raggio_kernels::Feature;

/// A value for the film of radiance and, once it has been asked for, one for the film of another feature; one of the
/// two films is shown.
pub(crate) struct Films<F> {
    radiance: F,
    inspected: Option<(Feature, F)>,
    shown: Feature,
}

impl<F> Films<F> {
    pub fn new(radiance: F) -> Self {
        Self { radiance, inspected: None, shown: Feature::Radiance }
    }

    pub fn feature(&self) -> Feature {
        self.shown
    }

    /// Value of the film that is shown.
    pub fn shown(&self) -> &F {
        match &self.inspected {
            Some((feature, film)) if *feature == self.shown => film,
            _ => &self.radiance,
        }
    }

    pub fn shown_mut(&mut self) -> &mut F {
        match &mut self.inspected {
            Some((feature, film)) if *feature == self.shown => film,
            _ => &mut self.radiance,
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = &F> {
        std::iter::once(&self.radiance).chain(self.inspected.iter().map(|(_, film)| film))
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut F> {
        std::iter::once(&mut self.radiance).chain(self.inspected.iter_mut().map(|(_, film)| film))
    }

    /// Shows the film of `feature`. That of radiance is always kept, and of the others the last; any other begins
    /// empty.
    pub fn show<E>(&mut self, feature: Feature, empty: impl FnOnce() -> Result<F, E>) -> Result<(), E> {
        let known = self.inspected.as_ref().is_some_and(|(inspected, _)| *inspected == feature);
        if feature != Feature::Radiance && !known {
            // The old one goes first, for two may be all that memory holds.
            self.shown = Feature::Radiance;
            self.inspected = None;
            self.inspected = Some((feature, empty()?));
        }
        self.shown = feature;
        Ok(())
    }

    /// Makes new films in place of those that are needed; the feature that is shown stays.
    pub fn renew<E>(&mut self, mut empty: impl FnMut() -> Result<F, E>) -> Result<(), E> {
        let mut films = Self::new(empty()?);
        films.show(self.shown, empty)?;
        *self = films;
        Ok(())
    }
}

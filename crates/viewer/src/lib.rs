//! The window of raggio.

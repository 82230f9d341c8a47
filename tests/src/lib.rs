//! The suite of places.

//! What a division did, step by step: for saying how a parcel came to be.

use geom::{Id, Point};

/// One step of a division. Pieces are told apart by their place in it, which is the id of the parcel that they become.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DivisionStep {
    /// A piece was looked at: is it to be cut?
    Look {
        /// The piece.
        piece: Id,
        /// Its area, m².
        area: f64,
        /// Area up to which it was not to be cut, m².
        wanted: f64,
        /// What became of it.
        outcome: Looked,
    },
    /// After all cuts a piece joined a neighbour.
    Join {
        /// The piece.
        piece: Id,
        /// The neighbour, which goes on under its own name.
        to: Id,
        /// What the piece brought with it, m².
        area: f64,
        /// Whether both lie behind others and make one court; else the piece was too small or thin, or had no access.
        is_court: bool,
    },
    /// Nothing may be built on a piece.
    Open {
        /// The piece.
        piece: Id,
        /// Why.
        why: WhyOpen,
    },
}

/// What became of a piece that was looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Looked {
    /// It is as wanted.
    Kept,
    /// It is larger than wanted or too concave, but no cut leaves pieces that are large, compact and accessible enough.
    NoCut,
    /// It was cut in two.
    Cut {
        /// Where the cut begins and ends.
        ends: [Point; 2],
        /// What lies left and right of it.
        parts: [Id; 2],
    },
}

/// Why nothing may be built on a parcel that a division made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WhyOpen {
    /// Its area is below `least_area`.
    #[error("it is smaller than `least_area`")]
    Small,
    /// It is narrower than half of `least_frontage`.
    #[error("it is narrower than half of `least_frontage`")]
    Thin,
    /// It fronts no street for `least_frontage`.
    #[error("it fronts no street for `least_frontage`")]
    Landlocked,
    /// It has a hole.
    #[error("it has a hole")]
    Holed,
    /// It is many times larger than `most_area`.
    #[error("it is more than eight times `most_area`: no cut was possible")]
    Oversized,
    /// It fills too little of its convex hull.
    #[error("it fills less of its convex hull than `least_convexity`")]
    Concave,
}

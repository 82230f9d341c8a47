//! Identities of the things a street graph is made of. All come from lineage (see
//! [`geom::Id`]); crossings on rims hold a place besides.

use geom::{Id, Point};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What the id of a crossing on a rim is derived with.
const RIM: u128 = 0x0072_696d;

macro_rules! identity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
        pub struct $name(pub Id);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

identity!(
    /// A street: a named run of segments. User-made: (author, counter); grown: (parent street, branch slot).
    StreetId
);
identity!(
    /// A node: a shape point keeps the lineage it was drawn or grown with; a crossing of two streets is
    /// hash(unordered street pair, ordinal among their crossings), but on the rim of quarters hash(street of the rim,
    /// place): streets of both sides may end there, and each must find the same crossing without the other.
    NodeId
);
identity!(
    /// A segment: hash(street, start node, end node, level), so that a split leaves the ids of all later segments alone.
    SegmentId
);

impl NodeId {
    /// The crossing of two streets, the `ordinal`-th of theirs.
    pub fn crossing(a: StreetId, b: StreetId, ordinal: u64) -> Self {
        let (low, high) = if a <= b { (a, b) } else { (b, a) };
        Self(low.0.with(&[high.0.0, u128::from(ordinal)]))
    }

    /// A crossing on a street that closes quarters with one that does not; `ordinal` tells those of several levels at
    /// one place apart.
    pub fn on_rim(street: StreetId, at: Point, ordinal: u64) -> Self {
        let part = |coordinate: i32| u128::from(coordinate as u32);
        Self(street.0.with(&[RIM, part(at.x), part(at.y), u128::from(ordinal)]))
    }

    /// Whether it is a crossing that a street of a quarter made on a street at a place, on the ground or besides one on
    /// another level; not a bend or an end of that street.
    pub fn is_on_rim(self, street: StreetId, at: Point) -> bool {
        (0..2).any(|ordinal| Self::on_rim(street, at, ordinal) == self)
    }
}

impl SegmentId {
    /// The segment of a street between two of its nodes on a level.
    pub fn between(street: StreetId, start: NodeId, end: NodeId, level: i8) -> Self {
        Self(street.0.with(&[start.0.0, end.0.0, u128::from(level as u8)]))
    }
}

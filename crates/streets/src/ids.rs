//! Identities of the things a street graph is made of. All come from lineage (see [`geom::Id`]).

use geom::Id;
use serde::{Deserialize, Serialize};
use std::fmt;

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
    /// hash(unordered street pair, ordinal among their crossings).
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
}

impl SegmentId {
    /// The segment of a street between two of its nodes on a level.
    pub fn between(street: StreetId, start: NodeId, end: NodeId, level: i8) -> Self {
        Self(street.0.with(&[start.0.0, end.0.0, u128::from(level as u8)]))
    }
}

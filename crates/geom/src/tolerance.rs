//! Every tolerance of the project, each with its reason. Lengths are in lattice units (LSB, 2⁻¹⁰ m) unless named
//! otherwise. Anything not listed here is exact.

/// Hard separation δ: no two crossings, and no crossing and foreign segment, come closer (6.25 cm). Far above the
/// rounding of a constructed point (0.71 LSB), which is what makes one rounding step safe.
pub const SEPARATION: i32 = 64;

/// Separation asked of what is newly laid. Eight units above [`SEPARATION`], so that later splits, each moving a
/// segment by at most 0.71 LSB, do not use the hard limit up.
pub const LAYING: i32 = SEPARATION + 8;

/// Least angle between neighbours at a crossing that growth may make, in degrees.
pub const LEAST_GROWN_ANGLE_DEG: f64 = 25.0;

/// Least angle anything may have at a crossing before it is flagged, in degrees.
pub const LEAST_ANGLE_DEG: f64 = 5.0;

/// Shortest edge of a parcel (1/64 m): shorter ones are collapsed, since rounding could turn them over.
pub const PARCEL_EDGE: i32 = 16;

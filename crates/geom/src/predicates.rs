//! Exact predicates on lattice points. With |coordinate| ≤ 2²⁹ every intermediate fits the type it is written in.

use crate::Point;
use std::cmp::Ordering;

/// Twice the signed area of the triangle: positive when `c` lies left of the line from `a` to `b`. Exact.
pub fn orient(a: Point, b: Point, c: Point) -> i64 {
    let (abx, aby) = a.to(b);
    let (acx, acy) = a.to(c);
    abx * acy - aby * acx
}

/// Dot product of `b - a` and `c - a`. Exact.
pub fn dot(a: Point, b: Point, c: Point) -> i64 {
    let (abx, aby) = a.to(b);
    let (acx, acy) = a.to(c);
    abx * acx + aby * acy
}

/// Whether `p` lies on the closed segment `a b`.
pub fn on_segment(a: Point, b: Point, p: Point) -> bool {
    orient(a, b, p) == 0 && a.x.min(b.x) <= p.x && p.x <= a.x.max(b.x) && a.y.min(b.y) <= p.y && p.y <= a.y.max(b.y)
}

/// Whether `p` lies closer than `radius` LSB to the closed segment `a b`. Exact.
pub fn within(a: Point, b: Point, p: Point, radius: i32) -> bool {
    let radius_squared = i64::from(radius) * i64::from(radius);
    let along = dot(a, b, p);
    if along <= 0 {
        return a.distance_squared(p) < radius_squared;
    }
    let length_squared = a.distance_squared(b);
    if along >= length_squared {
        return b.distance_squared(p) < radius_squared;
    }
    let across = i128::from(orient(a, b, p));
    across * across < i128::from(radius_squared) * i128::from(length_squared)
}

/// Whether the open segments cross in one point that is interior to both.
pub fn crosses_properly(a: Point, b: Point, c: Point, d: Point) -> bool {
    let (c_side, d_side) = (orient(a, b, c).signum(), orient(a, b, d).signum());
    if c_side * d_side >= 0 {
        return false;
    }
    orient(c, d, a).signum() * orient(c, d, b).signum() < 0
}

/// Whether the closed segments have any point in common.
pub fn meets(a: Point, b: Point, c: Point, d: Point) -> bool {
    crosses_properly(a, b, c, d)
        || on_segment(a, b, c)
        || on_segment(a, b, d)
        || on_segment(c, d, a)
        || on_segment(c, d, b)
}

/// The lattice point nearest to where the lines through `a b` and `c d` cut, or `None` when they are parallel.
/// Ties of rounding go up. The displacement is at most 0.71 LSB.
pub fn cut(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    let (rx, ry) = a.to(b);
    let (sx, sy) = c.to(d);
    let (qx, qy) = a.to(c);
    let denominator = i128::from(rx) * i128::from(sy) - i128::from(ry) * i128::from(sx);
    if denominator == 0 {
        return None;
    }
    let numerator = i128::from(qx) * i128::from(sy) - i128::from(qy) * i128::from(sx);
    let x = i128::from(a.x) + round_div(i128::from(rx) * numerator, denominator);
    let y = i128::from(a.y) + round_div(i128::from(ry) * numerator, denominator);
    Some(Point::new(i32::try_from(x).ok()?, i32::try_from(y).ok()?))
}

/// The lattice point nearest to the foot of `p` on the closed segment `a b`.
pub fn foot(a: Point, b: Point, p: Point) -> Point {
    let length_squared = a.distance_squared(b);
    let along = dot(a, b, p).clamp(0, length_squared);
    if length_squared == 0 {
        return a;
    }
    let (dx, dy) = a.to(b);
    let place = |from: i32, d: i64| {
        let moved = round_div(i128::from(d) * i128::from(along), i128::from(length_squared));
        (i128::from(from) + moved) as i32
    };
    Point::new(place(a.x, dx), place(a.y, dy))
}

/// Division rounded to nearest, ties up, for any signs of the operands.
pub fn round_div(numerator: i128, denominator: i128) -> i128 {
    let (n, d) = if denominator < 0 { (-numerator, -denominator) } else { (numerator, denominator) };
    (2 * n + d).div_euclid(2 * d)
}

/// Order of two directions by angle, counter-clockwise from east, by half-plane and cross product; exact.
/// Parallel directions of the same sense are equal.
pub fn by_angle(a: (i64, i64), b: (i64, i64)) -> Ordering {
    let half = |(x, y): (i64, i64)| y < 0 || (y == 0 && x < 0);
    half(a).cmp(&half(b)).then_with(|| {
        let cross = i128::from(a.0) * i128::from(b.1) - i128::from(a.1) * i128::from(b.0);
        0.cmp(&cross)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_point() -> impl Strategy<Value = Point> {
        let coordinate = prop_oneof![-Point::LIMIT..=Point::LIMIT, -50..=50];
        (coordinate.clone(), coordinate).prop_map(|(x, y)| Point::new(x, y))
    }

    #[test]
    fn rounds_ties_up_for_all_signs() {
        assert_eq!([round_div(5, 2), round_div(-5, 2), round_div(5, -2), round_div(-7, -2)], [3, -2, -2, 4]);
    }

    proptest! {
        #[test]
        fn orient_is_antisymmetric_and_cyclic(a in any_point(), b in any_point(), c in any_point()) {
            prop_assert_eq!(orient(a, b, c), -orient(b, a, c));
            prop_assert_eq!(orient(a, b, c), orient(b, c, a));
        }

        #[test]
        fn orient_agrees_with_wide_integers(a in any_point(), b in any_point(), c in any_point()) {
            let wide = |p: Point| (i128::from(p.x), i128::from(p.y));
            let ((ax, ay), (bx, by), (cx, cy)) = (wide(a), wide(b), wide(c));
            prop_assert_eq!(i128::from(orient(a, b, c)), (bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
        }

        #[test]
        fn cut_of_crossing_segments_lies_on_both(a in any_point(), b in any_point(), c in any_point(), d in any_point()) {
            if crosses_properly(a, b, c, d) {
                let x = cut(a, b, c, d).unwrap();
                prop_assert!(within(a, b, x, 2) && within(c, d, x, 2));
            }
        }

        #[test]
        fn foot_is_nearest(a in any_point(), b in any_point(), p in any_point()) {
            let nearest = foot(a, b, p);
            prop_assert!(within(a, b, nearest, 2));
            prop_assert!(nearest.distance(p) <= a.distance(p).min(b.distance(p)) + 0.002);
        }

        #[test]
        fn angle_order_agrees_with_atan2(a in any_point(), b in any_point()) {
            let v = |p: Point| (i64::from(p.x), i64::from(p.y));
            prop_assume!(v(a) != (0, 0) && v(b) != (0, 0));
            let turn = |p: Point| {
                let t = libm::atan2(f64::from(p.y), f64::from(p.x));
                if t < 0.0 { t + 2.0 * std::f64::consts::PI } else { t }
            };
            if (turn(a) - turn(b)).abs() > 1e-12 {
                prop_assert_eq!(by_angle(v(a), v(b)), turn(a).partial_cmp(&turn(b)).unwrap());
            }
        }
    }
}

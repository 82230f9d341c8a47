//! Outlines of masks and lines of equal height, by marching squares over a grid of samples.

/// A grid of samples; `values[row * width + column]`.
pub struct Samples {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The samples.
    pub values: Vec<f32>,
}

/// No crossing follows.
const NONE: u32 = u32::MAX;

impl Samples {
    /// Samples taken by `at(column, row)`.
    pub fn of(width: usize, height: usize, at: impl Fn(usize, usize) -> f64) -> Self {
        let values = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        Self { width, height, values: values.map(|(column, row)| at(column, row) as f32).collect() }
    }

    /// Each sample as the mean of the nine around it, those at the rim counting again for what lies beyond: what is left
    /// of pixel stairs goes.
    #[must_use]
    pub fn smoothed(&self) -> Self {
        let mut values = self.values.clone();
        // First along rows, then along columns.
        for (stride, count) in [(1, self.width), (self.width, self.height)] {
            let before = values.clone();
            for (i, value) in values.iter_mut().enumerate() {
                let along = i / stride % count;
                let low = before[if along > 0 { i - stride } else { i }];
                let high = before[if along + 1 < count { i + stride } else { i }];
                *value = (low + before[i] + high) / 3.0;
            }
        }
        Self { width: self.width, height: self.height, values }
    }

    /// The same with a rim of one sample all round, so that every outline closes.
    #[must_use]
    pub fn rimmed(&self, value: f32) -> Self {
        let inside = |column: usize, row: usize| (1..=self.width).contains(&column) && (1..=self.height).contains(&row);
        Self::of(self.width + 2, self.height + 2, |column, row| {
            f64::from(if inside(column, row) { self.values[(row - 1) * self.width + column - 1] } else { value })
        })
    }

    /// The lines where the samples pass `level`, in columns and rows, with whether they close. What is higher lies on
    /// their left as rows go down.
    pub fn contours(&self, level: f32) -> Vec<(Vec<[f32; 2]>, bool)> {
        let (next, has_before) = self.links(level);
        let mut visited = vec![false; next.len()];
        let mut lines = Vec::new();
        // Open lines first, from where nothing leads to; what is left are rings.
        for open in [true, false] {
            for start in 0..next.len() {
                if next[start] != NONE && !visited[start] && !(open && has_before[start]) {
                    lines.push(self.trace(start, level, &next, &mut visited));
                }
            }
        }
        lines
    }

    /// From each grid edge that the level passes, the one where its line goes on.
    fn links(&self, level: f32) -> (Vec<u32>, Vec<bool>) {
        let mut next = vec![NONE; self.values.len() * 2];
        let mut has_before = vec![false; next.len()];
        for row in 0..self.height.saturating_sub(1) {
            for column in 0..self.width.saturating_sub(1) {
                for (from, to) in self.cell(column, row, level) {
                    next[from] = to as u32;
                    has_before[to] = true;
                }
            }
        }
        (next, has_before)
    }

    /// The pieces of line through one cell, as grid edges: corners north-west, north-east, south-east, south-west.
    fn cell(&self, column: usize, row: usize, level: f32) -> impl Iterator<Item = (usize, usize)> {
        let corner = row * self.width + column;
        let high = [corner, corner + 1, corner + 1 + self.width, corner + self.width].map(|i| self.values[i] >= level);
        let (north, west) = (2 * corner, 2 * corner + 1);
        let (east, south) = (2 * (corner + 1) + 1, 2 * (corner + self.width));
        let sides = [north, east, south, west];
        // Clockwise along the rim, a line leaves the cell where low turns high and enters where high turns low.
        let leaves = move |i: usize| !high[i] && high[(i + 1) % 4];
        let enters = move |i: usize| high[i] && !high[(i + 1) % 4];
        (0..4).filter(move |&i| enters(i)).map(move |i| {
            // The high corner lies before the entrance: the line keeps it on its left and leaves before it.
            let out = (1..4).map(|back| (i + 4 - back) % 4).find(|&j| leaves(j)).unwrap_or(i);
            (sides[i], sides[out])
        })
    }

    /// The line from a grid edge on.
    fn trace(&self, start: usize, level: f32, next: &[u32], visited: &mut [bool]) -> (Vec<[f32; 2]>, bool) {
        let mut line = Vec::new();
        let mut at = start;
        loop {
            line.push(self.crossing(at, level));
            visited[at] = true;
            match next[at] {
                NONE => return (line, false),
                onwards if onwards as usize == start => return (line, true),
                onwards => at = onwards as usize,
            }
        }
    }

    /// Where the level passes a grid edge, linearly between its samples.
    fn crossing(&self, edge: usize, level: f32) -> [f32; 2] {
        let corner = edge / 2;
        let is_down = edge % 2 == 1;
        let other = if is_down { corner + self.width } else { corner + 1 };
        let (a, b) = (self.values[corner], self.values[other]);
        let share = if a == b { 0.5 } else { ((level - a) / (b - a)).clamp(0.0, 1.0) };
        let (x, y) = ((corner % self.width) as f32, (corner / self.width) as f32);
        if is_down { [x, y + share] } else { [x + share, y] }
    }
}

/// The chain with fewer points, none of the left-out farther from it than `tolerance` (Douglas and Peucker 1973). The
/// ends stay.
pub fn simplified(chain: &[[f32; 2]], tolerance: f32) -> Vec<[f32; 2]> {
    let mut keep = vec![false; chain.len()];
    if let (Some(first), true) = (keep.first_mut(), chain.len() > 1) {
        *first = true;
    }
    if let Some(last) = keep.last_mut() {
        *last = true;
    }
    let mut spans = vec![(0, chain.len().saturating_sub(1))];
    while let Some((from, to)) = spans.pop() {
        let farthest = (from + 1..to)
            .map(|i| (distance_squared(chain[from], chain[to], chain[i]), i))
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        if let Some((distance, i)) = farthest.filter(|&(distance, _)| distance > tolerance * tolerance) {
            debug_assert!(distance.is_finite());
            keep[i] = true;
            spans.extend([(from, i), (i, to)]);
        }
    }
    chain.iter().zip(keep).filter(|(_, keep)| *keep).map(|(&point, _)| point).collect()
}

/// Squared distance from `p` to the segment from `a` to `b`.
fn distance_squared(a: [f32; 2], b: [f32; 2], p: [f32; 2]) -> f32 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let (px, py) = (p[0] - a[0], p[1] - a[1]);
    let length = dx * dx + dy * dy;
    let share = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    let (x, y) = (px - share * dx, py - share * dy);
    x * x + y * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_hill_gives_one_ring_around_it() {
        let hill = Samples::of(9, 9, |x, y| if (3..6).contains(&x) && (3..6).contains(&y) { 1.0 } else { 0.0 });
        let rings = hill.contours(0.5);
        assert_eq!(rings.len(), 1);
        assert!(rings[0].1);
        assert!(rings[0].0.iter().all(|&[x, y]| (2.5..=5.5).contains(&x) && (2.5..=5.5).contains(&y)));
    }

    #[test]
    fn a_slope_gives_one_open_line() {
        let lines = Samples::of(5, 4, |x, _| x as f64).contours(1.5);
        assert_eq!(lines.len(), 1);
        assert!(!lines[0].1);
        assert!(lines[0].0.iter().all(|&[x, _]| x == 1.5));
        assert_eq!(lines[0].0.len(), 4);
    }

    #[test]
    fn a_straight_chain_keeps_its_ends_only() {
        let chain: Vec<[f32; 2]> = (0..9).map(|i| [i as f32, 0.1 * (i % 2) as f32]).collect();
        assert_eq!(simplified(&chain, 0.2), vec![chain[0], chain[8]]);
        assert!(simplified(&[], 1.0).is_empty());
    }

    proptest! {
        #[test]
        fn rimmed_outlines_all_close_and_enclose_what_is_high(cells in prop::collection::vec(any::<bool>(), 30)) {
            let samples = Samples { width: 6, height: 5, values: cells.iter().map(|&c| f32::from(u8::from(c))).collect() };
            let rings = samples.rimmed(0.0).contours(0.5);
            prop_assert!(rings.iter().all(|(_, closed)| *closed));
            for row in 0..5 {
                for column in 0..6 {
                    let (x, y) = (column as f32 + 1.0, row as f32 + 1.0);
                    let crossings = rings.iter().flat_map(|(ring, _)| {
                        (0..ring.len()).map(move |i| (ring[i], ring[(i + 1) % ring.len()]))
                    });
                    let inside = crossings.filter(|(a, b)| (a[1] > y) != (b[1] > y)).filter(|(a, b)| {
                        a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) > x
                    }).count() % 2 == 1;
                    prop_assert_eq!(inside, cells[row * 6 + column]);
                }
            }
        }
    }
}

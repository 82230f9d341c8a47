//! A uniform grid over boxes, to find the few that can have anything to do with each other.

use geom::{Bounds, Point};

/// Boxes sorted into the cells that they touch.
pub struct Grid {
    boxes: Vec<Bounds>,
    min: Point,
    /// Side of a cell in LSB.
    cell: i64,
    columns: i64,
    rows: i64,
    /// Where each cell's items start in `items`.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Grid {
    /// A grid over boxes, with about as many cells as boxes.
    pub fn new(boxes: Vec<Bounds>) -> Self {
        let corners = boxes.iter().flat_map(|bounds| [bounds.min, bounds.max]);
        let all = Bounds::of(corners).unwrap_or(Bounds::between(Point::default(), Point::default()));
        let (width, height) = all.min.to(all.max);
        let area = (width + 1) as f64 * (height + 1) as f64;
        let cell =
            ((area / (boxes.len() + 1) as f64).sqrt().ceil() as i64).max((width.max(height) >> 14) + 1).max(1024);
        let (columns, rows) = (width / cell + 1, height / cell + 1);
        let mut grid = Self { boxes, min: all.min, cell, columns, rows, starts: Vec::new(), items: Vec::new() };
        grid.fill();
        grid
    }

    /// Counting sort of the boxes into cells.
    fn fill(&mut self) {
        let mut starts = vec![0u32; (self.columns * self.rows + 1) as usize];
        for bounds in &self.boxes {
            self.cells(bounds).for_each(|cell| starts[cell + 1] += 1);
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut items = vec![0u32; starts.last().map_or(0, |&end| end as usize)];
        for (i, bounds) in self.boxes.iter().enumerate() {
            for cell in self.cells(bounds) {
                items[next[cell] as usize] = i as u32;
                next[cell] += 1;
            }
        }
        (self.starts, self.items) = (starts, items);
    }

    fn column(&self, x: i32) -> i64 {
        ((i64::from(x) - i64::from(self.min.x)).div_euclid(self.cell)).clamp(0, self.columns - 1)
    }

    fn row(&self, y: i32) -> i64 {
        ((i64::from(y) - i64::from(self.min.y)).div_euclid(self.cell)).clamp(0, self.rows - 1)
    }

    fn cells(&self, bounds: &Bounds) -> impl Iterator<Item = usize> + use<> {
        let (west, east) = (self.column(bounds.min.x), self.column(bounds.max.x));
        let (south, north) = (self.row(bounds.min.y), self.row(bounds.max.y));
        let columns = self.columns;
        (south..=north).flat_map(move |row| (west..=east).map(move |column| (row * columns + column) as usize))
    }

    fn in_cell(&self, cell: usize) -> &[u32] {
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The one cell that answers for two boxes that overlap.
    fn home(&self, a: &Bounds, b: &Bounds) -> usize {
        (self.row(a.min.y.max(b.min.y)) * self.columns + self.column(a.min.x.max(b.min.x))) as usize
    }

    /// Calls `f` once with each two boxes that overlap, the smaller index first.
    pub fn for_pairs(&self, mut f: impl FnMut(usize, usize)) {
        for cell in 0..self.starts.len() - 1 {
            let items = self.in_cell(cell);
            for (n, &i) in items.iter().enumerate() {
                for &j in &items[n + 1..] {
                    let (a, b) = (&self.boxes[i as usize], &self.boxes[j as usize]);
                    if a.overlaps(b) && self.home(a, b) == cell {
                        f(i as usize, j as usize);
                    }
                }
            }
        }
    }

    /// Calls `f` once with each box that overlaps `bounds`.
    pub fn for_near(&self, bounds: &Bounds, mut f: impl FnMut(usize)) {
        for cell in self.cells(bounds) {
            for &i in self.in_cell(cell) {
                let other = &self.boxes[i as usize];
                if other.overlaps(bounds) && self.home(other, bounds) == cell {
                    f(i as usize);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_box() -> impl Strategy<Value = Bounds> {
        (-90_000..90_000, -90_000..90_000, 0..40_000, 0..9_000)
            .prop_map(|(x, y, w, h)| Bounds::between(Point::new(x, y), Point::new(x + w, y + h)))
    }

    proptest! {
        #[test]
        fn finds_what_trying_all_finds(boxes in prop::collection::vec(any_box(), 0..60), probe in any_box()) {
            let grid = Grid::new(boxes.clone());
            let mut found = Vec::new();
            grid.for_pairs(|i, j| found.push((i, j)));
            found.sort_unstable();
            let all = (0..boxes.len()).flat_map(|i| (i + 1..boxes.len()).map(move |j| (i, j)));
            prop_assert_eq!(found, all.filter(|&(i, j)| boxes[i].overlaps(&boxes[j])).collect::<Vec<_>>());
            let mut near = Vec::new();
            grid.for_near(&probe, |i| near.push(i));
            near.sort_unstable();
            prop_assert_eq!(near, (0..boxes.len()).filter(|&i| boxes[i].overlaps(&probe)).collect::<Vec<_>>());
        }
    }
}

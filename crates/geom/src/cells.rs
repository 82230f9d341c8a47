//! Grids of labels: what each cell belongs to, and the exact outlines of cells that belong together.
//!
//! Cells are kept as runs along rows, so that a picture of a few areas is small whatever its resolution. The lines of
//! the grid are lattice numbers, so that looking up a point and tracing outlines agree exactly.

mod trace;

use crate::point::units;
use crate::{Point, Vec2};

/// Cells of one label next to each other in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    /// Column after the last one.
    end: u32,
    label: Option<u16>,
}

/// A grid of cells of which each may have a label. Row 0 is north, as in images.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cells {
    /// Lines of the grid from west to east, in LSB; one more than columns.
    columns: Vec<i32>,
    /// Lines from south to north.
    rows: Vec<i32>,
    /// Runs from west to east, row by row from the south.
    runs: Vec<Run>,
    /// Where each row's runs start, and where the last one's end.
    starts: Vec<usize>,
}

impl Cells {
    /// A grid of `width` × `height` square cells of `pixel_size` metres from `origin`, its south-west corner; `label`
    /// tells what the cell in a column and a row (0 is north) belongs to. `None` where there is no cell, a cell is
    /// smaller than the lattice, or the grid larger.
    pub fn new(
        width: usize,
        height: usize,
        pixel_size: f64,
        origin: Vec2,
        label: impl Fn(usize, usize) -> Option<u16>,
    ) -> Option<Self> {
        let far = origin + Vec2::new(width as f64, height as f64) * pixel_size;
        let fits = Point::try_from_metres(origin).is_some() && Point::try_from_metres(far).is_some();
        if width == 0 || height == 0 || !fits || pixel_size * Point::UNITS_PER_METRE < 1.0 {
            return None;
        }
        let line = |from: f64| move |i: usize| units(from + i as f64 * pixel_size);
        let mut cells = Self {
            columns: (0..=width).map(line(origin.x)).collect(),
            rows: (0..=height).map(line(origin.y)).collect(),
            runs: Vec::new(),
            starts: vec![0],
        };
        for row in (0..height).rev() {
            cells.push_row((0..width).map(|column| label(column, row)));
        }
        Some(cells)
    }

    fn push_row(&mut self, labels: impl Iterator<Item = Option<u16>>) {
        let first = self.runs.len();
        for (column, label) in labels.enumerate() {
            let end = column as u32 + 1;
            match self.runs[first..].last_mut() {
                Some(run) if run.label == label => run.end = end,
                _ => self.runs.push(Run { end, label }),
            }
        }
        self.starts.push(self.runs.len());
    }

    /// The label of the cell at a point. Cells own their south and west rims; outside the grid the nearest cell answers.
    pub fn at(&self, p: Point) -> Option<u16> {
        let column = cell_of(&self.columns, p.x) as u32;
        let runs = self.row(cell_of(&self.rows, p.y));
        runs.get(runs.partition_point(|run| run.end <= column)).and_then(|run| run.label)
    }

    /// Twice the area of the cells of a label, in LSB²; exact.
    pub fn doubled_area(&self, label: u16) -> i128 {
        let width =
            |from: u32, to: u32| i128::from(self.columns[to as usize]) - i128::from(self.columns[from as usize]);
        let row_area = |row: usize| {
            let height = i128::from(self.rows[row + 1]) - i128::from(self.rows[row]);
            let own = self.spans(row).filter(|(_, _, own)| *own == Some(label));
            own.map(|(from, to, _)| width(from, to)).sum::<i128>() * height
        };
        (0..self.height()).map(row_area).sum::<i128>() * 2
    }

    fn height(&self) -> usize {
        self.rows.len() - 1
    }

    /// The runs of a row counted from the south.
    fn row(&self, row: usize) -> &[Run] {
        &self.runs[self.starts[row]..self.starts[row + 1]]
    }

    /// First column, column after the last, and label of each run of a row.
    fn spans(&self, row: usize) -> impl Iterator<Item = (u32, u32, Option<u16>)> + '_ {
        let runs = self.row(row);
        let begins = std::iter::once(0).chain(runs.iter().map(|run| run.end));
        begins.zip(runs).map(|(from, run)| (from, run.end, run.label))
    }
}

/// The cell between whose lines a coordinate lies, or the nearest.
fn cell_of(lines: &[i32], at: i32) -> usize {
    lines[1..lines.len() - 1].partition_point(|&line| line <= at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::Location;
    use proptest::prelude::*;

    /// A grid of texts, `.` for no label, row by row from the north; cells of 10 m from (100, 200).
    fn drawn(rows: &[&str]) -> Cells {
        let label = |column: usize, row: usize| rows[row].as_bytes()[column].checked_sub(b'a').map(u16::from);
        Cells::new(rows[0].len(), rows.len(), 10.0, Vec2::new(100.0, 200.0), label).unwrap()
    }

    fn shapes(cells: &Cells) -> Vec<(u16, usize, Vec<usize>)> {
        let polygons = cells.polygons();
        polygons.iter().map(|(label, p)| (*label, p.outer.len(), p.holes.iter().map(Vec::len).collect())).collect()
    }

    #[test]
    fn points_find_their_cells() {
        let cells = drawn(&["ab", ".c"]);
        let at = |x: f64, y: f64| cells.at(Point::from_metres(Vec2::new(x, y)));
        assert_eq!(
            [at(105.0, 215.0), at(115.0, 215.0), at(105.0, 205.0), at(115.0, 205.0)],
            [Some(0), Some(1), None, Some(2)]
        );
        assert_eq!([at(110.0, 210.0), at(120.0, 220.0), at(-9.0, 999.0)], [Some(1), Some(1), Some(0)]);
        assert_eq!(cells.at(Point::new(110 * 1024 - 1, 210 * 1024)), Some(0));
    }

    #[test]
    fn grids_that_are_none_are_refused() {
        let new = |width, height, size, x| Cells::new(width, height, size, Vec2::new(x, 0.0), |_, _| None).is_some();
        assert!(new(1, 1, 1.0, 0.0));
        assert!(!new(0, 1, 1.0, 0.0) && !new(1, 0, 1.0, 0.0) && !new(1, 1, 0.0005, 0.0) && !new(1, 1, f64::NAN, 0.0));
        assert!(!new(2, 2, 600_000.0, 0.0) && !new(1, 1, 1.0, f64::INFINITY));
    }

    #[test]
    fn outlines_of_known_shapes() {
        assert_eq!(shapes(&drawn(&["aa", "aa"])), [(0, 4, vec![])]);
        assert_eq!(shapes(&drawn(&["aaa", "aba", "aaa"])), [(0, 4, vec![4]), (1, 4, vec![])]);
        // Cells that touch in a corner only are two shapes; a bay closed by a corner is a hole that touches the rim.
        assert_eq!(shapes(&drawn(&["a.", ".a"])), [(0, 4, vec![]), (0, 4, vec![])]);
        assert_eq!(shapes(&drawn(&["aaa", "a.a", "aa."])), [(0, 6, vec![4])]);
        // Two holes that touch in a corner.
        assert_eq!(shapes(&drawn(&["aaaa", "a.aa", "aa.a", "aaaa"])), [(0, 4, vec![4, 4])]);
        assert!(drawn(&["..", ".."]).polygons().is_empty());
    }

    fn any_grid() -> impl Strategy<Value = Cells> {
        (1usize..9, 1usize..9, prop::sample::select(vec![1.0 / 1024.0, 0.0033, 1.0, 7.77])).prop_flat_map(
            |(w, h, size)| {
                prop::collection::vec(prop::option::of(0u16..3), w * h).prop_map(move |labels| {
                    Cells::new(w, h, size, Vec2::new(-3.3, 12.0), |column, row| labels[row * w + column]).unwrap()
                })
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]

        #[test]
        fn outlines_are_valid_and_add_up(cells in any_grid()) {
            let polygons = cells.polygons();
            for label in 0..3 {
                let own = polygons.iter().filter(|(own, _)| *own == label);
                prop_assert_eq!(own.map(|(_, polygon)| polygon.doubled_area()).sum::<i128>(), cells.doubled_area(label));
            }
            for (_, polygon) in &polygons {
                prop_assert!(polygon.is_valid(), "{polygon:?}");
            }
            prop_assert!(polygons.is_sorted_by_key(|(label, polygon)| (*label, polygon.outer[0])));
        }

        #[test]
        fn points_lie_in_the_outline_of_their_label(cells in any_grid(), x in -4.0..70.0f64, y in 11.0..80.0f64) {
            let low = Point::new(cells.columns[0], cells.rows[0]);
            let high = Point::new(*cells.columns.last().unwrap(), *cells.rows.last().unwrap());
            let p = Point::from_metres(Vec2::new(x, y));
            let p = Point::new(p.x.clamp(low.x, high.x), p.y.clamp(low.y, high.y));
            for (label, polygon) in cells.polygons() {
                if polygon.locate(p) == Location::Inside {
                    prop_assert_eq!(cells.at(p), Some(label));
                }
            }
            let outlined = |label| cells.polygons().iter().any(|(own, shape)| *own == label && shape.contains(p));
            prop_assert!(cells.at(p).is_none_or(outlined));
        }
    }
}

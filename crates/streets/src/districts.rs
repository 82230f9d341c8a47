//! Districts: named areas of the site that rules and presets refer to (SCH10 §8.1: "an area map that denotes three
//! different town districts").

use geom::{Bounds, Cells, Id, Point, Polygon, Vec2};
use std::sync::Arc;

/// The districts of a site. They do not overlap, and need not cover it.
#[derive(Clone, Debug, Default)]
pub struct Districts {
    names: Vec<String>,
    ground: Ground,
}

/// What tells which district a point belongs to.
#[derive(Clone, Debug, Default)]
enum Ground {
    #[default]
    None,
    /// Cells labelled with positions in the list of names.
    Cells(Cells),
    /// Areas with the positions of their names.
    Areas(Vec<(usize, Bounds, Polygon)>),
}

/// One outline of a district.
#[derive(Clone, Debug, PartialEq)]
pub struct DistrictArea {
    /// Identity: hash of the district's name; further outlines of one district are its children, in the order of their
    /// first corners.
    pub id: Id,
    /// The district.
    pub name: String,
    /// The outline.
    pub polygon: Polygon,
}

impl Districts {
    /// Districts of a grid whose labels are positions in `names`; other labels count as no district.
    pub fn of_cells(names: Vec<String>, cells: Cells) -> Self {
        Self { names, ground: Ground::Cells(cells) }
    }

    /// Districts of valid polygons, each with the position of its name in `names`. Where they overlap, the first one
    /// is meant.
    pub fn of_areas(names: Vec<String>, areas: Vec<(usize, Polygon)>) -> Self {
        let bounded = |(name, polygon): (usize, Polygon)| Some((name, polygon.bounds()?, polygon));
        let areas = areas.into_iter().filter(|(name, _)| *name < names.len()).filter_map(bounded).collect();
        Self { names, ground: Ground::Areas(areas) }
    }

    /// The names, in the order they are counted.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The position of a district's name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Which district a point belongs to; exact. Cells own their south and west rims; of areas that share a rim the
    /// first owns it.
    pub fn at(&self, p: Point) -> Option<usize> {
        match &self.ground {
            Ground::None => None,
            Ground::Cells(cells) => cells.at(p).map(usize::from).filter(|&name| name < self.names.len()),
            Ground::Areas(areas) => {
                let holds = |(_, bounds, area): &&(usize, Bounds, Polygon)| bounds.contains(p) && area.contains(p);
                areas.iter().find(holds).map(|(name, ..)| *name)
            }
        }
    }

    /// The name of the district at a place in metres; empty where there is none.
    pub fn name_at(&self, place: Vec2) -> &str {
        let name = self.at(Point::from_metres(place)).and_then(|at| self.names.get(at));
        name.map_or("", String::as_str)
    }

    /// The outlines of all districts, by name as they are counted, then by first corner.
    pub fn areas(&self) -> Vec<DistrictArea> {
        let mut outlines: Vec<(usize, Polygon)> = match &self.ground {
            Ground::None => Vec::new(),
            Ground::Cells(cells) => {
                cells.polygons().into_iter().map(|(name, area)| (usize::from(name), area)).collect()
            }
            Ground::Areas(areas) => areas.iter().map(|(name, _, area)| (*name, area.clone())).collect(),
        };
        outlines.sort_by(|(a, p), (b, q)| a.cmp(b).then_with(|| p.outer.iter().min().cmp(&q.outer.iter().min())));
        let of_name = |own: &[(usize, Polygon)]| {
            let name = self.names.get(own[0].0).cloned();
            let areas = own.iter().enumerate().map(|(ordinal, (_, polygon))| (ordinal, polygon.clone()));
            name.map(|name| areas.map(|(ordinal, area)| district_area(&name, ordinal, area)).collect::<Vec<_>>())
        };
        outlines.chunk_by(|(a, _), (b, _)| a == b).filter_map(of_name).flatten().collect()
    }
}

fn district_area(name: &str, ordinal: usize, polygon: Polygon) -> DistrictArea {
    let root = Id::of_text("district", name);
    let id = if ordinal == 0 { root } else { root.child(ordinal as u64) };
    DistrictArea { id, name: name.to_owned(), polygon }
}

/// A value for each district and one for all other ground.
#[derive(Clone, Debug)]
pub struct PerDistrict<T> {
    districts: Arc<Districts>,
    own: Vec<Option<T>>,
    other: T,
}

impl<T> PerDistrict<T> {
    /// Values by the position of their district; what has none gets `other`.
    pub fn new(districts: Arc<Districts>, mut value: impl FnMut(&str) -> Option<T>, other: T) -> Self {
        let own = districts.names().iter().map(|name| value(name)).collect();
        Self { districts, own, other }
    }

    /// The value at a place in metres.
    pub fn at(&self, place: Vec2) -> &T {
        let own = self.districts.at(Point::from_metres(place)).and_then(|at| self.own.get(at)?.as_ref());
        own.unwrap_or(&self.other)
    }

    /// All values: those of districts in their order, then the other.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.own.iter().flatten().chain([&self.other])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(|&name| name.to_owned()).collect()
    }

    fn square(x: i32, y: i32, side: i32) -> Polygon {
        let corner = |dx, dy| Point::new((x + dx) * 1024, (y + dy) * 1024);
        Polygon::new(vec![corner(0, 0), corner(side, 0), corner(side, side), corner(0, side)], vec![])
    }

    #[test]
    fn the_first_of_overlapping_areas_is_meant() {
        let areas = vec![(1, square(0, 0, 20)), (0, square(10, 10, 20)), (7, square(50, 50, 5))];
        let districts = Districts::of_areas(names(&["harbour", "old town"]), areas);
        let at = |x: f64, y: f64| districts.name_at(Vec2::new(x, y));
        assert_eq!(
            [at(15.0, 15.0), at(25.0, 25.0), at(20.0, 20.0), at(52.0, 52.0)],
            ["old town", "harbour", "old town", ""]
        );
    }

    #[test]
    fn outlines_carry_ids_by_name_and_order() {
        let label = |column: usize, _| [Some(1), None, Some(1), Some(0), Some(9)][column];
        let cells = Cells::new(5, 1, 10.0, Vec2::ZERO, label).unwrap();
        let areas = Districts::of_cells(names(&["b", "a"]), cells).areas();
        let told: Vec<_> = areas.iter().map(|area| (area.name.as_str(), area.polygon.outer[0].x / 10240)).collect();
        assert_eq!(told, [("b", 3), ("a", 0), ("a", 2)]);
        let root = Id::of_text("district", "a");
        assert_eq!([areas[0].id, areas[1].id, areas[2].id], [Id::of_text("district", "b"), root, root.child(1)]);
    }

    #[test]
    fn values_follow_their_districts() {
        let districts = Districts::of_areas(names(&["a", "b"]), vec![(0, square(0, 0, 10)), (1, square(20, 0, 10))]);
        let lengths = PerDistrict::new(Arc::new(districts), |name| (name == "b").then_some(7), 3);
        let at = |x: f64| *lengths.at(Vec2::new(x, 5.0));
        assert_eq!([at(5.0), at(15.0), at(25.0)], [3, 3, 7]);
        assert_eq!(lengths.values().copied().collect::<Vec<_>>(), [7, 3]);
    }
}

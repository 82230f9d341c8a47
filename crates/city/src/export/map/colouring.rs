//! Streets coloured by what they are or by the ground under them, with the legend that says so.

use super::canvas::Colour;
use crate::{City, Trace};
use geom::{Bounds, Polygon, Vec2};
use std::collections::{BTreeMap, BTreeSet};
use streets::runs::Run;
use streets::{NodeId, StreetId};

/// What the streets of a map may be coloured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ColourBy {
    /// The rule that laid them, or the file they came from.
    Rule,
    /// Their class.
    Class,
    /// The district that their middle lies in.
    District,
    /// People per km² along them, by the map `density`.
    Density,
    /// How steeply they climb, by the map `elevation`.
    Grade,
}

impl ColourBy {
    /// The map that it reads, if it reads one.
    pub fn map(self) -> Option<&'static str> {
        match self {
            Self::Density => Some("density"),
            Self::Grade => Some("elevation"),
            Self::Rule | Self::Class | Self::District => None,
        }
    }
}

/// Colours that stay apart for colour-blind eyes and on paper (Okabe and Ito 2008, less its yellow; then Tol 2021).
const APART: [Colour; 8] = [
    Colour(0x00, 0x72, 0xb2),
    Colour(0xd5, 0x5e, 0x00),
    Colour(0x00, 0x9e, 0x73),
    Colour(0xcc, 0x79, 0xa7),
    Colour(0xe6, 0x9f, 0x00),
    Colour(0x56, 0xb4, 0xe9),
    Colour(0x33, 0x22, 0x88),
    Colour(0x88, 0x2e, 0x55),
];
/// What has no colour of its own.
const OTHER: Colour = Colour(0xa3, 0xa1, 0x9b);
/// From few to many (after ColorBrewer YlGnBu, its pale end sand, so that it is no park).
const FEW_TO_MANY: [Colour; 6] = [
    Colour(0xe6, 0xd3, 0x9a),
    Colour(0x8f, 0xcf, 0xbd),
    Colour(0x41, 0xb6, 0xc4),
    Colour(0x1d, 0x91, 0xc0),
    Colour(0x22, 0x5e, 0xa8),
    Colour(0x0c, 0x2c, 0x84),
];
/// From level to steep (ColorBrewer YlOrRd, level ground grey so that it recedes).
const LEVEL_TO_STEEP: [Colour; 6] = [
    Colour(0xc4, 0xc2, 0xba),
    Colour(0xfe, 0xd9, 0x76),
    Colour(0xfe, 0xb2, 0x4c),
    Colour(0xfc, 0x6d, 0x2c),
    Colour(0xd0, 0x16, 0x1c),
    Colour(0x6d, 0x00, 0x26),
];
/// Grades in percent that part these colours.
const GRADES: [f64; 5] = [2.0, 5.0, 8.0, 12.0, 20.0];
/// Metres of street over which a grade or a density is taken.
const STEP: f64 = 20.0;

/// A colour of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it stands for.
    pub name: String,
    /// The colour.
    pub colour: Colour,
}

/// A stretch of street in one colour.
pub struct Stretch {
    /// Its place in the legend.
    pub entry: usize,
    /// Its line in metres.
    pub line: Vec<Vec2>,
}

/// What the streets of a city are coloured with.
pub struct Colouring {
    /// What the legend is headed by.
    pub heading: &'static str,
    /// The legend.
    pub entries: Vec<Entry>,
    /// The stretches of each run.
    pub stretches: Vec<Vec<Stretch>>,
}

impl Colouring {
    /// Colours the streets of a city.
    pub fn of(city: &City, by: ColourBy) -> Self {
        match by {
            ColourBy::Rule => {
                Self::by_name(city, "streets by rule", |run| city.origins.get(usize::from(run.origin)).cloned())
            }
            ColourBy::Class => Self::by_class(city),
            ColourBy::District => {
                let districts = Districts::of(city);
                Self::by_name(city, "streets by district", |run| districts.name_at(middle(city, run)))
            }
            ColourBy::Density => Self::by_density(city),
            ColourBy::Grade => Self::by_grade(city),
        }
    }

    /// A colour for each name, those with most street first; what there are no colours left for is "other".
    fn by_name(city: &City, heading: &'static str, name: impl Fn(&Run) -> Option<String>) -> Self {
        let names: Vec<Option<String>> = city.runs.iter().map(name).collect();
        let mut lengths: BTreeMap<&str, f64> = BTreeMap::new();
        for (run, name) in city.runs.iter().zip(&names) {
            if let Some(name) = name {
                *lengths.entry(name).or_default() += length(&line_of(city, run));
            }
        }
        let mut order: Vec<(&str, f64)> = lengths.into_iter().collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1).then_with(|| a.0.cmp(b.0)));
        let own: Vec<&str> = order.iter().take(APART.len()).map(|(name, _)| *name).collect();
        let place = |name: &Option<String>| {
            name.as_deref().and_then(|name| own.iter().position(|own| *own == name)).unwrap_or(own.len())
        };
        let mut entries: Vec<Entry> =
            own.iter().zip(APART).map(|(name, colour)| Entry { name: (*name).to_owned(), colour }).collect();
        if names.iter().any(|name| place(name) == own.len()) {
            entries.push(Entry { name: if own.is_empty() { "none" } else { "other" }.into(), colour: OTHER });
        }
        let whole =
            |(run, name): (&Run, &Option<String>)| vec![Stretch { entry: place(name), line: line_of(city, run) }];
        Self { heading, entries, stretches: city.runs.iter().zip(&names).map(whole).collect() }
    }

    /// A colour for each class, the most important first.
    fn by_class(city: &City) -> Self {
        let present: Vec<_> =
            city.graph.classes().iter().filter(|(class, _)| city.runs.iter().any(|run| run.class == *class)).collect();
        // Vermilion for what is above, blue for what fills: far apart in tone as well.
        let colours = [APART[7], APART[1], APART[0]].into_iter().chain(APART[2..7].iter().copied());
        let colours: Vec<Colour> = colours.collect();
        let colour = |class: streets::Class| colours.get(usize::from(class.0)).copied().unwrap_or(OTHER);
        let entries =
            present.iter().map(|(class, info)| Entry { name: info.name.clone(), colour: colour(*class) }).collect();
        let place = |run: &Run| present.iter().position(|(class, _)| *class == run.class).unwrap_or(0);
        let whole = |run: &Run| vec![Stretch { entry: place(run), line: line_of(city, run) }];
        Self { heading: "streets by class", entries, stretches: city.runs.iter().map(whole).collect() }
    }

    /// Colours by the derivation step in which streets grew (PM01 figure 9); those that were there before are "given".
    pub fn of_growth(city: &City, trace: &Trace) -> Self {
        let (by_node, by_street) = times(trace);
        // A given street may go on: what was there of it did not grow.
        let given: BTreeSet<StreetId> = trace.given().streets().into_iter().collect();
        let time = |run: &Run| -> Option<u32> {
            let ids = run.nodes.iter().map(|&node| city.graph.node(node).id);
            let known: Vec<u32> = ids.filter_map(|id| by_node.get(&(run.street, id)).copied()).collect();
            let began = by_street.get(&run.street).filter(|_| !given.contains(&run.street));
            known.into_iter().min().or(began.copied())
        };
        let last = f64::from(trace.last_step().max(1));
        let bounds = [1.0, 2.0, 3.0, 4.0, 5.0].map(|i| (last * i / 6.0).ceil() as u32);
        let place = |step: u32| bounds.iter().filter(|&&bound| step > bound).count();
        let from = |i: usize| if i == 0 { 1 } else { bounds[i - 1] + 1 };
        let to = |i: usize| bounds.get(i).copied().unwrap_or(trace.last_step());
        let mut entries: Vec<Entry> = FEW_TO_MANY
            .into_iter()
            .enumerate()
            .map(|(i, colour)| Entry { name: format!("steps {} – {}", from(i), to(i)), colour })
            .collect();
        entries.push(Entry { name: "given".into(), colour: OTHER });
        let whole = |run: &Run| {
            let entry = time(run).map_or(FEW_TO_MANY.len(), place);
            vec![Stretch { entry, line: line_of(city, run) }]
        };
        Self { heading: "streets by growth", stretches: city.runs.iter().map(whole).collect(), entries }
    }

    fn by_density(city: &City) -> Self {
        let map = city.site.map("density");
        let most =
            city.runs.iter().flat_map(|run| line_of(city, run)).map(|at| map.map_or(0.0, |map| map.bilinear(at)));
        let bounds = round_bounds(most.fold(0.0, f64::max));
        let value = |a: Vec2, b: Vec2| map.map_or(0.0, |map| map.bilinear(a.midpoint(b)));
        Self::by_value(city, "people per km²", &bounds, FEW_TO_MANY, |_, a, b| value(a, b))
    }

    fn by_grade(city: &City) -> Self {
        let value = |run: &Run, a: Vec2, b: Vec2| {
            let flat = run.level != 0 || a == b;
            if flat { 0.0 } else { 100.0 * (city.site.elevation(b) - city.site.elevation(a)).abs() / (b - a).length() }
        };
        Self::by_value(city, "grade in %", &GRADES, LEVEL_TO_STEEP, value)
    }

    /// A colour for each range between bounds.
    fn by_value(
        city: &City,
        heading: &'static str,
        bounds: &[f64; 5],
        colours: [Colour; 6],
        value: impl Fn(&Run, Vec2, Vec2) -> f64,
    ) -> Self {
        let first = std::iter::once(format!("below {}", grouped(bounds[0])));
        let between = bounds.windows(2).map(|pair| format!("{} – {}", grouped(pair[0]), grouped(pair[1])));
        let last = std::iter::once(format!("from {}", grouped(bounds[4])));
        let names = first.chain(between).chain(last);
        let entries = names.zip(colours).map(|(name, colour)| Entry { name, colour }).collect();
        let place = |value: f64| bounds.iter().filter(|&&bound| value >= bound).count();
        let stretches = city.runs.iter().map(|run| {
            let line = line_of(city, run);
            let mut found: Vec<Stretch> = Vec::new();
            for (a, b) in steps(&line) {
                let entry = place(value(run, a, b));
                match found.last_mut() {
                    Some(last) if last.entry == entry => last.line.push(b),
                    _ => found.push(Stretch { entry, line: vec![a, b] }),
                }
            }
            found
        });
        Self { heading, stretches: stretches.collect(), entries }
    }
}

/// The steps at which streets reached their nodes, and at which they began.
type Times = (BTreeMap<(StreetId, NodeId), u32>, BTreeMap<StreetId, u32>);

fn times(trace: &Trace) -> Times {
    let (mut by_node, mut by_street) = Times::default();
    for (start, stage) in trace.stages() {
        for accepted in stage.logs().into_iter().flat_map(|log| &log.accepted) {
            let (street, step) = (accepted.lineage.street, start.saturating_add(accepted.lineage.time));
            by_node.entry((street, accepted.end_id())).or_insert(step);
            let first = by_street.entry(street).or_insert(step);
            *first = step.min(*first);
        }
    }
    (by_node, by_street)
}

/// The line of a run in metres.
fn line_of(city: &City, run: &Run) -> Vec<Vec2> {
    run.nodes.iter().map(|&node| city.graph.at(node).metres()).collect()
}

fn length(line: &[Vec2]) -> f64 {
    line.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Half way along a run.
fn middle(city: &City, run: &Run) -> Vec2 {
    let line = line_of(city, run);
    let mut left = length(&line) / 2.0;
    for pair in line.windows(2) {
        let step = pair[0].distance(pair[1]);
        if left <= step && step > 0.0 {
            return pair[0].lerp(pair[1], left / step);
        }
        left -= step;
    }
    line[0]
}

/// A line in pieces of about [`STEP`], corners kept.
fn steps(line: &[Vec2]) -> Vec<(Vec2, Vec2)> {
    let mut pieces = Vec::new();
    for pair in line.windows(2) {
        let count = (pair[0].distance(pair[1]) / STEP).round().max(1.0) as u32;
        let at = |i: u32| pair[0].lerp(pair[1], f64::from(i) / f64::from(count));
        pieces.extend((0..count).map(|i| (at(i), at(i + 1))));
    }
    pieces
}

/// Five bounds, equally far apart, round, the last below `most`.
fn round_bounds(most: f64) -> [f64; 5] {
    let powers = std::iter::successors(Some(1e-3), |power| Some(power * 10.0)).take(16);
    let rounds = powers.flat_map(|power| [1.0, 2.0, 2.5, 5.0].map(|digit| digit * power));
    let step = rounds.take_while(|step| step * 5.0 < most).last().unwrap_or(1.0);
    [1.0, 2.0, 3.0, 4.0, 5.0].map(|i| i * step)
}

fn grouped(number: f64) -> String {
    if number >= 1000.0 { super::furniture::grouped(number as usize) } else { format!("{number}") }
}

/// Districts, to be asked for places.
struct Districts<'a>(Vec<(Bounds, &'a Polygon, Option<&'a String>)>);

impl<'a> Districts<'a> {
    fn of(city: &'a City) -> Self {
        let of = |area: &'a crate::Area| Some((area.polygon.bounds()?, &area.polygon, area.name.as_ref()));
        Self(city.districts.iter().filter_map(of).collect())
    }

    fn name_at(&self, place: Vec2) -> Option<String> {
        let at = geom::Point::from_metres(place);
        let found = self.0.iter().find(|(bounds, polygon, _)| bounds.contains(at) && polygon.contains(at));
        found.and_then(|(.., name)| name.cloned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::samples::{hilly_city, small_city};
    use std::sync::Arc;

    fn metres(colouring: &Colouring) -> f64 {
        colouring.stretches.iter().flatten().map(|stretch| length(&stretch.line)).sum()
    }

    #[test]
    fn every_street_gets_a_colour_of_the_legend() {
        let city = hilly_city();
        let all: f64 = city.runs.iter().map(|run| length(&line_of(&city, run))).sum();
        for by in [ColourBy::Rule, ColourBy::Class, ColourBy::District, ColourBy::Density, ColourBy::Grade] {
            let colouring = Colouring::of(&city, by);
            assert!((metres(&colouring) - all).abs() < 1e-6 * all, "{by:?}");
            assert_eq!(colouring.stretches.len(), city.runs.len());
            let known = |stretch: &Stretch| stretch.entry < colouring.entries.len();
            assert!(colouring.stretches.iter().flatten().all(known), "{by:?}");
        }
    }

    #[test]
    fn districts_are_told_by_the_middle_and_strangers_apart() {
        let city = small_city();
        let colouring = Colouring::of(&city, ColourBy::District);
        let names: Vec<_> = colouring.entries.iter().map(|entry| entry.name.as_str()).collect();
        assert!(names.contains(&city.districts[0].name.as_deref().unwrap()), "{names:?}");
    }

    #[test]
    fn the_ninth_rule_is_another() {
        let mut city = small_city();
        city.origins = (0..12).map(|i| format!("rule {i}")).collect();
        city.runs.iter_mut().enumerate().for_each(|(i, run)| run.origin = (i % 12) as u16);
        let entries = Colouring::of(&city, ColourBy::Rule).entries;
        assert_eq!((entries.len(), entries[8].name.as_str()), (9, "other"));
        let colours: std::collections::BTreeSet<_> =
            entries.iter().map(|e| (e.colour.0, e.colour.1, e.colour.2)).collect();
        assert_eq!(colours.len(), 9);
    }

    #[test]
    fn a_slope_is_steep_along_it_and_level_across() {
        let mut city = small_city();
        let mut site = (*city.site).clone();
        let values = (0..10_000).map(|i| (i % 100) as f32 * 3.0).collect();
        let slope = geom::Raster::new(100, 100, 10.0, Vec2::ZERO, values).unwrap();
        site.maps.insert("elevation".into(), Arc::new(slope));
        city.site = Arc::new(site);
        let colouring = Colouring::of(&city, ColourBy::Grade);
        let used: std::collections::BTreeSet<usize> = colouring.stretches.iter().flatten().map(|s| s.entry).collect();
        assert!(used.contains(&0) && used.contains(&5), "{used:?}");
    }

    #[test]
    fn bounds_are_round_and_reached() {
        assert_eq!(round_bounds(61_000.0), [10_000.0, 20_000.0, 30_000.0, 40_000.0, 50_000.0]);
        assert_eq!(round_bounds(1.0)[0], 0.1);
        assert!(round_bounds(0.0).iter().all(|bound| *bound > 0.0));
    }
}

//! The ground of the map, from the water up to the bridges.

use super::canvas::{Canvas, Colour, Lines, Pen, rectangle};
use super::colouring::Colouring;
use super::contour::{Samples, simplified};
use super::view::View;
use super::{landmarks, style};
use crate::{City, Site};
use geom::{Point, Polygon, Raster};
use layout::Use;
use std::collections::BTreeMap;
use streets::Class;
use streets::runs::Run;

/// Pixels between the samples of a mask.
const MASK_STEP: f64 = 3.0;

/// Pixels between the samples of the elevation.
const HEIGHT_STEP: f64 = 8.0;

/// Pixels that an outline may be off.
const OUTLINE_TOLERANCE: f32 = 0.3;

/// Steps in metres that lines of equal height may have.
const HEIGHT_STEPS: [f64; 7] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0];

/// Parcels narrower than this many pixels are shown without borders.
const LEAST_PARCEL: f32 = 3.0;

/// What the maps of a site show on the page.
#[derive(Debug)]
pub struct Backdrop {
    /// The outlines of the land; none where there is no water.
    land: Option<Lines>,
    parks: Option<Lines>,
    /// Lines of equal height.
    heights: Lines,
}

impl Backdrop {
    /// That of a site.
    pub fn of(site: &Site, view: &View) -> Self {
        let mask = |name| site.map(name).map(|mask| outlines(mask, view));
        let heights = site.map("elevation").map(|map| heights(map, view)).unwrap_or_default();
        Self { land: mask("land"), parks: mask("parks"), heights }
    }
}

/// Draws the ground with its parcels.
pub fn draw_ground(city: &City, backdrop: &Backdrop, view: &View, page: &mut dyn Canvas) {
    draw_land(city, backdrop, view, page);
    page.part("parcels");
    draw_parcels(city, view, page);
}

/// Draws the ground below coloured streets: without parcels and buildings, which would compete with the colours.
pub fn draw_bare_ground(city: &City, backdrop: &Backdrop, view: &View, page: &mut dyn Canvas) {
    draw_land(city, backdrop, view, page);
    // No parcels tell which blocks are parks.
    draw_parks(backdrop, page);
}

/// Draws what stands and runs on the ground.
pub fn draw(city: &City, view: &View, page: &mut dyn Canvas) {
    page.part("buildings");
    draw_buildings(city, view, page);
    page.part("streets");
    draw_streets(city, view, page, |level| level <= 0);
    page.part("bridges");
    draw_streets(city, view, page, |level| level > 0);
    landmarks::draw(city, view, page);
}

/// What lies below everything built.
fn draw_land(city: &City, backdrop: &Backdrop, view: &View, page: &mut dyn Canvas) {
    page.part("ground");
    draw_shores(backdrop, view, page);
    page.part("heights");
    page.stroke(&backdrop.heights, Pen::new(style::HEIGHT_LINE, view.word() * 0.035));
    page.part("blocks");
    page.fill(&areas(view, city.blocks.iter().map(|block| &block.polygon)), style::BLOCK);
}

/// Draws coloured streets.
pub fn draw_coloured(city: &City, view: &View, colouring: &Colouring, page: &mut dyn Canvas) {
    page.part("streets");
    draw_colours(city, view, colouring, page);
    landmarks::draw(city, view, page);
}

/// Streets in their colours: level by level, lesser classes first, first all rims, then all fills.
fn draw_colours(city: &City, view: &View, colouring: &Colouring, page: &mut dyn Canvas) {
    let mut groups: BTreeMap<(Alike, usize), Lines> = BTreeMap::new();
    for (run, stretches) in city.runs.iter().zip(&colouring.stretches) {
        for stretch in stretches {
            let alike = (run.level, std::cmp::Reverse(run.class), run.half_width);
            let lines = groups.entry((alike, stretch.entry)).or_default();
            lines.push(stretch.line.iter().map(|&at| view.place(at)), false);
        }
    }
    let drawn: Vec<((Alike, usize), Lines)> = groups.into_iter().collect();
    for level in drawn.chunk_by(|a, b| a.0.0.0 == b.0.0.0) {
        for is_rim in [true, false] {
            for (((_, class, half_width), entry), lines) in level {
                let page_share = view.word() / WORD_OF_3000;
                let least = style::least_coloured(city.graph.classes(), class.0) * page_share;
                let width = view.pixels(f64::from(*half_width) * 2.0 / Point::UNITS_PER_METRE).max(least);
                let rim = (width * 0.12).clamp(0.3 * page_share, 1.2 * page_share);
                let colour = colouring.entries[*entry].colour;
                let pen = match is_rim {
                    true => Pen::new(style::rim(colour), width),
                    false => Pen::new(colour, width - 2.0 * rim),
                };
                page.stroke(lines, pen);
            }
        }
    }
}

fn draw_shores(backdrop: &Backdrop, view: &View, page: &mut dyn Canvas) {
    let (corner, size) = view.map();
    match &backdrop.land {
        None => page.fill(&rectangle(corner, size), style::LAND),
        Some(land) => {
            page.fill(&rectangle(corner, size), style::WATER);
            page.fill(land, style::LAND);
            page.stroke(land, Pen::new(style::SHORE, view.word() * 0.05));
        }
    }
    draw_parks(backdrop, page);
}

fn draw_parks(backdrop: &Backdrop, page: &mut dyn Canvas) {
    if let Some(parks) = &backdrop.parks {
        page.fill(parks, style::PARK);
    }
}

/// A map sampled all over the view, every `step` pixels.
fn sampled(map: &Raster, view: &View, step: f64) -> Samples {
    let (_, size) = view.map();
    let count = |pixels: f32| (f64::from(pixels) / step).ceil() as usize + 1;
    Samples::of(count(size[0]), count(size[1]), |column, row| {
        map.bilinear(view.ground([column as f64 * step, row as f64 * step]))
    })
}

/// The outlines of a mask on the page.
fn outlines(mask: &Raster, view: &View) -> Lines {
    let (corner, _) = view.map();
    let step = MASK_STEP as f32;
    let mut lines = Lines::default();
    for (ring, _) in sampled(mask, view, MASK_STEP).smoothed().rimmed(0.0).contours(0.5) {
        // The rim moved everything by one sample.
        let ring: Vec<_> =
            ring.iter().map(|[x, y]| [corner[0] + (x - 1.0) * step, corner[1] + (y - 1.0) * step]).collect();
        lines.push(simplified(&ring, OUTLINE_TOLERANCE), true);
    }
    lines
}

/// Lines of equal height on the page; none where they would lie too close.
fn heights(map: &Raster, view: &View) -> Lines {
    let mut lines = Lines::default();
    let samples = sampled(map, view, HEIGHT_STEP).smoothed();
    let (low, high) = samples.values.iter().fold((f32::MAX, f32::MIN), |(low, high), &v| (low.min(v), high.max(v)));
    let span = f64::from(high - low);
    let Some(step) = HEIGHT_STEPS.into_iter().find(|step| span / step <= 24.0) else { return lines };
    let (corner, _) = view.map();
    let first = (f64::from(low) / step).floor() as i64 + 1;
    // Half a metre off the round numbers: water lies flat on one of them.
    for level in (first..).map(|n| (n as f64 * step + 0.5) as f32).take_while(|&level| level < high) {
        for (line, closed) in samples.contours(level) {
            let points: Vec<_> = line
                .iter()
                .map(|[x, y]| [corner[0] + x * HEIGHT_STEP as f32, corner[1] + y * HEIGHT_STEP as f32])
                .collect();
            lines.push(simplified(&points, OUTLINE_TOLERANCE), closed);
        }
    }
    lines
}

fn draw_parcels(city: &City, view: &View, page: &mut dyn Canvas) {
    for (usage, colour) in [(Use::Open, style::OPEN), (Use::Park, style::PARK), (Use::Plaza, style::PLAZA)] {
        let such = city.parcels.iter().filter(|parcel| parcel.usage == usage);
        page.fill(&areas(view, such.map(|parcel| &parcel.polygon)), colour);
    }
    let area: f64 = city.parcels.iter().map(|parcel| parcel.polygon.area()).sum();
    let typical = (area / city.parcels.len().max(1) as f64).sqrt();
    if view.pixels(typical) >= LEAST_PARCEL {
        let all = areas(view, city.parcels.iter().map(|parcel| &parcel.polygon));
        page.stroke(&all, Pen::new(style::PARCEL_LINE, (view.word() * 0.025).min(view.pixels(0.6)).max(0.3)));
    }
}

fn draw_buildings(city: &City, view: &View, page: &mut dyn Canvas) {
    let mut tones: BTreeMap<usize, Vec<&Polygon>> = BTreeMap::new();
    for building in city.buildings.iter() {
        tones.entry(style::tone(building.height)).or_default().push(&building.footprint);
    }
    for (tone, footprints) in tones {
        page.fill(&areas(view, footprints.into_iter()), style::tone_colour(tone));
    }
}

/// Polygons on the page.
fn areas<'a>(view: &View, polygons: impl Iterator<Item = &'a Polygon>) -> Lines {
    let mut lines = Lines::default();
    for ring in polygons.flat_map(Polygon::rings) {
        lines.push(ring.iter().map(|&p: &Point| view.point(p)), true);
    }
    lines
}

/// Runs drawn alike: by level, then from minor to highway, then by width.
type Alike = (i8, std::cmp::Reverse<Class>, i32);

/// Streets of some levels: level by level, first all casings, then all fills, so that crossings stay open.
fn draw_streets(city: &City, view: &View, page: &mut dyn Canvas, of_level: impl Fn(i8) -> bool) {
    let mut groups: BTreeMap<Alike, Vec<&Run>> = BTreeMap::new();
    for run in city.runs.iter().filter(|run| of_level(run.level)) {
        groups.entry((run.level, std::cmp::Reverse(run.class), run.half_width)).or_default().push(run);
    }
    let drawn: Vec<(Alike, Lines)> =
        groups.into_iter().map(|(alike, runs)| (alike, centre_lines(city, view, &runs))).collect();
    for level in drawn.chunk_by(|a, b| a.0.0 == b.0.0) {
        for casing in [true, false] {
            for (alike, lines) in level {
                page.stroke(lines, street_pen(city, view, *alike, casing));
            }
        }
    }
}

fn centre_lines(city: &City, view: &View, runs: &[&Run]) -> Lines {
    let mut lines = Lines::default();
    for run in runs {
        lines.push(run.nodes.iter().map(|&key| view.point(city.graph.at(key))), false);
    }
    lines
}

fn street_pen(city: &City, view: &View, (level, class, half_width): Alike, casing: bool) -> Pen {
    let style = style::street_style(city.graph.classes(), class.0);
    let page = view.word() / WORD_OF_3000;
    let width = view.pixels(f64::from(half_width) * 2.0 / Point::UNITS_PER_METRE).max(style.least * page);
    let rim = (width * 0.14).clamp(0.35 * page, 1.6 * page);
    let colour: Colour = if casing { style.casing } else { style.fill };
    let pen = Pen::new(colour, if casing { width } else { width - 2.0 * rim });
    match level {
        0 => pen,
        1.. if casing => {
            Pen { width: width + 1.2 * page, colour: style.casing.towards(style::INK, 0.35), ..pen.square() }
        }
        1.. => pen.square(),
        _ => Pen { dash: Some(3.0 * width), ..pen.square() },
    }
}

/// The size of plain words on a page of 3000 pixels.
const WORD_OF_3000: f32 = 3000.0 / 105.0;

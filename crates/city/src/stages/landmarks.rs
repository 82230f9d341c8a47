//! Landmarks: ground that stays free of streets, places that streets are led to, parcels of their own.

use super::Context;
use super::streets::Network;
use crate::Landmark;
use crate::report::Report;
use geom::point::units;
use geom::predicates::{meets, within};
use geom::strip::grown;
use geom::{Angle, Bounds, Id, Point, Polygon, boolean};
use layout::Parcel;
use script::Landmark as Plan;
use std::sync::Arc;
use streets::graph::{Crowding, NewSegment};
use streets::growth::{Field, Fields, Rise, SeedPoint};
use streets::{Claim, Class, NodeId, StreetGraph, StreetId};

/// Besides half of its own width, a street keeps this far from the ground of a landmark, metres: lines are held against
/// polygons every metre, so that a corner may be cut by less.
const CLEARANCE: f64 = 1.0;
/// A landmark is reached where a street passes its ground within this distance, metres.
const REACHED: f64 = 120.0;
/// Beyond what streets keep clear of, growth starts this far from the ground of a landmark, metres.
const GATE: f64 = 2.0;

/// Lays the streets around landmarks, and names streets that were there before and cross their ground.
pub(super) fn lay(context: &Context, network: &mut Network, width: impl Fn(Class) -> f64) {
    for landmark in &context.sources.plan.landmarks {
        for name in crossed_by(landmark, network) {
            network
                .report
                .warn(format!("{name} crosses the ground of landmark `{}`, which is cut there", landmark.name));
        }
        if let Some(class) = landmark.around {
            lay_around(network, landmark, (class, width(class)));
        }
    }
}

/// What to call the streets on the ground of a landmark, each once.
fn crossed_by(landmark: &Plan, network: &Network) -> Vec<String> {
    let Some(bounds) = landmark.ground.bounds() else { return Vec::new() };
    let graph = &network.graph;
    let mut found: Vec<StreetId> = Vec::new();
    graph.for_segments_near(bounds, |key| {
        let (from, to) = graph.line(key.forward());
        let middle = Point::from_metres((from.metres() + to.metres()) / 2.0);
        let meets = |(a, b): (Point, Point)| meets(from, to, a, b);
        if graph.segment(key).level == 0 && (landmark.ground.contains(middle) || landmark.ground.edges().any(meets)) {
            found.push(graph.segment(key).leading().street);
        }
    });
    found.sort_unstable();
    found.dedup();
    let name = |id: &StreetId| network.names.get(id).map_or_else(|| format!("street {id}"), |name| format!("`{name}`"));
    found.iter().map(name).collect()
}

/// What a street around a landmark is known by.
fn street_around(landmark: &Plan) -> StreetId {
    StreetId(Id::root("street around a landmark", &[landmark.id().0]))
}

/// A closed street whose right-of-way ends where the ground begins.
fn lay_around(network: &mut Network, landmark: &Plan, (class, width): (Class, f64)) {
    let (street, half_width) = (street_around(landmark), units(width / 2.0));
    let id = street.0;
    let origin = network.origins.of("landmark");
    let claim = Claim { street, class, half_width, origin, forward: true };
    let ring = grown(&landmark.ground, half_width).outer;
    let node = |i: usize| NodeId(id.child((i % ring.len()) as u64));
    for i in 0..ring.len() {
        let (from, to) = (ring[i], ring[(i + 1) % ring.len()]);
        let new = NewSegment { from, to, from_id: node(i), to_id: node(i + 1), claim, level: 0 };
        if let Err(refusal) = Arc::make_mut(&mut network.graph).insert(&new, Crowding::Join) {
            network.report.warn(format!("street around landmark `{}`, piece {}: {refusal}", landmark.name, i + 1));
        }
    }
    network.names.entry(street).or_insert_with(|| landmark.name.clone());
}

/// The ground that streets of a width (metres) keep off.
fn off_limits(landmark: &Plan, width: f64) -> Polygon {
    match landmark.around {
        // The street around it keeps others at a distance.
        Some(_) => landmark.ground.clone(),
        None => grown(&landmark.ground, units(width / 2.0 + CLEARANCE)),
    }
}

/// Tells growth of the landmarks: where streets of a width may not lie, and what draws them.
pub(super) fn mark(landmarks: &[Plan], fields: &mut Fields, width: f64, are_drawn: bool) {
    for landmark in landmarks {
        fields.zones.keep_free(&off_limits(landmark, width));
    }
    if are_drawn {
        fields.density = raised(landmarks, &fields.density);
        fields.peaks = Default::default();
    }
}

/// A density with the landmarks that draw streets as centres of population.
pub(super) fn raised(landmarks: &[Plan], density: &Field) -> Field {
    let full = density.range().1.max(0.0);
    let drawing = landmarks.iter().filter(|landmark| landmark.attract > 0.0);
    let rise = |landmark: &Plan| Rise {
        at: landmark.middle(),
        height: landmark.attract * full,
        reach: landmark.reach + extent(landmark),
    };
    let rises: Arc<[Rise]> = drawing.map(rise).collect();
    if rises.is_empty() { density.clone() } else { Field::Raised(Box::new(density.clone()), rises) }
}

/// How far the ground reaches from its middle, metres.
fn extent(landmark: &Plan) -> f64 {
    let middle = landmark.middle();
    landmark.ground.outer.iter().map(|corner| corner.metres().distance(middle)).fold(0.0, f64::max)
}

/// Where streets that a landmark draws may start, beside its ground and along it: in the middles of its sides, the
/// longest first.
pub(super) fn gates(landmark: &Plan, width: f64, root: Id) -> Vec<SeedPoint> {
    let ring = grown(&off_limits(landmark, width), units(GATE)).outer;
    let mut sides: Vec<(Point, Point)> = geom::polygon::ring_edges(&ring).collect();
    sides.sort_by_key(|&(a, b)| (std::cmp::Reverse(a.distance_squared(b)), a));
    let root = root.with(&[landmark.id().0]);
    let gate = |(i, (a, b)): (usize, (Point, Point))| SeedPoint {
        at: Point::from_metres((a.metres() + b.metres()) / 2.0),
        heading: Angle::of(b.metres() - a.metres()),
        root: root.child(i as u64),
    };
    sides.into_iter().enumerate().map(gate).collect()
}

/// Whether a street that closes quarters passes near a landmark; one around it does not count.
pub(super) fn is_reached(landmark: &Plan, graph: &StreetGraph) -> bool {
    let (middle, reach) = (Point::from_metres(landmark.middle()), units(extent(landmark) + REACHED));
    let own = street_around(landmark);
    let mut is_reached = false;
    graph.for_segments_near(Bounds::between(middle, middle).grown(reach), |key| {
        let (segment, (from, to)) = (graph.segment(key), graph.line(key.forward()));
        let counts = graph.classes().info(segment.class()).closes_quarters && segment.leading().street != own;
        is_reached |= counts && within(from, to, middle, reach);
    });
    is_reached
}

/// The landmarks that draw streets, the strongest first, then in the script's order.
pub(super) fn drawing(landmarks: &[Plan]) -> Vec<&Plan> {
    let mut drawing: Vec<&Plan> = landmarks.iter().filter(|landmark| landmark.attract > 0.0).collect();
    drawing.sort_by(|a, b| b.attract.total_cmp(&a.attract));
    drawing
}

/// The grounds of all landmarks, in the script's order.
pub(crate) fn grounds(landmarks: &[Plan]) -> Vec<Polygon> {
    landmarks.iter().map(|landmark| landmark.ground.clone()).collect()
}

/// Gives the parcels of landmarks their ids, by size: what cuts a ground in parts renames the largest last. `parts` are
/// parcels with the position of their landmark.
pub(super) fn settle(landmarks: &[Plan], mut parts: Vec<(usize, Parcel)>) -> (Vec<Landmark>, Vec<Parcel>) {
    parts.sort_by_key(|(landmark, parcel)| {
        (*landmark, std::cmp::Reverse(parcel.polygon.doubled_area()), parcel.polygon.outer.first().copied())
    });
    let mut settled: Vec<Landmark> = landmarks.iter().map(finished).collect();
    let mut parcels = Vec::with_capacity(parts.len());
    for (landmark, parcel) in parts {
        let own = &mut settled[landmark];
        let id = Id::root("parcel of a landmark", &[own.id.0]).child(own.parcels.len() as u64);
        own.parcels.push(id);
        parcels.push(Parcel { id, ..parcel });
    }
    settled.sort_by_key(|landmark| landmark.id);
    (settled, parcels)
}

fn finished(plan: &Plan) -> Landmark {
    Landmark {
        id: plan.id(),
        name: plan.name.clone(),
        at: plan.middle(),
        ground: plan.ground.clone(),
        parcels: Vec::new(),
    }
}

/// Names landmarks that became no parcel, or several.
pub(crate) fn tell(landmarks: &[Landmark], report: &mut Report) {
    for landmark in landmarks {
        match landmark.parcels.len() {
            0 => report.warn(format!("landmark `{}` has no parcel: no block lies around it", landmark.name)),
            1 => {}
            several => report.warn(format!("landmark `{}` is cut into {several} parcels", landmark.name)),
        }
    }
}

/// The share of a ground that lies on the site.
pub(crate) fn share_on(site: Bounds, ground: &Polygon) -> f64 {
    let common = boolean::intersection(std::slice::from_ref(ground), &[Polygon::rectangle(site)]);
    common.iter().map(Polygon::area).sum::<f64>() / ground.area().max(f64::MIN_POSITIVE)
}

//! What a tip senses of the ground and the people around it.

use super::{Growing, LONGEST};
use crate::fault::Complaint;
use crate::host::numeric;
use crate::words::getter;
use crate::words::{method, property, within};
use geom::{Angle, Vec2};
use rhai::{Dynamic, Engine};
use streets::growth::Peak;

/// Farthest that a tip looks, in metres.
const FARTHEST: f64 = 100_000.0;
/// Most rays to either side.
const MOST_RAYS: f64 = 90.0;
/// Places that a ray looks at.
const PER_RAY: f64 = 16.0;
/// Places that looking for a shore takes for each metre: 32 rays, a look every 10 m.
const PER_METRE_OF_SHORE: f64 = 3.2;

pub(super) fn register(engine: &mut Engine) {
    ground(engine);
    people(engine);
    places(engine);
}

/// Degrees as scripts have them.
fn degrees(heading: Angle) -> f64 {
    heading.wrapped().to_degrees()
}

fn ground(engine: &mut Engine) {
    property::<Growing, f64>(engine, "slope", "How steep the ground is, rise over run.", |g| g.tip.slope());
    property::<Growing, f64>(engine, "uphill", "The heading straight up, °; its own on flat ground.", |g| {
        degrees(g.tip.uphill())
    });
    property::<Growing, f64>(
        engine,
        "contour",
        "The heading that keeps its height, °, the one nearer to its own.",
        |g| degrees(g.tip.level(0.0)),
    );
    method!(engine, "contour"(length) "The heading that keeps its height over so many metres.", Growing, |g, length| {
        Ok(degrees(g.tip.level(within("the length", length, 0.0, LONGEST, " m")?)))
    });
    method!(engine, "shore"(most) "Metres to water, barred ground such as parks, or the site's rim, `most` where none is that near.", Growing,
    |g, most| {
        let most = within("the distance", most, 0.0, 2000.0, " m")?;
        g.looks.take(most * PER_METRE_OF_SHORE)?;
        Ok(g.tip.shore(most))
    });
}

fn people(engine: &mut Engine) {
    engine.register_type_with_name::<Peak>("a peak");
    getter(engine, "x", "How far east it lies, m.", |peak: &mut Peak| peak.at.x);
    getter(engine, "y", "How far north it lies, m.", |peak: &mut Peak| peak.at.y);
    getter(engine, "density", "People per km² there.", |peak: &mut Peak| peak.density);
    method!(engine, "peak"() "The densest centre of population.", Growing, |g| Ok(g.tip.peak(0)));
    method!(engine, "peak"(rank) "The centre of population of a rank, 0 for the densest.", Growing, |g, rank| {
        Ok(g.tip.peak(within("the rank", rank, 0.0, 1e6, "")? as usize))
    });
    method!(engine, "nearest_peak"() "The nearest centre of population.", Growing, |g| Ok(g.tip.nearest_peak()));
    method!(engine, "seek_density"(radius, spread, rays)
    "The heading, at most `spread` degrees off, whose ray of `radius` metres sums up most density.", Growing,
    |g, radius, spread, rays| {
        let radius = within("the radius", radius, 1.0, FARTHEST, " m")?;
        seek(g, (0.0, radius), spread, rays)
    });
    method!(engine, "seek_density"(near, radius, spread, rays)
    "The same for rays that begin `near` metres away: the next centre, not this one.", Growing,
    |g, near, radius, spread, rays| {
        let radius = within("the radius", radius, 1.0, FARTHEST, " m")?;
        let near = within("the nearest distance", near, 0.0, radius, " m")?;
        seek(g, (near, radius), spread, rays)
    });
}

fn seek(g: &mut Growing, reach: (f64, f64), spread: &Dynamic, rays: &Dynamic) -> Result<f64, Complaint> {
    let spread = Angle::degrees(within("the spread", spread, 0.0, 180.0, "°")?);
    let rays = within("the number of rays", rays, 1.0, MOST_RAYS, "")?.floor();
    g.looks.take((2.0 * rays + 1.0) * PER_RAY)?;
    Ok(degrees(g.tip.seek_density(reach, spread, rays as u32)))
}

fn places(engine: &mut Engine) {
    method!(engine, "towards"(x, y) "The heading to a place.", Growing, |g, x, y| Ok(degrees(g.tip.towards(place(x, y)?))));
    method!(engine, "towards"(peak) "The heading to a peak.", Growing, |g, peak| Ok(degrees(g.tip.towards(peak_of(peak)?))));
    method!(engine, "distance_to"(x, y) "Metres to a place.", Growing, |g, x, y| Ok(g.tip.distance_to(place(x, y)?)));
    method!(engine, "distance_to"(peak) "Metres to a peak.", Growing, |g, peak| Ok(g.tip.distance_to(peak_of(peak)?)));
    method!(engine, "turn_to"(heading) "The turn, in degrees from -180 to 180, that leads to a heading.", Growing, |g, heading| {
        let wanted = Angle::degrees(numeric("the heading", heading)?);
        Ok(degrees(wanted - g.tip.steered()))
    });
}

fn place(x: &Dynamic, y: &Dynamic) -> Result<Vec2, Complaint> {
    Ok(Vec2::new(numeric("x", x)?, numeric("y", y)?))
}

fn peak_of(value: &Dynamic) -> Result<Vec2, Complaint> {
    let peak = value.read_lock::<Peak>().map(|peak| peak.at);
    peak.ok_or_else(|| {
        let message = format!("a place is told as x, y or a peak, not {}", crate::host::kind_of(value));
        Complaint::new(message).hint("tip.towards(1200, 800) or tip.towards(tip.peak())")
    })
}

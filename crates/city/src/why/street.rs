//! Why a street or a crossing is there.

use super::lineage::{Family, Placed, branch_name, distance_to, logs, outcome_says};
use super::{Answer, Evidence, Found, PieceSays, RefusedSays, asked, blend, ground, place};
use crate::sources::import_id;
use crate::trace::{Grown, Trace};
use geom::{Id, Vec2};
use std::collections::{BTreeMap, BTreeSet};
use streets::StreetId;
use streets::growth::RefusedProposal;
use streets::runs::Run;

/// Proposals of other streets are counted that should have ended this close (m) and were refused.
const AROUND: f64 = 25.0;
/// Pieces lie as they were laid, or up to so far (m) beside that, where bends were smoothed.
const FARTHEST: f64 = 20.0;
/// Refused proposals that are told one by one.
const MOST_REFUSED: usize = 40;

/// Explains a run, or all runs of a street.
pub fn explain(found: &Found, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let ids: BTreeSet<&str> =
        found.features.iter().filter_map(|&i| evidence.layout.features[i].properties.id.as_deref()).collect();
    let runs: Vec<&Run> = city.runs.iter().filter(|run| ids.contains(run.id.to_string().as_str())).collect();
    let (Some(first), Some(trace)) = (runs.first(), &evidence.built.trace) else { return };
    tell_street(first, runs.len(), evidence, answer);
    let family = Family::of(trace);
    let pieces = pieces_along(&family, first.street, &lines(evidence, &runs));
    let Some(piece) = pieces.first() else {
        tell_given(first.street, evidence, answer);
        return;
    };
    ground::tell_rules(answer, evidence.sources, piece.stage, piece.quarter);
    answer.lineage = family.ancestry(*piece);
    answer.pieces = pieces.iter().map(|piece| piece_says(piece, evidence)).collect();
    asked::tell_ends(&pieces, trace, evidence, answer);
    if let Some(last) = pieces.last() {
        asked::tell_next(last, trace, evidence, answer);
    }
    tell_refused(&pieces, trace, answer);
    asked::tell_refusals(&pieces, trace, answer);
}

/// What the street is.
fn tell_street(run: &Run, runs: usize, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let class = &city.graph.classes().info(run.class).name;
    let width = f64::from(run.half_width) / 512.0;
    let level = if run.level == 0 { String::new() } else { format!(", level {}", run.level) };
    answer.tell("what", format!("{class}, right-of-way {width} m{level}"));
    let name = city.street_names.get(&run.street).map(|name| format!(" ({name})")).unwrap_or_default();
    let part = if runs > 1 { format!("{runs} stretches of street") } else { "a stretch of street".into() };
    answer.tell("street", format!("{part} {}{name}", run.street));
    if let Some(origin) = city.origins.get(usize::from(run.origin)) {
        answer.tell("made by", origin.clone());
    }
}

/// Where a street, or a stretch of it, comes from that did not grow.
fn tell_given(street: StreetId, evidence: &Evidence, answer: &mut Answer) {
    let plan = &evidence.sources.plan;
    let is_drawn = |ordinal: &usize| StreetId(Id::root("given street", &[*ordinal as u128])) == street;
    if let Some(ordinal) = (0..plan.given.len()).find(is_drawn) {
        let points = plan.given[ordinal].points.len();
        answer.tell("origin", format!("drawn in the city script: line {} of `given`, of {points} points", ordinal + 1));
        return;
    }
    for file in &evidence.sources.imports {
        if let Some(record) = file.streets.iter().find(|record| import_id(&file.key, &record.key) == street) {
            let class = &record.class;
            answer.tell("origin", format!("imported from {}: record {}, class {class}", file.key, record.key));
            return;
        }
    }
    answer.tell("origin", "no growth lies here: it was laid, or led here, once its street had grown");
}

/// The middles of the pieces of runs, metres.
fn lines(evidence: &Evidence, runs: &[&Run]) -> Vec<Vec2> {
    let at = |node: &streets::NodeKey| evidence.built.city.graph.at(*node).metres();
    runs.iter().flat_map(|run| run.nodes.windows(2)).map(|pair| at(&pair[0]).midpoint(at(&pair[1]))).collect()
}

/// The accepted proposals that became these places of a street, in the order of growth.
fn pieces_along<'a>(family: &Family<'a>, street: StreetId, places: &[Vec2]) -> Vec<Placed<'a>> {
    let all = family.of_street(street);
    let distance = |placed: &Placed, at: Vec2| distance_to(at, (placed.accepted.line.from, placed.accepted.line.to));
    let nearest = |at: &Vec2| (0..all.len()).min_by(|&i, &j| distance(&all[i], *at).total_cmp(&distance(&all[j], *at)));
    let is_here = |at: &Vec2, &i: &usize| distance(&all[i], *at) <= FARTHEST;
    let here = places.iter().filter_map(|at| nearest(at).filter(|i| is_here(at, i)));
    let wanted: BTreeSet<usize> = here.collect();
    wanted.into_iter().map(|i| all[i]).collect()
}

fn piece_says(placed: &Placed, evidence: &Evidence) -> PieceSays {
    let accepted = placed.accepted;
    PieceSays {
        lineage: accepted.lineage.id.to_string(),
        step: placed.step(),
        from: place(accepted.start().metres()),
        to: place(accepted.end().metres()),
        outcome: outcome_says(accepted.outcome, asked::changed_by(accepted.lineage.id, evidence)),
        moved: (accepted.proposed.distance(accepted.end()) * 100.0).round() / 100.0,
        patterns: blend::patterns(placed, evidence),
    }
}

/// Why a proposal was refused; by a rule, in its own words.
fn reason_says(refused: &RefusedProposal) -> String {
    match &refused.why {
        Some(why) => format!("{} ({why})", refused.reason),
        None => refused.reason.to_string(),
    }
}

/// What was refused at the ends of pieces, and how often others were refused around them.
fn tell_refused(pieces: &[Placed], trace: &Trace, answer: &mut Answer) {
    let own: BTreeSet<Id> = pieces.iter().map(|placed| placed.accepted.lineage.id).collect();
    let mut around: BTreeMap<String, usize> = BTreeMap::new();
    for log in logs(trace) {
        for refused in &log.log.refused {
            let near = |placed: &Placed| {
                let line = (placed.accepted.line.from, placed.accepted.line.to);
                distance_to(refused.to.metres(), line) <= AROUND
            };
            if own.contains(&refused.lineage.parent) {
                answer.refused.push(RefusedSays {
                    step: log.start.saturating_add(refused.lineage.time),
                    branch: branch_name(refused.lineage.branch),
                    from: place(refused.from.metres()),
                    to: place(refused.to.metres()),
                    reason: reason_says(refused),
                });
            } else if pieces.iter().any(near) {
                *around.entry(reason_says(refused)).or_default() += 1;
            }
        }
    }
    answer.refused.sort_by(|a, b| (a.step, a.branch).cmp(&(b.step, b.branch)));
    if answer.refused.len() > MOST_REFUSED {
        let more = answer.refused.len() - MOST_REFUSED;
        answer.tell("refused", format!("{more} more proposals at its ends than are told below"));
        answer.refused.truncate(MOST_REFUSED);
    }
    let counts: Vec<String> = around.into_iter().map(|(reason, count)| format!("{count} × {reason}")).collect();
    if !counts.is_empty() {
        answer.tell("around", format!("other proposals refused within {AROUND} m of it: {}", counts.join("; ")));
    }
    tell_dropped(&own, trace, answer);
}

/// What grew from these pieces in a quarter but found no room in the city.
fn tell_dropped(own: &BTreeSet<Id>, trace: &Trace, answer: &mut Answer) {
    for (_, stage) in trace.stages() {
        let Grown::InQuarters { merge, .. } = &stage.grown else { continue };
        for dropped in &merge.dropped {
            let (id, parent) = (dropped.lineage.id, dropped.lineage.parent);
            if own.contains(&id) || own.contains(&parent) {
                let what = if own.contains(&id) { "part of it" } else { "a street from its end" };
                let how = if dropped.is_shortened { "ends before the rim" } else { "was left out" };
                answer.tell("dropped", format!("{what} grew in the quarter but {how}: {}", dropped.reason));
            }
        }
    }
}

/// Explains a crossing: which streets meet, and how each came to be there.
pub fn explain_crossing(found: &Found, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let node = found.id.parse::<Id>().ok().and_then(|id| city.graph.find_node(streets::NodeId(id)));
    let Some(node) = node else { return };
    let met = match city.graph.degree(node) {
        1 => "a street ends here".to_owned(),
        count => format!("{count} streets meet here"),
    };
    answer.tell("what", met);
    for run in city.runs.iter().filter(|run| run.from() == node || run.to() == node) {
        let class = &city.graph.classes().info(run.class).name;
        let origin = city.origins.get(usize::from(run.origin)).map_or("", String::as_str);
        answer.tell("meets", format!("{class} {} of street {}, by {origin}", run.id, run.street));
    }
    let Some(trace) = &evidence.built.trace else { return };
    let at = city.graph.at(node);
    let family = Family::of(trace);
    let mut here: Vec<&Placed> = family.all().filter(|placed| placed.accepted.end() == at).collect();
    here.sort_by_key(|placed| (placed.step(), placed.accepted.lineage.id));
    answer.pieces = here.iter().map(|placed| piece_says(placed, evidence)).collect();
    if let Some(placed) = here.first() {
        ground::tell_rules(answer, evidence.sources, placed.stage, placed.quarter);
        answer.lineage = family.ancestry(**placed);
        let pieces: Vec<Placed> = here.into_iter().copied().collect();
        asked::tell_ends(&pieces, trace, evidence, answer);
        for piece in &pieces {
            asked::tell_next(piece, trace, evidence, answer);
        }
        tell_refused(&pieces, trace, answer);
        asked::tell_refusals(&pieces, trace, answer);
    } else {
        answer.tell("origin", "no growth ended here: streets cross that were given, or one was led here later");
    }
}

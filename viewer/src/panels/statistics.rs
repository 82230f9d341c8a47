//! Counts and lengths of the city, and what can be measured of it beside the real place.

use super::busy;
use crate::evidence::Statistics;
use crate::state::{Command, State};
use city::measure::{Figure, MEASURES};
use eframe::egui::{Grid, Ui};

/// Shows them.
pub fn ui(ui: &mut Ui, state: &mut State) {
    let Some(ready) = state.ready.clone() else {
        ui.weak("Figures of a city are shown once it is open.");
        return;
    };
    let report = &ready.built.report;
    Grid::new("counts").num_columns(2).striped(true).show(ui, |ui| {
        for (name, count) in &report.counts {
            ui.label(*name);
            ui.label(count.to_string());
            ui.end_row();
        }
        for (class, metres) in &report.street_metres {
            ui.label(format!("{class} streets"));
            ui.label(format!("{:.1} km", metres / 1000.0));
            ui.end_row();
        }
        ui.label("made in");
        ui.label(format!("{:.2} s", ready.took.as_secs_f64()));
        ui.end_row();
    });
    ui.separator();
    match &state.statistics.done {
        Some(Ok(statistics)) => measures(ui, statistics),
        Some(Err(error)) => {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        None if state.statistics.is_busy() => {
            ui.horizontal(|ui| {
                busy(ui);
                ui.label("The city is being measured");
            });
        }
        // What is looked at is measured; what is hidden is not.
        None => state.commands.push(Command::Measure),
    }
}

/// The figures of the whole, then of the windows that the ranges ask for.
fn measures(ui: &mut Ui, statistics: &Statistics) {
    let judged = statistics.verdict.as_ref().map_or(&[][..], |verdict| &verdict.judged);
    match &statistics.verdict {
        Some(verdict) => {
            let words = format!("{} of {} as in {}", verdict.good(), verdict.judged.len(), verdict.place);
            ui.strong(words.replace('_', " "));
        }
        None => {
            let help = "A file `ranges.json` in the city's folder says where they lie in a real place: see `plat stats --help`";
            ui.strong("Measures").on_hover_text(help);
        }
    }
    Grid::new("measures").num_columns(2).striped(true).show(ui, |ui| {
        for measure in &MEASURES {
            let Some(figure) = statistics.figures.get(measure.name) else { continue };
            let range = judged.iter().find(|judged| judged.window.is_none() && judged.measure == measure.name);
            ui.label(words_of(measure.name)).on_hover_text(measure.about);
            let figure = format!("{} {}", words(figure), measure.unit);
            ui.vertical(|ui| standing(ui, figure.trim_end(), range));
            ui.end_row();
        }
        for judged in judged.iter().filter(|judged| judged.window.is_some()) {
            let window = judged.window.as_deref().unwrap_or_default().replace('_', " ");
            ui.label(format!("{window}: {}", words_of(&judged.measure)));
            let figure = judged.figure.map_or_else(|| "–".into(), words);
            ui.vertical(|ui| standing(ui, &figure, Some(judged)));
            ui.end_row();
        }
    });
}

/// A figure, where it should lie, and whether it does.
fn standing(ui: &mut Ui, figure: &str, judged: Option<&city::measure::Judged>) {
    ui.label(figure);
    let Some(judged) = judged else { return };
    let range = judged.range.to_string();
    if judged.is_good() {
        ui.weak(range).on_hover_text("As in the real place");
    } else {
        let words = format!("{range}, off");
        ui.colored_label(ui.visuals().warn_fg_color, words).on_hover_text("Not as in the real place");
    }
}

/// A measure's name as words, without the unit that stands behind it.
fn words_of(name: &str) -> String {
    let bare = match name {
        "km2" => "area",
        "km_per_km2" => "streets",
        "steep_km" => "steep streets",
        "grade_p95" => "grade, 95th percentile",
        "segment_cv" => "segment spread",
        "x_share" => "four-way share",
        "t_share" => "three-way share",
        _ => ["_km2", "_ha"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name),
    };
    bare.replace('_', " ")
}

fn words(figure: Figure) -> String {
    let number = |value: f64| match value.abs() {
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    };
    match figure {
        Figure::Number(value) => number(value),
        Figure::Headings([a, b]) => format!("{a:.1}, {b:.1}"),
    }
}

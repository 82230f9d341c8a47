//! The panels. They read the state and leave commands; none of them changes the city.

pub mod console;
pub mod inspector;
pub mod layers;
pub mod parameters;
pub mod presets;
pub mod problems;
pub mod source;
pub mod statistics;
pub mod timeline;

use crate::state::State;
use crate::viewport::{View, view};
use eframe::egui::{self, ScrollArea, Ui};
use eframe::egui_wgpu::RenderState;
use serde::{Deserialize, Serialize};

/// What can be docked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Pane {
    /// A view of the city.
    View(View),
    /// Presets with pictures.
    Presets,
    /// What can be set.
    Parameters,
    /// What is shown.
    Layers,
    /// What is picked.
    Inspector,
    /// Counts and lengths.
    Statistics,
    /// What is wrong.
    Problems,
    /// How the city grew.
    Timeline,
    /// Scripts typed by people.
    Console,
    /// The text of a script.
    Source,
}

impl Pane {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::View(view) => view.name(),
            Self::Presets => "Presets",
            Self::Parameters => "Parameters",
            Self::Layers => "Layers",
            Self::Inspector => "Inspector",
            Self::Statistics => "Statistics",
            Self::Problems => "Problems",
            Self::Timeline => "Timeline",
            Self::Console => "Console",
            Self::Source => "Source",
        }
    }

    /// Those besides the views, in the order of the menu.
    pub const PANELS: [Self; 9] = [
        Self::Presets,
        Self::Parameters,
        Self::Layers,
        Self::Inspector,
        Self::Statistics,
        Self::Problems,
        Self::Timeline,
        Self::Console,
        Self::Source,
    ];
}

/// How the panes are laid out in a tree of docks.
pub struct Docks<'a> {
    /// What there is to show.
    pub state: &'a mut State,
    /// What draws.
    pub render: Option<&'a RenderState>,
    /// Becomes true where people lay them out otherwise.
    pub changed: &'a mut bool,
}

impl egui_tiles::Behavior<Pane> for Docks<'_> {
    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        let of = |ready: &std::sync::Arc<crate::worker::Ready>| ready.built.report.faults.len() + ready.unsuited.len();
        let built = self.state.ready.as_ref().map_or(0, of);
        let built = built + usize::from(self.state.misread.is_some());
        let faults = built + self.state.failure.as_ref().map_or(0, |failure| failure.faults.len().max(1));
        match pane {
            Pane::Problems if faults > 0 => format!("Problems ({faults})").into(),
            pane => pane.name().into(),
        }
    }

    fn pane_ui(&mut self, ui: &mut Ui, _: egui_tiles::TileId, pane: &mut Pane) -> egui_tiles::UiResponse {
        if let Pane::View(which) = *pane {
            view(ui, self.state, self.render, which);
            return egui_tiles::UiResponse::None;
        }
        let show: fn(&mut Ui, &mut State) = match pane {
            Pane::Presets => presets::ui,
            Pane::Parameters => parameters::ui,
            Pane::Layers => layers::ui,
            Pane::Inspector => inspector::ui,
            Pane::Statistics => statistics::ui,
            Pane::Problems => problems::ui,
            Pane::Timeline => timeline::ui,
            Pane::Console => console::ui,
            Pane::Source => source::ui,
            Pane::View(_) => return egui_tiles::UiResponse::None,
        };
        // Long texts scroll by themselves.
        let scrolls_alone = matches!(pane, Pane::Console | Pane::Source);
        ui.painter().rect_filled(ui.max_rect(), 0.0, ui.visuals().panel_fill);
        egui::Frame::central_panel(ui.style()).show(ui, |ui| {
            if scrolls_alone {
                show(ui, self.state);
            } else {
                let width = ui.available_width() - ui.spacing().scroll.allocated_width();
                ScrollArea::both().id_salt(pane.name()).auto_shrink(false).show(ui, |ui| {
                    // Words stay in sight; what cannot be broken is scrolled to.
                    ui.set_max_width(width);
                    show(ui, self.state);
                });
            }
        });
        egui_tiles::UiResponse::None
    }

    fn on_edit(&mut self, _: egui_tiles::EditAction) {
        *self.changed = true;
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions { all_panes_must_have_tabs: true, ..Default::default() }
    }
}

/// The panes as they stand at first.
pub fn usual() -> egui_tiles::Tree<Pane> {
    let mut tiles = egui_tiles::Tiles::default();
    let mut tabs = |panes: &[Pane]| {
        let panes = panes.iter().map(|pane| tiles.insert_pane(*pane)).collect();
        tiles.insert_tab_tile(panes)
    };
    let left = tabs(&[Pane::Presets, Pane::Parameters, Pane::Layers]);
    let map = tabs(&[Pane::View(View::Map)]);
    let model = tabs(&[Pane::View(View::Model)]);
    let right = tabs(&[Pane::Inspector, Pane::Statistics]);
    let below = tabs(&[Pane::Problems, Pane::Timeline, Pane::Console, Pane::Source]);
    let above = tiles.insert_horizontal_tile(vec![left, map, model, right]);
    let root = tiles.insert_vertical_tile(vec![above, below]);
    for (container, shares) in
        [(above, vec![(left, 0.9), (map, 1.5), (model, 1.5), (right, 0.9)]), (root, vec![(above, 1.0), (below, 0.22)])]
    {
        if let Some(egui_tiles::Tile::Container(egui_tiles::Container::Linear(linear))) = tiles.get_mut(container) {
            shares.into_iter().for_each(|(tile, share)| linear.shares.set_share(tile, share));
        }
    }
    egui_tiles::Tree::new(egui::Id::unique("docks"), root, tiles)
}

/// Panes laid out in docks, as they are kept from one start to the next.
pub fn written(docks: &egui_tiles::Tree<Pane>) -> Option<serde_json::Value> {
    serde_json::to_value(docks).ok()
}

/// Panes as they were laid out; the usual way where what was kept does not hold each of them once.
pub fn read(kept: Option<&serde_json::Value>) -> egui_tiles::Tree<Pane> {
    let read = || serde_json::from_value::<egui_tiles::Tree<Pane>>(kept?.clone()).ok();
    read().filter(|docks| panes(docks) == panes(&usual())).unwrap_or_else(usual)
}

/// All that can be reached in docks.
fn panes(docks: &egui_tiles::Tree<Pane>) -> Vec<Pane> {
    let (mut found, mut left, mut seen) = (Vec::new(), Vec::from_iter(docks.root()), Vec::new());
    while let Some(id) = left.pop() {
        // What was edited by hand may go in circles.
        if seen.contains(&id) {
            continue;
        }
        seen.push(id);
        match docks.tiles.get(id) {
            Some(egui_tiles::Tile::Pane(pane)) => found.push(*pane),
            Some(egui_tiles::Tile::Container(container)) => left.extend(container.children().copied()),
            None => {}
        }
    }
    found.sort();
    found
}

/// Turns of the sign that something is under way, a second.
const STEPS_A_SECOND: f64 = 4.0;

/// Shows that something is under way. It turns step by step: egui's own spinner has the window painted as often as can be, and
/// where that is done in software, what is under way waits for it.
pub fn busy(ui: &mut Ui) {
    let size = ui.style().spacing.interact_size.y;
    let (place, response) = ui.allocate_exact_size(egui::Vec2::splat(size), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ProgressIndicator, true, "Under way"));
    let step = (ui.input(|input| input.time) * STEPS_A_SECOND) as usize % 8;
    for i in 0..8 {
        let way = egui::Vec2::angled(i as f32 * std::f32::consts::TAU / 8.0) * (size * 0.32);
        let strength = if i == step { 1.0 } else { 0.3 };
        let colour = ui.visuals().text_color().gamma_multiply(strength);
        ui.painter().circle_filled(place.center() + way, size * 0.08, colour);
    }
    ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(1.0 / STEPS_A_SECOND));
}

/// Names a widget that shows none, for those who hear what others see.
fn called(response: egui::Response, name: &str) -> egui::Response {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
    response
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    #[test]
    fn docks_are_read_as_they_were_written_and_broken_ones_are_as_none() {
        let mut docks = usual();
        docks.make_active(|_, tile| matches!(tile, egui_tiles::Tile::Pane(Pane::Console)));
        let kept = written(&docks).unwrap();
        assert_eq!(read(Some(&kept)), docks);
        assert_ne!(docks, usual());
        assert_eq!(read(None), usual());
        assert_eq!(read(Some(&Value::from("docks"))), usual());
        let text = kept.to_string();
        let lost = text.replacen("\"Console\"", "\"Source\"", 1);
        assert_ne!(lost, text);
        assert_eq!(read(Some(&serde_json::from_str(&lost).unwrap())), usual(), "one panel twice, another not at all");
    }
}

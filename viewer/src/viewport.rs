//! The views: a map and a model of the same city, drawn when something changed and shown as pictures.

use crate::inspect::polygon_of;
use crate::preferences::Bookmark;
use crate::render::{Camera, Cost, Gpu, MapCamera, OrbitCamera, Overlay, Renderer, Target};
use crate::scene::{Element, ElementKind, Scene, at, near_ray};
use crate::shown::shown;
use crate::state::{Command, State};
use city::City;
use eframe::egui::{self, Color32, Key, PointerButton, Pos2, Rect, Sense, Stroke, TextureId, Ui, Vec2 as Size};
use eframe::egui_wgpu::RenderState;
use geom::{Bounds, Point, Vec2, Vec3};

/// Which of the views.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum View {
    /// From above.
    Map,
    /// In space.
    Model,
}

impl View {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Map => "Map",
            Self::Model => "Model",
        }
    }
}

/// A view with its camera.
#[derive(Debug)]
pub struct Viewport<C> {
    /// Where one looks from.
    pub camera: C,
    surface: Surface,
}

/// What is painted on for a view.
#[derive(Debug, Default)]
struct Surface {
    target: Option<Target>,
    texture: Option<TextureId>,
    /// What was painted last.
    painted: Option<String>,
    /// What that cost.
    cost: Cost,
}

/// Both views, and what draws them.
#[derive(Debug)]
pub struct Viewports {
    /// The map.
    pub map: Viewport<MapCamera>,
    /// The model.
    pub model: Viewport<OrbitCamera>,
    /// How things are shown.
    pub look: crate::render::Look,
    renderer: Option<Renderer>,
    overlay: Option<(String, Overlay)>,
    /// What the map and the model are to show as soon as their room is known; the model with the height of the ground.
    to_fit: (Option<Bounds>, Option<(Bounds, f64)>),
    /// Least and greatest place of the ground in sight.
    sight: Option<(Vec2, Vec2)>,
}

/// A place of an open view before anything is known of its city.
const NOWHERE: Bounds = Bounds { min: Point::new(0, 0), max: Point::new(1 << 20, 1 << 20) };

/// Least metres of the ground along a side that are shown in the model.
const LEAST_SIDE: f64 = 160.0;

/// Metres to the pixel at which a place on a map is told from others.
const NEAR_SCALE: f64 = 0.6;

/// Metres to a place in the model from which it is told from others.
const NEAR_DISTANCE: f64 = 450.0;

impl Viewports {
    /// Views of nothing yet.
    pub fn new(gpu: Option<Gpu>) -> Self {
        Self {
            map: Viewport { camera: MapCamera::over(NOWHERE, [800.0, 600.0]), surface: Surface::default() },
            model: Viewport { camera: OrbitCamera::over(NOWHERE, 0.0), surface: Surface::default() },
            look: crate::render::Look::default(),
            renderer: gpu.map(Renderer::new),
            overlay: None,
            to_fit: (None, None),
            sight: None,
        }
    }

    /// Looks at some ground, on which things stand so many metres high.
    pub fn fit(&mut self, bounds: Bounds, high: f64, city: &City) {
        let middle = (bounds.min.metres() + bounds.max.metres()) / 2.0;
        // With what stands around it: from nearby a tower hides itself.
        let side = bounds.size().min_element();
        let around = ((high * 3.0).max(LEAST_SIDE) - side).max(0.0) / 2.0;
        let wider = bounds.grown(geom::point::units(around));
        self.to_fit = (Some(bounds), Some((wider, city.site.elevation(middle) + high / 2.0)));
    }

    /// Looks where it is to look, now that the room of a view is known.
    fn settle(&mut self, which: View, pixels: [f32; 2]) {
        match which {
            View::Map => {
                if let Some(bounds) = self.to_fit.0.take() {
                    self.map.camera = MapCamera::over(bounds, pixels);
                }
            }
            View::Model => {
                if let Some((bounds, height)) = self.to_fit.1.take() {
                    let OrbitCamera { heading, pitch, .. } = self.model.camera;
                    self.model.camera = OrbitCamera::towards(bounds, height, (heading, pitch), pixels.map(f64::from));
                }
            }
        }
    }

    /// Moves both views over a place, near enough to see what stands there.
    pub fn look_at(&mut self, place: Vec2) {
        self.map.camera.centre = place;
        self.map.camera.scale = self.map.camera.scale.min(NEAR_SCALE);
        self.model.camera.target = place.extend(self.model.camera.target.z);
        self.model.camera.distance = self.model.camera.distance.min(NEAR_DISTANCE);
    }

    /// Where one looks from now, by a name.
    pub fn bookmark(&self, name: &str) -> Bookmark {
        Bookmark { name: name.to_owned(), map: self.map.camera, model: self.model.camera }
    }

    /// Looks from where that was kept.
    pub fn go_to(&mut self, kept: &Bookmark) {
        (self.map.camera, self.model.camera) = (kept.map, kept.model);
        self.to_fit = (None, None);
    }

    /// The ground that was in sight since this was asked last.
    pub fn take_sight(&mut self) -> Option<(Vec2, Vec2)> {
        self.sight.take()
    }

    /// Takes in what a view of so many pixels sees.
    fn see(&mut self, which: View, pixels: [f32; 2]) {
        let corners = [[0.0, 0.0], [pixels[0], 0.0], [0.0, pixels[1]], pixels];
        let place = |corner: [f32; 2]| match which {
            View::Map => self.map.camera.place(corner, pixels),
            View::Model => self.model.camera.ground(corner, pixels),
        };
        let places = corners.map(place);
        let (mut low, mut high) = self.sight.unwrap_or((places[0], places[0]));
        for place in places {
            (low, high) = (low.min(place), high.max(place));
        }
        self.sight = Some((low, high));
    }

    /// What the last frame of a view cost.
    pub fn cost(&self, view: View) -> Cost {
        match view {
            View::Map => self.map.surface.cost,
            View::Model => self.model.surface.cost,
        }
    }
}

/// Shows a view in all the room there is.
pub fn view(ui: &mut Ui, state: &mut State, render: Option<&RenderState>, which: View) {
    let size = ui.available_size().max(Size::splat(1.0));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag() | Sense::focusable_noninteractive());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, format!("{} view", which.name())));
    let Some(ready) = state.ready.clone() else {
        let words = match (&state.city, &state.failure) {
            (None, _) => "Open a city to see it here",
            (Some(_), Some(_)) => "There is no city yet: see Problems",
            (Some(_), None) => "The city is being built",
        };
        nothing(ui, words, rect);
        return;
    };
    // Otherwise arrows would go to the next control.
    let arrows = egui::EventFilter { horizontal_arrows: true, vertical_arrows: true, ..Default::default() };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, arrows));
    let scale = ui.ctx().pixels_per_point();
    let pixels = [rect.width() * scale, rect.height() * scale].map(|side| side.round().max(1.0));
    state.views.settle(which, pixels);
    let pointer = |at: Pos2| [(at.x - rect.min.x) * scale, (at.y - rect.min.y) * scale];
    move_camera(ui, state, which, &response, pixels, pointer, scale);
    if response.clicked() {
        response.request_focus();
        // Enter and space click, too: what lies in the middle is meant.
        let at = response.interact_pointer_pos().unwrap_or(rect.center());
        let picked = pick(state, which, &ready.built.city, pointer(at), pixels);
        state.commands.push(Command::Select(next(&picked, state.selected.as_ref())));
    }
    if response.double_clicked() {
        state.commands.push(Command::Fit);
    }
    let (Some(scene), Some(render)) = (&ready.scene, render) else {
        nothing(ui, "No graphics adapter: nothing can be drawn", rect);
        return;
    };
    let glimpse = state.glimpse.clone();
    let scene = glimpse.as_deref().unwrap_or(scene);
    if which == View::Model && scene.model().is_none() {
        nothing(ui, "The model is being made", rect);
        return;
    }
    let painted = paint(state, render, scene, &ready.built.city, which, pixels.map(|side| side as u32));
    match painted {
        Ok(texture) => {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
        Err(error) => state.message = Some(error),
    }
    focus(ui, &response, rect);
    state.views.see(which, pixels);
    match which {
        View::Map => {
            marks(ui, state, &ready.built.report, rect, pixels, scale);
            outline(ui, state, &ready.built.city, rect, |[a, b]| {
                Some([a, b].map(|place| on_screen(state, place, rect, pixels, scale)))
            });
        }
        View::Model => {
            let (camera, city) = (state.views.model.camera, &ready.built.city);
            let seen = |ends: [Vec3; 2]| {
                let seen = camera.pixels_of(ends, pixels)?;
                Some(seen.map(|[x, y]| Pos2::new(rect.min.x + x / scale, rect.min.y + y / scale)))
            };
            match state.selected.as_ref().and_then(|picked| building(city, picked)) {
                Some(building) => draw_edges(ui, rect, box_of(building).into_iter().filter_map(seen)),
                None => outline(ui, state, city, rect, |ends| {
                    seen(ends.map(|place| place.extend(city.site.elevation(place) + ABOVE)))
                }),
            }
        }
    }
}

/// Says why there is nothing to see.
fn nothing(ui: &Ui, words: &str, rect: Rect) {
    ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
    let colour = ui.visuals().text_color();
    ui.painter().text(rect.center(), egui::Align2::CENTER_CENTER, words, egui::FontId::proportional(16.0), colour);
}

/// Shows that keys are meant for a view, and which place they would pick.
fn focus(ui: &Ui, response: &egui::Response, rect: Rect) {
    if !response.has_focus() {
        return;
    }
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_stroke(rect, 0.0, Stroke::new(2.0, ui.visuals().selection.bg_fill), egui::StrokeKind::Inside);
    if !response.hovered() {
        let at = rect.center();
        for stroke in [Stroke::new(3.0, Color32::WHITE), Stroke::new(1.0, Color32::BLACK)] {
            painter.line_segment([at - Size::new(7.0, 0.0), at + Size::new(7.0, 0.0)], stroke);
            painter.line_segment([at - Size::new(0.0, 7.0), at + Size::new(0.0, 7.0)], stroke);
        }
    }
}

/// Steps of the keyboard, in pixels.
const STEP: f32 = 60.0;

fn move_camera(
    ui: &Ui,
    state: &mut State,
    which: View,
    response: &egui::Response,
    pixels: [f32; 2],
    pointer: impl Fn(Pos2) -> [f32; 2],
    scale: f32,
) {
    let drag = response.drag_delta() * scale;
    let drag = [drag.x, drag.y];
    let scroll = if response.hovered() { ui.input(|input| input.smooth_scroll_delta().y) } else { 0.0 };
    let pinch = if response.hovered() { ui.input(egui::InputState::zoom_delta) } else { 1.0 };
    let mut factor = f64::from((scroll * 0.004).exp() * pinch);
    let (alt, shift) = ui.input(|input| (input.modifiers.alt, input.modifiers.shift));
    let mut keys = [0.0f32; 2];
    if response.has_focus() {
        ui.input(|input| {
            for (key, way) in [
                (Key::ArrowLeft, [STEP, 0.0]),
                (Key::ArrowRight, [-STEP, 0.0]),
                (Key::ArrowUp, [0.0, STEP]),
                (Key::ArrowDown, [0.0, -STEP]),
            ] {
                // Several times where frames are slow.
                let times = input.num_presses(key) as f32;
                keys = [keys[0] + way[0] * times, keys[1] + way[1] * times];
            }
            for (key, by) in [(Key::Plus, 1.25f64), (Key::Equals, 1.25), (Key::Minus, 0.8)] {
                factor *= by.powf(input.num_presses(key) as f64);
            }
        });
    }
    let under = response.hover_pos().map_or([pixels[0] / 2.0, pixels[1] / 2.0], pointer);
    match which {
        View::Map => {
            let camera = &mut state.views.map.camera;
            if response.dragged() {
                camera.drag(drag);
            }
            camera.drag(keys);
            if (factor - 1.0).abs() > 1e-6 {
                camera.zoom(factor, under, pixels);
            }
        }
        View::Model => {
            let camera = &mut state.views.model.camera;
            // As in Maya with Alt held, and without it as on a map with three buttons.
            if response.dragged_by(PointerButton::Primary) {
                camera.turn(drag);
            } else if response.dragged_by(PointerButton::Middle) {
                camera.pan(drag, pixels[1]);
            } else if response.dragged_by(PointerButton::Secondary) {
                if alt {
                    camera.zoom(f64::from((drag[0] - drag[1]) * 0.005).exp())
                } else {
                    camera.pan(drag, pixels[1])
                }
            }
            if shift {
                camera.turn(keys);
            } else {
                camera.pan(keys, pixels[1]);
            }
            camera.zoom(factor);
        }
    }
}

/// What lies under a pixel, from the smallest to the largest.
fn pick(state: &State, which: View, city: &City, pixel: [f32; 2], pixels: [f32; 2]) -> Vec<Element> {
    let place = match which {
        View::Map => Some(state.views.map.camera.place(pixel, pixels)),
        View::Model => {
            let (from, way) = state.views.model.camera.ray(pixel, pixels);
            near_ray(city, from, way)
        }
    };
    place.map_or(Vec::new(), |place| at(city, place))
}

/// A click picks the smallest thing, one more on the same what lies around it.
fn next(found: &[Element], selected: Option<&Element>) -> Option<Element> {
    let known = selected.and_then(|selected| found.iter().position(|element| element == selected));
    known.map_or_else(|| found.first(), |known| found.get((known + 1) % found.len())).cloned()
}

/// Paints a view where anything is another than before; returns the texture that shows it.
fn paint(
    state: &mut State,
    render: &RenderState,
    scene: &Scene,
    city: &City,
    which: View,
    size: [u32; 2],
) -> Result<TextureId, String> {
    let Viewports { map, model, look, renderer, overlay, to_fit: _, sight: _ } = &mut state.views;
    let Some(renderer) = renderer else { return Err("no graphics adapter".into()) };
    let (camera, surface) = match which {
        View::Map => (Camera::Map(map.camera), &mut map.surface),
        View::Model => (Camera::Orbit(model.camera), &mut model.surface),
    };
    let wanted = state.overlay.0.as_ref();
    let round = state.ready.as_ref().map(|ready| ready.round);
    let moment = state.timeline.moment.clone();
    let step = moment.as_ref().map(|moment| moment.step);
    let grown = state.growth.done.as_ref().filter(|_| state.by_growth).and_then(|grown| grown.as_ref().ok());
    let layers = &state.preferences.layers;
    let grows = grown.is_some();
    let glimpse = state.glimpse.as_ref().map(|_| state.glimpses);
    let key = format!(
        "{round:?} {glimpse:?} {step:?} {grows} {camera:?} {look:?} {size:?} {layers:?} {wanted:?} {}",
        state.overlay.1
    );
    if let (Some(texture), Some(painted)) = (surface.texture, &surface.painted)
        && *painted == key
    {
        return Ok(texture);
    }
    let tag = wanted.map(|name| format!("{round:?} {name}"));
    if overlay.as_ref().map(|(tag, _)| tag) != tag.as_ref() {
        let map = wanted.and_then(|name| city.site.map(name));
        *overlay = map.zip(tag).map(|(map, tag)| (tag, Overlay::of(renderer.gpu(), map, 0.0)));
    }
    if let Some((_, overlay)) = overlay {
        overlay.opacity = state.overlay.1;
    }
    if surface.target.as_ref().is_none_or(|target| target.size() != size) {
        let target = Target::new(renderer.gpu(), size).map_err(|error| error.to_string())?;
        let mut egui = render.renderer.write();
        let filter = wgpu::FilterMode::Nearest;
        match surface.texture {
            Some(texture) => {
                egui.update_egui_texture_from_wgpu_texture(&render.device, target.shown(), filter, texture);
            }
            None => surface.texture = Some(egui.register_native_texture(&render.device, target.shown(), filter)),
        }
        surface.target = Some(target);
    }
    let (Some(target), Some(texture)) = (&surface.target, surface.texture) else { return Err("no target".into()) };
    let overlay = overlay.as_ref().map(|(_, overlay)| overlay);
    let map_now = moment.as_ref().and_then(|moment| moment.map.as_ref()).or(grown);
    surface.cost =
        renderer.draw(target, &camera, &shown(scene, map_now, &camera, &state.preferences.layers, overlay, *look));
    surface.painted = Some(key);
    Ok(texture)
}

/// Most marks that are drawn.
const MOST_MARKS: usize = 2000;

/// Where rules marked places or went wrong, over the map.
fn marks(ui: &Ui, state: &State, report: &city::Report, rect: Rect, pixels: [f32; 2], scale: f32) {
    if !state.preferences.layers.marks {
        return;
    }
    let failed = state.failure.iter().flat_map(|failure| &failure.faults);
    let faults = report.faults.iter().chain(failed).filter_map(|fault| Some((fault.place?, fault.is_error())));
    let marked = report.marks.iter().map(|mark| (mark.place, false));
    let painter = ui.painter().with_clip_rect(rect);
    for (place, is_error) in marked.chain(faults).take(MOST_MARKS) {
        let at = on_screen(state, Vec2::from_array(place), rect, pixels, scale);
        if rect.expand(8.0).contains(at) {
            let colour =
                if is_error { Color32::from_rgb(0xc6, 0x28, 0x28) } else { Color32::from_rgb(0x6a, 0x1b, 0x9a) };
            painter.circle_stroke(at, 6.0, Stroke::new(4.0, Color32::WHITE));
            painter.circle_stroke(at, 6.0, Stroke::new(2.0, colour));
            painter.circle_filled(at, 1.5, colour);
        }
    }
}

/// Where a place lies on the map as it is shown, in points.
fn on_screen(state: &State, place: Vec2, rect: Rect, pixels: [f32; 2], scale: f32) -> Pos2 {
    let [x, y] = state.views.map.camera.pixel(place, pixels);
    Pos2::new(rect.min.x + x / scale, rect.min.y + y / scale)
}

/// Metres that rims lie above the ground in the model.
const ABOVE: f64 = 1.0;

/// Longest piece of a rim in metres: it follows the ground.
const PIECE: f64 = 25.0;

/// Most pieces of a rim that are drawn; longer ones are drawn more coarsely.
const MOST_PIECES: f64 = 4000.0;

/// The rim of what is picked, over a view that shows pieces of it where it says.
fn outline(ui: &Ui, state: &State, city: &City, rect: Rect, on_view: impl Fn([Vec2; 2]) -> Option<[Pos2; 2]>) {
    let Some(polygon) = state.selected.as_ref().and_then(|element| polygon_of(city, element)) else { return };
    let edges = polygon.rings().flat_map(|ring| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| (a.metres(), b.metres()))
    });
    let edges: Vec<(Vec2, Vec2)> = edges.collect();
    let length: f64 = edges.iter().map(|(a, b)| a.distance(*b)).sum();
    let piece = PIECE.max(length / MOST_PIECES);
    let mut pieces = Vec::new();
    for (a, b) in edges {
        let count = (a.distance(b) / piece).ceil().max(1.0);
        let at = |i: f64| a.lerp(b, i / count);
        pieces.extend((0..count as usize).filter_map(|i| on_view([at(i as f64), at(i as f64 + 1.0)])));
    }
    draw_edges(ui, rect, pieces.into_iter());
}

/// Draws the edges of what is picked.
fn draw_edges(ui: &Ui, rect: Rect, edges: impl Iterator<Item = [Pos2; 2]>) {
    let edges: Vec<[Pos2; 2]> = edges.collect();
    let painter = ui.painter().with_clip_rect(rect);
    for stroke in [Stroke::new(4.0, Color32::WHITE), Stroke::new(2.0, Color32::from_rgb(0xc2, 0x18, 0x5b))] {
        painter.extend(edges.iter().map(|&points| egui::Shape::LineSegment { points, stroke }));
    }
}

/// The building that is picked, where it is one.
fn building<'a>(city: &'a City, picked: &Element) -> Option<&'a buildings::Building> {
    let is_building = picked.kind == ElementKind::Building;
    city.buildings.iter().find(|building| is_building && building.id == picked.id)
}

/// The edges of a building as a box on its ground.
fn box_of(building: &buildings::Building) -> Vec<[Vec3; 2]> {
    let (low, high) = (building.ground.0, building.ground.1 + building.height);
    let mut found = Vec::new();
    for ring in building.footprint.rings() {
        for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (a, b) = (a.metres(), b.metres());
            found.extend([
                [a.extend(low), b.extend(low)],
                [a.extend(high), b.extend(high)],
                [a.extend(low), a.extend(high)],
            ]);
        }
    }
    found
}

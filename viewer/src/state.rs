//! What the window shows and what people do: panels read the state and leave commands, which are carried out between frames.

mod saving;

use crate::console::Console;
use crate::evidence::Evidence;
use crate::evidence::Statistics;
use crate::gallery;
use crate::history::History;
use crate::panels::source::Place;
use crate::preferences::{Bookmark, Preferences};
use crate::recovery::Recovery;
use crate::render::Gpu;
use crate::scene::{By, ColourBy, Element, Scene};
use crate::sight::Sight;
use crate::task::Task;
use crate::timeline::Timeline;
use crate::viewport::Viewports;
use crate::worker::{Failure, News, Order, Ready, Wake, Worker, folder_of, whole};
use city::export::map::Colouring;
use city::why::Answer;
use city::{Cache, Changes, FaultReport};
use geom::Vec2;
use script::{Plan, PresetTarget};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// What people ask for.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Opens a city: a folder or a script.
    Open(PathBuf),
    /// Leaves the city that is open.
    Close,
    /// Lays a preset on something.
    Lay(PresetTarget, String),
    /// Takes a preset from it.
    Lift(PresetTarget),
    /// Sets a value as behind `--set`; a value that is being turned is one step until it is let go.
    Set {
        /// Its address.
        address: String,
        /// The value.
        value: String,
        /// Whether it goes on.
        turning: bool,
    },
    /// A value that was turned is let go.
    LetGo,
    /// Takes a value back to what it is without changes.
    Reset(String),
    /// Takes all values back; presets stay.
    ResetAll,
    /// Another seed; the script's own when none.
    Seed(Option<u64>),
    /// Takes the last step back.
    Undo,
    /// Brings it back.
    Redo,
    /// Saves the changes beside the script.
    Save,
    /// Saves the city with its changes as another one, in a folder that is not there yet, and goes on with that.
    SaveCopy(PathBuf),
    /// Copies a rule of the library into the city's folder, to be changed there.
    Adopt(String),
    /// Saves what is in force where presets are laid as a preset of a name.
    SavePreset(String),
    /// Colours the streets of the map.
    ColourBy(ColourBy),
    /// Picks something.
    Select(Option<Element>),
    /// Asks why what is picked is there.
    Ask,
    /// Measures the city.
    Measure,
    /// Runs what was typed into the console.
    Run,
    /// Shows a place in a script.
    ShowSource(Place),
    /// Shows a place of the city, in metres.
    ShowPlace([f64; 2]),
    /// Keeps where one looks from, by a name; one of that name is written over.
    KeepView(String),
    /// Looks from where that was kept.
    GoTo(usize),
    /// Forgets a view that was kept.
    ForgetView(usize),
    /// Takes changes up again that were not saved when the program ended, or forgets them.
    Recover(bool),
    /// Looks at what is picked, or at all of the city.
    Fit,
    /// Looks at all of the city.
    FitAll,
    /// Gives up the build under way.
    Cancel,
    /// Builds again.
    Build,
    /// Shows the city in spite of rules that failed for it.
    ShowAnyway,
    /// Takes back the changes that do not suit the script.
    DropUnsuited,
    /// Shows a message away.
    Dismiss,
}

/// What there is to know.
pub struct State {
    /// What people chose.
    pub preferences: Preferences,
    /// Their file.
    pub preferences_file: Option<PathBuf>,
    /// Where rules are looked up besides.
    pub rules: Option<PathBuf>,
    /// The city that is open.
    pub city: Option<PathBuf>,
    /// The last one that was finished without errors of rules, or that people wanted to see in spite of them.
    pub ready: Option<Arc<Ready>>,
    /// A newer one for which rules failed: the last good one stays until people want to see this one.
    pub held: Option<Arc<Ready>>,
    /// What is in sight of the next one, which is under way.
    pub glimpse: Option<Arc<Scene>>,
    /// How many such there were.
    pub glimpses: u64,
    /// Why there is no newer one.
    pub failure: Option<Arc<Failure>>,
    /// The stage of the build under way, with its share done.
    pub under: Option<(&'static str, Option<f32>)>,
    /// The changes.
    pub history: History,
    /// What streets are coloured by.
    pub colour_by: ColourBy,
    /// What is picked.
    pub selected: Option<Element>,
    /// Why it is there.
    pub asked: Task<Answer>,
    /// What is measured of the city.
    pub statistics: Task<Statistics>,
    /// The streets by when they grew, where people want to see that.
    pub growth: Task<crate::scene::MapScene>,
    /// Whether they do.
    pub by_growth: bool,
    /// Scripts typed by people.
    pub console: Console,
    /// The place in a script that is shown.
    pub source: Option<Place>,
    /// Changes that were not saved when the program ended.
    pub recovery: Recovery,
    /// How the city grew.
    pub timeline: Timeline,
    /// Pictures of presets.
    pub gallery: gallery::Gallery,
    /// What presets are laid on.
    pub target: PresetTarget,
    /// Where parameters are set: everywhere, `district:NAME` or `quarter:ID`.
    pub scope: Option<PresetTarget>,
    /// The map laid over the views, by name, with its opacity.
    pub overlay: (Option<String>, f32),
    /// The views.
    pub views: Viewports,
    /// What people are told.
    pub message: Option<String>,
    /// What they asked for in this frame.
    pub commands: Vec<Command>,
    /// What is looked for.
    pub filters: Filters,
    /// Whether changes are still to be kept against a crash.
    is_unguarded: bool,
    /// What somebody else saved beside the script, once people were told that saving writes over it.
    warned: Option<String>,
    /// The script of the open city.
    script: PathBuf,
    /// What is wrong with the file of changes, where it cannot be read.
    pub misread: Option<Arc<[FaultReport]>>,
    /// What people were told last of saving.
    told_of_saving: Option<String>,
    /// What somebody else saved while there were changes that were not, once people were told.
    told_of_other: Option<Changes>,
    /// The plan that is asked for while it is not built yet, by its changes and the round of the city it is laid over.
    asked_for: Option<(Changes, u64, Arc<Plan>)>,
    /// Whether the views stay where they are when the first city comes.
    keeps_views: bool,
    /// What questions about the city are answered from.
    evidence: Arc<Evidence>,
    worker: Result<Worker, String>,
    wake: Wake,
    gpu: Option<Gpu>,
}

/// What people look for in lists.
#[derive(Clone, Debug, Default)]
pub struct Filters {
    /// Among presets.
    pub presets: String,
    /// Among parameters.
    pub parameters: String,
    /// Among all that can be done.
    pub palette: String,
    /// What a preset is to be called.
    pub preset_name: String,
    /// What a view is to be called.
    pub view_name: String,
    /// Which rules presets must have: of streets, parcels or buildings.
    pub kind: Option<&'static str>,
}

/// Where the texts of rules lie that come with the program.
pub const LIBRARY: &str = "rules/";

/// Room for caches on disk, in bytes.
const CACHE_BYTES: u64 = 2_000_000_000;

impl State {
    /// Nothing is open yet.
    pub fn new(gpu: Option<Gpu>, preferences_file: Option<PathBuf>, rules: Option<PathBuf>, wake: Wake) -> Self {
        let preferences = preferences_file.as_deref().map(Preferences::read).unwrap_or_default();
        // Whoever keeps preferences elsewhere is none of the user's.
        let is_users = preferences_file.is_some() && preferences_file == Preferences::file();
        let folder = is_users.then(dirs::cache_dir).flatten();
        let pictures = folder.as_ref().map(|folder| folder.join("plat-view").join("presets"));
        let cache = move || {
            let on_disk = folder.and_then(|folder| Cache::on_disk(&folder.join("plat"), CACHE_BYTES).ok());
            on_disk.unwrap_or_else(Cache::in_memory)
        };
        let recovery = Recovery::beside(preferences_file.as_deref());
        Self {
            preferences,
            preferences_file,
            rules,
            city: None,
            ready: None,
            held: None,
            glimpse: None,
            glimpses: 0,
            failure: None,
            under: None,
            history: History::of(Changes::default()),
            colour_by: None,
            selected: None,
            asked: Task::default(),
            statistics: Task::default(),
            growth: Task::default(),
            by_growth: false,
            console: Console::default(),
            source: None,
            recovery,
            timeline: Timeline::default(),
            is_unguarded: false,
            warned: None,
            script: PathBuf::new(),
            misread: None,
            told_of_saving: None,
            told_of_other: None,
            asked_for: None,
            keeps_views: false,
            evidence: Arc::default(),
            gallery: gallery::Gallery::new(pictures),
            target: PresetTarget::City,
            scope: None,
            overlay: (None, 0.6),
            views: Viewports::new(gpu.clone()),
            message: None,
            commands: Vec::new(),
            filters: Filters::default(),
            worker: Worker::start(gpu.clone(), cache, wake.clone()),
            wake,
            gpu,
        }
    }

    /// The device that draws.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_ref()
    }

    /// The plan that is asked for, where the city shown is not built from it yet.
    pub fn asked_for(&mut self) -> Option<Arc<Plan>> {
        let ready = self.ready.clone()?;
        let changes = self.history.now();
        if changes == ready.order.changes {
            return None;
        }
        let known = self.asked_for.as_ref().filter(|(of, round, _)| *of == changes && *round == ready.round);
        if known.is_none() {
            let mut laid = ready.as_written.clone();
            // As the worker does: what does not suit is left out.
            let _ = changes.lay_what_suits(&mut laid);
            self.asked_for = Some((changes, ready.round, laid.plan.into()));
        }
        self.asked_for.as_ref().map(|(.., plan)| plan.clone())
    }

    /// Whether nothing is being built.
    pub fn is_idle(&self) -> bool {
        let is_asking = self.asked.is_busy()
            || self.statistics.is_busy()
            || self.growth.is_busy()
            || self.console.is_busy()
            || self.timeline.is_busy()
            || self.timeline.plays();
        self.worker.as_ref().is_ok_and(Worker::is_idle) && !is_asking
    }

    /// Takes in what the worker told, and carries out what people asked for. Returns how soon there is more to do, where
    /// nothing else wakes the window until then.
    pub fn catch_up(&mut self) -> Option<Duration> {
        // Asked first: whoever is idle now has told all.
        let is_idle = self.worker.as_ref().is_ok_and(Worker::is_idle);
        let news: Vec<News> = self.worker.as_ref().map_or_else(|_| Vec::new(), |worker| worker.news().collect());
        for one in news {
            match one {
                News::Under(stage, share) => self.under = Some((stage, share)),
                // Another city may have been opened meanwhile.
                News::Ready(ready) if Some(&ready.order.city) != self.city.as_ref() => {}
                News::Ready(ready) => {
                    if self.is_worse(&ready) {
                        self.hold(ready);
                    } else {
                        self.show(ready);
                    }
                    self.look_at_saved();
                }
                News::Glimpse(scene) => {
                    self.glimpses += 1;
                    self.glimpse = Some(scene);
                }
                // It is there to be painted.
                News::Model => {}
                News::Presets(presets) => self.gallery.follow(&presets),
                News::Failed(failure) => {
                    (self.under, self.glimpse, self.held) = (None, None, None);
                    self.failure = Some(failure);
                    self.look_at_saved();
                }
                News::Unwatched(what) => self.message = Some(what),
            }
        }
        if is_idle {
            // What was given up is not to stay half.
            (self.under, self.glimpse) = (None, None);
            if std::mem::take(&mut self.is_unguarded) {
                self.guard();
            }
        }
        self.asked.catch_up();
        self.statistics.catch_up();
        self.growth.catch_up();
        self.console.catch_up();
        for command in std::mem::take(&mut self.commands) {
            self.carry_out(command);
        }
        let ready = self.ready.clone()?;
        if self.by_growth && self.growth.done.is_none() && !self.growth.is_busy() {
            self.see_growth(&ready);
        }
        self.timeline.catch_up(&ready, &self.evidence, self.gpu.as_ref(), &self.wake)
    }

    /// Whether rules failed more often for a city than for the one that is shown.
    fn is_worse(&self, ready: &Ready) -> bool {
        let failures = |ready: &Ready| -> usize {
            let faults = ready.built.report.faults.iter().filter(|fault| fault.is_error());
            faults.map(|fault| fault.count as usize).sum()
        };
        let is_better = |shown: &Arc<Ready>| shown.order.city == ready.order.city && failures(shown) < failures(ready);
        self.ready.as_ref().is_some_and(is_better)
    }

    /// Tells what is wrong with a city; the last good one stays.
    fn hold(&mut self, ready: Arc<Ready>) {
        (self.under, self.glimpse) = (None, None);
        self.failure = Some(Failure::of_rules(&ready).into());
        self.held = Some(ready);
    }

    fn show(&mut self, ready: Arc<Ready>) {
        let is_first = self.ready.is_none();
        (self.under, self.failure, self.glimpse, self.held) = (None, None, None, None);
        let keeps_views = std::mem::take(&mut self.keeps_views);
        if let Some(scene) = &ready.scene
            && is_first
            && !keeps_views
        {
            self.views.fit(scene.extent, 0.0, &ready.built.city);
        }
        let is_there = |element: &Element| crate::inspect::polygon_of(&ready.built.city, element).is_some();
        self.selected = self.selected.take().filter(is_there);
        self.asked.forget();
        self.statistics.forget();
        self.growth.forget();
        self.timeline.leave();
        self.evidence = Arc::default();
        self.ready = Some(ready);
    }

    /// Carries out what was asked for.
    pub fn carry_out(&mut self, command: Command) {
        match command {
            Command::Open(path) => self.open(&path),
            Command::Close => self.close(),
            Command::Lay(target, name) => {
                self.change_rules(&format!("preset {name}"), |changes| changes.lay(target, &name));
            }
            Command::Lift(target) => self.change_rules("no preset", |changes| changes.lift(&target)),
            Command::Set { address, value, turning } => {
                let turns = turning.then_some(address.as_str());
                self.change(&format!("{address} {value}"), turns, |changes| changes.set(&address, &value));
            }
            Command::LetGo => self.history.close(),
            Command::Reset(address) => {
                self.change(&format!("reset {address}"), None, |changes| changes.reset(&address))
            }
            Command::ResetAll => self.change("reset all", None, |changes| {
                let all: Vec<String> = changes.values().map(|(address, _)| address.to_owned()).collect();
                all.iter().for_each(|address| changes.reset(address));
                changes.seed = None;
            }),
            Command::Seed(seed) => self.change("seed", Some("seed"), |changes| changes.seed = seed),
            Command::Undo => {
                if self.history.undo() {
                    self.changed();
                }
            }
            Command::Redo => {
                if self.history.redo() {
                    self.changed();
                }
            }
            Command::Save => self.save(),
            Command::SaveCopy(folder) => self.save_copy(&folder),
            Command::Adopt(file) => self.adopt(&file),
            Command::SavePreset(name) => self.save_preset(&name),
            Command::ColourBy(by) => {
                self.colour_by = by;
                self.build();
            }
            Command::Select(element) => {
                self.asked.forget();
                if let Some(Element { kind: crate::scene::ElementKind::Quarter, id }) = element {
                    self.target = PresetTarget::Quarter(id);
                }
                self.selected = element;
            }
            Command::Ask => {
                if let (Some(ready), Some(element)) = (self.ready.clone(), self.selected.clone()) {
                    let evidence = self.evidence.clone();
                    self.asked.begin("why", self.wake.clone(), move || evidence.why(&ready, &element));
                }
            }
            Command::Measure => {
                if let Some(ready) = self.ready.clone() {
                    let evidence = self.evidence.clone();
                    self.statistics.begin("measures", self.wake.clone(), move || evidence.statistics(&ready));
                }
            }
            Command::Run => {
                if let Some(ready) = &self.ready {
                    self.console.run(ready, &self.evidence, self.selected.as_ref(), &self.wake);
                }
            }
            Command::ShowSource(place) => self.source = Some(place),
            Command::ShowPlace(place) => self.views.look_at(Vec2::from_array(place)),
            Command::KeepView(name) => {
                let view = self.views.bookmark(&name);
                self.with_bookmarks(|views| {
                    views.retain(|other| other.name != name);
                    views.push(view);
                });
            }
            Command::GoTo(index) => {
                let kept = self.bookmarks().get(index).cloned();
                if let Some(kept) = kept {
                    self.views.go_to(&kept);
                }
            }
            Command::ForgetView(index) => self.with_bookmarks(|views| {
                if index < views.len() {
                    views.remove(index);
                }
            }),
            Command::Recover(wanted) => self.recover(wanted),
            Command::Fit => self.fit(self.selected.clone().as_ref()),
            Command::FitAll => self.fit(None),
            Command::Cancel => {
                if let Ok(worker) = &self.worker {
                    worker.cancel();
                }
            }
            Command::Build => self.build(),
            Command::ShowAnyway => {
                if let Some(held) = self.held.take() {
                    self.show(held);
                }
            }
            Command::DropUnsuited => {
                if let Some(ready) = self.ready.clone() {
                    self.change("changes that do not suit taken back", None, |changes| {
                        (_, *changes) = changes.lay_what_suits(&mut ready.as_written.clone());
                    });
                }
            }
            Command::Dismiss => self.message = None,
        }
    }

    fn change(&mut self, name: &str, turns: Option<&str>, change: impl FnOnce(&mut Changes)) {
        if self.city.is_some() && self.history.step(name, turns, change) {
            if turns.is_some() {
                // A file for each value on the way would hold up the hand that turns it.
                self.is_unguarded = true;
                self.build();
            } else {
                self.changed();
            }
        }
    }

    /// A change that puts other rules in place: values that were set of those that go are taken back with them.
    fn change_rules(&mut self, name: &str, change: impl FnOnce(&mut Changes)) {
        let as_written = self.ready.as_ref().map(|ready| ready.as_written.clone());
        let suiting = |changes: &Changes| as_written.clone().map(|mut city| changes.lay_what_suits(&mut city).1);
        let mut gone = Vec::new();
        self.change(name, None, |changes| {
            let before = suiting(changes);
            change(changes);
            if let (Some(before), Some(after)) = (before, suiting(changes)) {
                let values = before.values().map(|(address, _)| address.to_owned());
                gone.extend(values.filter(|address| after.value(address).is_none()));
            }
            gone.iter().for_each(|address| changes.reset(address));
        });
        if !gone.is_empty() {
            let words = format!("Taken back with the rules they were of: {}. Undo brings all back.", gone.join(", "));
            self.message = Some(words);
        }
    }

    /// The changes are others than before.
    fn changed(&mut self) {
        self.guard();
        self.build();
    }

    /// The views that were kept of the open city.
    pub fn bookmarks(&self) -> &[Bookmark] {
        let known = self.city.as_ref().and_then(|city| self.preferences.bookmarks.get(&whole(city)));
        known.map_or(&[], Vec::as_slice)
    }

    fn with_bookmarks(&mut self, change: impl FnOnce(&mut Vec<Bookmark>)) {
        let Some(city) = &self.city else { return };
        change(self.preferences.bookmarks.entry(whole(city)).or_default());
        self.preferences.bookmarks.retain(|_, views| !views.is_empty());
        self.remember();
    }

    /// Tells the worker what was in sight of the last frame.
    pub fn tell_sight(&mut self) {
        let city = self.ready.as_ref().and_then(|ready| ready.scene.as_ref()).map(|scene| scene.extent);
        let sight = city.zip(self.views.take_sight()).and_then(|(city, (low, high))| Sight::of(low, high, city));
        if let Ok(worker) = &self.worker {
            worker.look(sight);
        }
    }

    /// Wakes the window.
    pub fn wake(&self) -> Wake {
        self.wake.clone()
    }

    /// The text of a script, as it was read last.
    pub fn text_of(&self, file: &str) -> Option<Arc<str>> {
        let failed = self.failure.as_ref().and_then(|failure| failure.texts.as_ref());
        let ready = self.ready.as_ref().map(|ready| &ready.as_written.texts);
        let known = failed.and_then(|texts| texts.get(file)).or_else(|| ready.and_then(|texts| texts.get(file)));
        let changes = Changes::file_of(&self.script);
        // It is no script; what is wrong with it is shown in it even so.
        known.or_else(|| std::fs::read_to_string(&changes).ok().filter(|_| Path::new(file) == changes).map(Arc::from))
    }

    /// Colours the streets by when they grew.
    fn see_growth(&mut self, ready: &Arc<Ready>) {
        let (ready, evidence, gpu) = (ready.clone(), self.evidence.clone(), self.gpu.clone());
        self.growth.begin("growth", self.wake.clone(), move || {
            let colouring = Colouring::of_growth(&ready.built.city, evidence.trace(&ready)?);
            let gpu = gpu.ok_or("there is no graphics adapter")?;
            Ok(crate::scene::MapScene::coloured(&gpu, &ready.built.city, Some(&colouring)))
        });
    }

    fn open(&mut self, path: &Path) {
        if !self.history.is_saved() {
            self.message = Some("The changes of the open city are not saved: save them, or undo them, first.".into());
            return;
        }
        let script = if path.is_dir() { path.join("city.rhai") } else { path.to_path_buf() };
        if !script.is_file() {
            self.message = Some(format!("{}: there is no city.rhai here", path.display()));
            return;
        }
        // A file that cannot be read is told of as soon as there is something to show; saving asks before it writes over it.
        let saved = Changes::saved(&script).unwrap_or_default();
        self.recovery.find(path, &saved);
        self.history = History::of(saved);
        self.script = script;
        self.leave_city();
        self.preferences.opened(path);
        self.remember();
        self.city = Some(path.to_path_buf());
        self.build();
    }

    fn close(&mut self) {
        self.leave_city();
        self.city = None;
        self.timeline.leave();
        if let Ok(worker) = &self.worker {
            worker.rest();
        }
    }

    /// Nothing of what was shown stays.
    fn leave_city(&mut self) {
        (self.ready, self.failure, self.selected, self.message) = (None, None, None, None);
        (self.glimpse, self.held, self.warned, self.misread) = (None, None, None, None);
        (self.told_of_saving, self.told_of_other, self.source) = (None, None, None);
        (self.target, self.scope, self.overlay.0) = (PresetTarget::City, None, None);
    }

    /// Goes back to the changes that are saved.
    pub fn forget_changes(&mut self) {
        self.history = History::of(self.history.saved().clone());
    }

    /// What ends the worker from outside, where the window cannot.
    pub fn ender(&self) -> Box<dyn Fn() + Send> {
        self.worker.as_ref().map_or_else(|_| Box::new(|| {}) as Box<dyn Fn() + Send>, Worker::ender)
    }

    /// Goes on with a city where another window ended.
    pub fn take_over(&mut self, city: &Path, history: History, views: Bookmark) {
        self.open(city);
        if self.city.is_some() {
            self.recovery.found.clear();
            self.history = history;
            self.views.go_to(&views);
            self.keeps_views = true;
            self.changed();
        }
    }

    /// Asks for the city as it now is to be.
    fn build(&mut self) {
        let Some(city) = &self.city else { return };
        let (changes, rules) = (self.history.now(), self.rules.clone());
        let order = Order { city: city.clone(), rules, changes, colour_by: self.colour_by };
        match &self.worker {
            Ok(worker) => worker.order(order),
            Err(error) => self.message = Some(format!("nothing can be built: {error}")),
        }
    }

    /// Writes the preferences; where that fails they only hold until the end.
    pub fn remember(&mut self) {
        if let Some(file) = &self.preferences_file
            && let Err(error) = self.preferences.write(file)
        {
            self.message = Some(format!("What you chose could not be remembered: {error}"));
            self.preferences_file = None;
        }
    }

    fn fit(&mut self, element: Option<&Element>) {
        let Some(ready) = &self.ready else { return };
        let city = &ready.built.city;
        let polygon = element.and_then(|element| crate::inspect::polygon_of(city, element));
        let extent = polygon.and_then(|polygon| polygon.bounds());
        let all = ready.scene.as_ref().map_or(city.site.bounds, |scene| scene.extent);
        let high = element.and_then(|element| crate::inspect::height_of(city, element)).unwrap_or(0.0);
        self.views.fit(extent.unwrap_or(all), high, city);
    }

    /// The name of the city that is open.
    pub fn title(&self) -> String {
        let name = self.city.as_ref().map(|city| {
            let folder = whole(&folder_of(city));
            folder.file_name().map_or_else(|| "city".into(), |name| name.to_string_lossy().into_owned())
        });
        let mark = if self.history.is_saved() { "" } else { " (changed)" };
        name.map_or_else(|| "Plat".into(), |name| format!("{name}{mark} — Plat"))
    }

    /// What streets can be coloured by.
    pub fn colourings(&self) -> Vec<(ColourBy, &'static str)> {
        let all = [
            (None, "as on a street map"),
            (Some(By::Class), "by class"),
            (Some(By::Rule), "by rule"),
            (Some(By::District), "by district"),
            (Some(By::Density), "by density"),
            (Some(By::Grade), "by grade"),
        ];
        let site = self.ready.as_ref().map(|ready| ready.built.city.site.clone());
        let has = |by: &ColourBy| {
            let map = by.and_then(By::map);
            map.is_none_or(|map| site.as_ref().is_some_and(|site| site.map(map).is_some()))
        };
        all.into_iter().filter(|(by, _)| has(by)).collect()
    }
}

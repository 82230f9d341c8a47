//! The thread that reads and builds, so that the window never waits: the newest order and the newest files win.

use crate::render::Gpu;
use crate::scene::{ColourBy, Scene};
use crate::sight::Sight;
use city::{
    BuildError, Built, Cache, Cancel, Changes, FaultReport, LoadError, Loaded, Progress, Settings, Silent, Sources,
    Stage, Watch, build_with, load_as_written,
};
use geom::{Digest, Id};
use script::{Preset, Texts};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What is to be shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// A folder with a `city.rhai`, or the script.
    pub city: PathBuf,
    /// A folder of further rules.
    pub rules: Option<PathBuf>,
    /// What is laid over the script.
    pub changes: Changes,
    /// What streets are coloured by on the map.
    pub colour_by: ColourBy,
}

/// What the worker tells.
#[derive(Debug)]
pub enum News {
    /// A build is under way: a stage, with the share of it that is done where that is known.
    Under(&'static str, Option<f32>),
    /// A city is ready; of the first of its folder the model may come later.
    Ready(Arc<Ready>),
    /// The model of the city that was told last is there, too.
    Model,
    /// What is in sight of the next city, which is still under way; elsewhere the last one stays.
    Glimpse(Arc<Scene>),
    /// The presets that can be laid on it, each with the digest of all that it says.
    Presets(Vec<(Preset, Id)>),
    /// There is none: the last one stays.
    Failed(Arc<Failure>),
    /// Files cannot be watched.
    Unwatched(String),
}

/// A city with all that is shown of it.
#[derive(Debug)]
pub struct Ready {
    /// The round of the worker that made it: no two have the same.
    pub round: u64,
    /// What it was made for.
    pub order: Order,
    /// The script without changes.
    pub as_written: Loaded,
    /// What it was built from.
    pub sources: Sources,
    /// What is wrong with changes that do not suit the script: it was built without them.
    pub unsuited: Vec<FaultReport>,
    /// The city, with its report.
    pub built: Built,
    /// What is drawn; none without a device.
    pub scene: Option<Scene>,
    /// From the first reading to here.
    pub took: Duration,
}

/// Why there is no city.
#[derive(Debug, Default)]
pub struct Failure {
    /// What it was to be made for.
    pub order: Option<Order>,
    /// What went wrong, where it was not in scripts.
    pub message: Option<String>,
    /// What is wrong in scripts.
    pub faults: Vec<FaultReport>,
    /// The texts of scripts.
    pub texts: Option<Texts>,
}

impl Failure {
    fn of(order: &Order, error: LoadError) -> Self {
        let order = Some(order.clone());
        match error {
            LoadError::Scripts { faults, texts } => {
                Self { order, message: None, faults: faults.iter().map(Into::into).collect(), texts: Some(texts) }
            }
            other => Self { order, message: Some(other.to_string()), ..Self::default() },
        }
    }

    /// Why a city is not shown although it was built.
    pub fn of_rules(ready: &Ready) -> Self {
        let faults = ready.built.report.faults.clone();
        Self { order: Some(ready.order.clone()), message: None, faults, texts: Some(ready.as_written.texts.clone()) }
    }

    fn of_build(order: &Order, error: &BuildError, texts: &Texts) -> Self {
        let faults = match error {
            BuildError::Fault(fault) => vec![FaultReport::from(&**fault)],
            BuildError::Nothing { faults, .. } => faults.iter().map(FaultReport::from).collect(),
            BuildError::Cancelled | BuildError::Threads(_) => Vec::new(),
        };
        Self { order: Some(order.clone()), message: Some(error.to_string()), faults, texts: Some(texts.clone()) }
    }
}

/// Wakes whoever shows the news.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// The thread, as the window sees it. Ends with it.
pub struct Worker {
    news: Receiver<News>,
    shared: Arc<Shared>,
    stop: Arc<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct Shared {
    orders: Mutex<Orders>,
    building: Mutex<Option<Cancel>>,
    is_over: AtomicBool,
    /// What is in sight, where that is a small part.
    sight: Mutex<Option<Sight>>,
    /// Orders whose city was told of.
    done: AtomicU64,
    /// Whether a city is being made, for an order or for saved files.
    is_at_work: AtomicBool,
}

#[derive(Default)]
struct Orders {
    /// The newest, until it is taken; inside nothing where no city is wanted any more.
    newest: Option<Option<Order>>,
    /// How many were given.
    given: u64,
}

impl Worker {
    /// Starts it. The cache is opened on its thread, since that takes a while.
    ///
    /// # Errors
    /// When files cannot be watched at all, or there is no thread.
    pub fn start(gpu: Option<Gpu>, cache: impl FnOnce() -> Cache + Send + 'static, wake: Wake) -> Result<Self, String> {
        let (sender, news) = channel();
        let shared = Arc::<Shared>::default();
        let watch = Watch::new(&[]).map_err(|error| error.to_string())?;
        let stop = Arc::new(watch.stopper());
        let teller = Teller { sender, wake };
        let own = shared.clone();
        let work = move || {
            Bench { watch, gpu, cache: cache(), teller, shared: own, rounds: 0, last_told: Arc::default() }.run();
        };
        std::thread::Builder::new().name("worker".into()).spawn(work).map_err(|error| error.to_string())?;
        Ok(Self { news, shared, stop })
    }

    /// Asks for a city; what was asked for before is given up.
    pub fn order(&self, order: Order) {
        self.want(Some(order));
    }

    /// No city is wanted any more: none is watched or built.
    pub fn rest(&self) {
        self.want(None);
    }

    fn want(&self, order: Option<Order>) {
        {
            let mut orders = lock(&self.shared.orders);
            orders.newest = Some(order);
            orders.given += 1;
        }
        self.cancel();
        (self.stop)();
    }

    /// Gives up what is being built; the last city stays.
    pub fn cancel(&self) {
        if let Some(building) = &*lock(&self.shared.building) {
            building.cancel();
        }
    }

    /// Tells what is in sight, where that is a small part: it is made first.
    pub fn look(&self, sight: Option<Sight>) {
        *lock(&self.shared.sight) = sight;
    }

    /// What was told since.
    pub fn news(&self) -> impl Iterator<Item = News> {
        self.news.try_iter()
    }

    /// What ends it.
    pub fn ender(&self) -> Box<dyn Fn() + Send> {
        let (shared, stop) = (self.shared.clone(), self.stop.clone());
        Box::new(move || {
            shared.is_over.store(true, Ordering::SeqCst);
            if let Some(building) = &*lock(&shared.building) {
                building.cancel();
            }
            stop();
        })
    }

    /// Whether all that was ordered is done.
    pub fn is_idle(&self) -> bool {
        let is_at_work = self.shared.is_at_work.load(Ordering::SeqCst);
        !is_at_work && self.shared.done.load(Ordering::SeqCst) == lock(&self.shared.orders).given
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        (self.ender())();
    }
}

/// Tells news, and wakes whoever shows them.
#[derive(Clone)]
struct Teller {
    sender: Sender<News>,
    wake: Wake,
}

impl Teller {
    fn tell(&self, news: News) {
        // Nobody listens once the window is closed.
        let _ = self.sender.send(news);
        (self.wake)();
    }
}

/// Where the worker works.
struct Bench {
    watch: Watch,
    gpu: Option<Gpu>,
    cache: Cache,
    teller: Teller,
    shared: Arc<Shared>,
    /// Rounds begun.
    rounds: u64,
    /// The round whose presets are told.
    last_told: Arc<AtomicU64>,
}

impl Bench {
    fn run(mut self) {
        let mut order: Option<Order> = None;
        let mut before: Option<Arc<Ready>> = None;
        while !self.shared.is_over.load(Ordering::SeqCst) {
            let given = {
                let mut orders = lock(&self.shared.orders);
                order = orders.newest.take().unwrap_or(order);
                orders.given
            };
            self.shared.is_at_work.store(true, Ordering::SeqCst);
            match &order {
                Some(order) => {
                    self.rounds += 1;
                    before = self.round(order, before);
                }
                None => {
                    before = None;
                    // There is nothing that could fail to be heard of.
                    let _ = self.watch.follow(&[]);
                }
            }
            if self.has_order() {
                continue;
            }
            self.shared.done.store(given, Ordering::SeqCst);
            self.shared.is_at_work.store(false, Ordering::SeqCst);
            (self.teller.wake)();
            // What stopped the waiting may have been an order that was taken meanwhile: that is no reason to build again.
            while self.watch.wait().is_none() && !self.has_order() && !self.shared.is_over.load(Ordering::SeqCst) {}
        }
        self.cache.flush();
    }

    fn has_order(&self) -> bool {
        lock(&self.shared.orders).newest.is_some()
    }

    /// Builds once; tells what came of it, unless it was given up.
    fn round(&mut self, order: &Order, before: Option<Arc<Ready>>) -> Option<Arc<Ready>> {
        let begin = Instant::now();
        let cancel = Cancel::default();
        *lock(&self.shared.building) = Some(cancel.clone());
        // An order that came meanwhile has nothing to give up yet.
        if self.has_order() {
            return before;
        }
        self.teller.tell(News::Under("reading", None));
        let folders = [folder_of(&order.city)].into_iter().chain(order.rules.clone()).collect::<Vec<_>>();
        if let Err(error) = self.watch.follow(&folders) {
            self.teller.tell(News::Unwatched(error.to_string()));
        }
        let of_same = before.as_deref().filter(|ready| ready.order.city == order.city);
        let result = self.made(order, &cancel, &folders, of_same, begin);
        *lock(&self.shared.building) = None;
        match result {
            Ok(Some(ready)) => {
                let ready = Arc::new(ready);
                self.teller.tell(News::Ready(ready.clone()));
                if let (Some(gpu), Some(scene)) = (&self.gpu, &ready.scene)
                    && scene.model().is_none()
                {
                    scene.add_model(gpu, &ready.built.city, &self.cache);
                    self.teller.tell(News::Model);
                }
                self.tell_presets(&ready);
                Some(ready)
            }
            Ok(None) => before,
            Err(failure) => {
                self.teller.tell(News::Failed(failure.into()));
                before
            }
        }
    }

    /// Makes what is in sight, and tells it.
    fn glimpse(
        &self,
        gpu: &Gpu,
        sources: &Sources,
        order: &Order,
        (before, sight): (&Scene, Sight),
        cancel: &Cancel,
    ) -> Result<(), BuildError> {
        let settings = Settings { within: Some(sight.bounds()), ..Settings::default() };
        let built = build_with(sources, settings, &self.cache, &Silent, cancel)?;
        if built.report.has_faults() {
            // Whether it is to be shown is told with the whole.
            return Ok(());
        }
        let scene = Scene::of_part(gpu, &built.city, &self.cache, order.colour_by, Some(before), Some(sight));
        self.teller.tell(News::Glimpse(scene.into()));
        Ok(())
    }

    /// Tells the presets on a thread of its own: all their rules are read for them, and the next save must not wait for that.
    fn tell_presets(&self, ready: &Arc<Ready>) {
        let (host, teller) = (ready.as_written.host.clone(), self.teller.clone());
        let (round, last) = (ready.round, self.last_told.clone());
        last.store(round, Ordering::SeqCst);
        let is_over = self.shared.clone();
        let is_first = round == 1;
        let tell = move || {
            // Who saves a rule will save again soon: the gallery can wait until nothing has come for a while.
            for _ in 0..if is_first { 0 } else { 20 } {
                if last.load(Ordering::SeqCst) != round {
                    return;
                }
                std::thread::sleep(Duration::from_millis(50));
            }
            let mut presets = Vec::new();
            for name in host.preset_names() {
                // Where there is a newer city, its presets are told.
                if last.load(Ordering::SeqCst) != round || is_over.is_over.load(Ordering::SeqCst) {
                    return;
                }
                let with_digest = |preset: Preset| (preset.clone(), Digest::new("card").value(&preset).finish());
                presets.extend(host.preset(&name).ok().map(with_digest));
            }
            teller.tell(News::Presets(presets));
        };
        // Without the thread the gallery stays as it is.
        let _ = std::thread::Builder::new().name("presets".into()).spawn(tell);
    }

    /// `None` where it was given up.
    fn made(
        &mut self,
        order: &Order,
        cancel: &Cancel,
        always: &[PathBuf],
        before: Option<&Ready>,
        begin: Instant,
    ) -> Result<Option<Ready>, Box<Failure>> {
        let failed = |error| Box::new(Failure::of(order, error));
        let as_written = load_as_written(&order.city, order.rules.as_deref()).map_err(failed)?;
        let folders: Vec<PathBuf> = always.iter().cloned().chain(as_written.folders()).collect();
        if let Err(error) = self.watch.follow(&folders) {
            self.teller.tell(News::Unwatched(error.to_string()));
        }
        let mut changed = as_written.clone();
        // A renamed parameter must not keep people from a city that they changed.
        let (wrong, _) = order.changes.lay_what_suits(&mut changed);
        let unsuited: Vec<FaultReport> = wrong.iter().map(FaultReport::from).collect();
        let saved = Changes::file_of(&as_written.script).display().to_string();
        if let (false, Ok(text)) = (wrong.is_empty(), std::fs::read_to_string(&saved)) {
            as_written.texts.keep_text(&saved, &text);
        }
        let is_behind = |file: &str| file != saved;
        let was_well = |ready: &Ready| !ready.unsuited.iter().any(|fault| is_behind(&fault.file));
        if before.is_some_and(was_well) && wrong.iter().any(|fault| is_behind(&fault.file)) {
            // A preset or rule that changes name broke, as one may that the script names.
            let error = LoadError::Scripts { faults: wrong, texts: changed.texts };
            return Err(failed(error));
        }
        let sources = changed.read_with(&self.cache).map_err(failed)?;
        let settings = Settings::default();
        let progress = Told { teller: self.teller.clone(), parts: Mutex::default() };
        let sight = *lock(&self.shared.sight);
        let built = self.watch.during(cancel, || {
            if let (Some(sight), Some(gpu), Some(before)) =
                (sight, &self.gpu, before.and_then(|ready| ready.scene.as_ref()))
            {
                self.glimpse(gpu, &sources, order, (before, sight), cancel)?;
            }
            build_with(&sources, settings, &self.cache, &progress, cancel)
        });
        let built = match built {
            Ok(built) => built,
            Err(BuildError::Cancelled) => return Ok(None),
            Err(error) => return Err(Box::new(Failure::of_build(order, &error, &changed.texts))),
        };
        self.teller.tell(News::Under("drawing", None));
        let scene = self.gpu.as_ref().map(|gpu| match before.and_then(|ready| ready.scene.as_ref()) {
            Some(before) => Scene::of(gpu, &built.city, &self.cache, order.colour_by, Some(before)),
            None => Scene::of_map(gpu, &built.city, order.colour_by),
        });
        if cancel.is_cancelled() {
            return Ok(None);
        }
        Ok(Some(Ready {
            round: self.rounds,
            order: order.clone(),
            as_written,
            sources,
            unsuited,
            built,
            scene,
            took: begin.elapsed(),
        }))
    }
}

/// A path as it is known whatever folder one stands in.
pub fn whole(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The folder of a city.
pub fn folder_of(city: &Path) -> PathBuf {
    let is_script = city.is_file() || city.extension().is_some_and(|ending| ending == "rhai");
    let folder = if is_script { city.parent().unwrap_or(Path::new(".")) } else { city };
    if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_path_buf() }
}

/// Tells how far a build is, not too often.
struct Told {
    teller: Teller,
    parts: Mutex<Parts>,
}

#[derive(Default)]
struct Parts {
    stage: &'static str,
    done: u64,
    all: u64,
    told: u64,
}

impl Progress for Told {
    fn begin(&self, stage: Stage, all: u64) {
        *lock(&self.parts) = Parts { stage: stage.name(), done: 0, all, told: 0 };
        self.teller.tell(News::Under(stage.name(), (all > 0).then_some(0.0)));
    }

    fn advance(&self, parts: u64) {
        let mut known = lock(&self.parts);
        known.done += parts;
        let percent = (known.done * 100).checked_div(known.all).unwrap_or(0);
        if percent >= known.told + 5 {
            known.told = percent;
            self.teller.tell(News::Under(known.stage, Some(percent as f32 / 100.0)));
        }
    }

    fn end(&self, _: Stage, _: &str) {}
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

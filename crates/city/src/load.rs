//! From a folder on disk to a plan and its sources.

use crate::check::rule_folder;
use crate::sources::{
    self, DistrictMap, Frame, GeoJsonFrame, ImportedStreet, KNOWN_MAPS, MapOptions, SourceError, class_width, file_key,
    flat_site, load_site_with, map_names, read_districts, read_geojson_streets, read_osm,
};
use crate::stages::keep::Keys;
use crate::testing::is_tests;
use crate::{Cache, Changes, Site};
use geom::{Bounds, Digest, Id, Point, Raster, Vec2};
use script::{
    DistrictPlan, Evaluated, Fault, Host, Library, ParamError, Plan, PresetTarget, RuleKind, SiteInfo, SiteRequest,
    Sites, Source, StreetImport, StreetUnits, Texts, place_in_script,
};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use streets::{Classes, Districts};

/// Most land in km² on which the streets of one city may grow: ten times the largest cities, and more than memory holds.
const MOST_KM2: f64 = 10_000.0;

/// Why a city could not be read.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// There is no city script there.
    #[error("{}: {message}\n  hint: {hint}", path.display())]
    Missing {
        /// What was asked for.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
        /// What to do.
        hint: String,
    },
    /// The script is there, but is no text or cannot be read.
    #[error("{}: {cause}\n  hint: {}", path.display(), script_hint(cause))]
    Unreadable {
        /// The script.
        path: PathBuf,
        /// What is wrong with it.
        cause: std::io::Error,
    },
    /// The script failed, a rule that it names, or what people changed of it; what stopped it comes first.
    #[error("{}", faults.first().map(ToString::to_string).unwrap_or_default())]
    Scripts {
        /// All that is wrong, never empty.
        faults: Vec<Fault>,
        /// The texts in which it is.
        texts: Texts,
    },
    /// A parameter's value does not suit the site: its map or district is not there, or leads out of its range.
    #[error("{}: {}{}", path.display(), error.message, error.hint.as_ref().map_or(String::new(), |hint| format!("\n  hint: {hint}")))]
    Value {
        /// The script.
        path: PathBuf,
        /// What is wrong.
        error: ParamError,
    },
    /// A map or street file is missing or wrong.
    #[error("{source_error}\n  hint: {hint}", source_error = .0, hint = .0.hint())]
    Source(#[from] SourceError),
}

/// Why a preset could not be laid on a city.
#[derive(Debug, thiserror::Error)]
pub enum PresetError {
    /// What it is to be laid on is nothing.
    #[error("{0}")]
    Target(String),
    /// It is not there, or it or the rules it names are wrong: never empty, what stopped it first.
    #[error("{}", .0.first().map(ToString::to_string).unwrap_or_default())]
    Preset(Vec<Fault>),
    /// What it says cannot hold there.
    #[error("{}{}", .0.message, .0.hint.as_ref().map_or(String::new(), |hint| format!("\n  hint: {hint}")))]
    Plan(ParamError),
}

/// A city script that has been run: what it asks for, not yet what it names.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The city's name: that of its folder.
    pub name: String,
    /// Its folder.
    pub folder: PathBuf,
    /// Its script.
    pub script: PathBuf,
    /// What the script asks for; change it with [`Plan::set`].
    pub plan: Plan,
    /// The saved changes that were laid over it.
    pub changes: Changes,
    /// What the script printed.
    pub printed: Vec<String>,
    /// What is wrong or doubtful in it and its rules, found without building, and stops nothing.
    pub doubts: Vec<Fault>,
    /// The texts of all scripts read.
    pub texts: Texts,
    /// Where rules and presets are looked up.
    pub host: Host,
}

/// Everything a build reads.
#[derive(Clone, Debug)]
pub struct Sources {
    /// The city's name.
    pub name: String,
    /// The plan.
    pub plan: Plan,
    /// The maps.
    pub site: Arc<Site>,
    /// Street files.
    pub imports: Vec<ImportFile>,
    /// What is odd about files that could be read.
    pub warnings: Vec<String>,
    /// What is doubtful in scripts.
    pub doubts: Vec<Fault>,
}

/// The streets of a file, as the plan wants them.
#[derive(Clone, Debug)]
pub struct ImportFile {
    /// What lineage hangs on: the file's name.
    pub key: String,
    /// Its streets inside the site, with their classes and widths.
    pub streets: Vec<ImportedStreet>,
    /// Lines left out, by reason, counted.
    pub left_out: BTreeMap<String, usize>,
    /// Whom maps must name.
    pub credit: Option<String>,
}

/// Runs the script of a city, a folder with a `city.rhai` or the script itself, and lays over it what people changed
/// ([`Changes`]). Rules are looked up in the city's folder, then in `rules`, then in the built-in library.
///
/// # Errors
/// [`LoadError`] when there is no script, it fails, or the changes do not suit it.
pub fn load(city: &Path, rules: Option<&Path>) -> Result<Loaded, LoadError> {
    let mut loaded = load_as_written(city, rules)?;
    let file = Changes::file_of(&loaded.script);
    let wrong = |faults, texts: &Texts| {
        if let Ok(text) = fs::read_to_string(&file) {
            texts.keep_text(&file.display().to_string(), &text);
        }
        LoadError::Scripts { faults, texts: texts.clone() }
    };
    loaded.changes = Changes::saved(&loaded.script).map_err(|faults| wrong(faults, &loaded.texts))?;
    let (faults, _) = loaded.changes.clone().lay_what_suits(&mut loaded);
    if faults.is_empty() { Ok(loaded) } else { Err(wrong(faults, &loaded.texts)) }
}

/// The same without the changes.
///
/// # Errors
/// [`LoadError`] when there is no script, or it fails.
pub fn load_as_written(city: &Path, rules: Option<&Path>) -> Result<Loaded, LoadError> {
    let script = if city.is_dir() { city.join("city.rhai") } else { city.to_path_buf() };
    let text = read_script(&script).map_err(|error| missing(city, &script, &error))?;
    let folder = match script.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let own: Arc<dyn Library> = Arc::new(RuleFolder(folder.clone()));
    let given = rules.map(rule_folder).transpose()?;
    let host = Host::new(std::iter::once(own).chain(given).collect());
    let source = Source { text, path: script.display().to_string() };
    let checked = host.check_city(&source, Arc::new(MapFolders(folder.clone())));
    let texts = host.texts().clone();
    let Some(Evaluated { plan, printed }) = checked.evaluated else {
        return Err(LoadError::Scripts { faults: checked.faults, texts });
    };
    let name = fs::canonicalize(&folder).ok().and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
    Ok(Loaded {
        name: name.unwrap_or_else(|| "city".into()),
        folder,
        script,
        plan,
        changes: Changes::default(),
        printed,
        doubts: checked.faults,
        texts,
        host,
    })
}

/// The text of a script. Editors on Windows put a mark in front that Rhai does not know.
pub(crate) fn read_script(path: &Path) -> std::io::Result<String> {
    fs::read_to_string(path).map(|text| text.trim_start_matches('\u{feff}').to_owned())
}

/// What to do about a script that cannot be read.
pub(crate) fn script_hint(cause: &std::io::Error) -> &'static str {
    match cause.kind() {
        std::io::ErrorKind::InvalidData => "scripts are UTF-8 text, as scripts/lattice/city.rhai is",
        std::io::ErrorKind::NotFound => "it is a link to a file that is not there",
        std::io::ErrorKind::PermissionDenied => "the rights of the file let this user not read it",
        _ => "scripts are files of text that can be read",
    }
}

fn missing(city: &Path, script: &Path, error: &std::io::Error) -> LoadError {
    let is_absent = error.kind() == std::io::ErrorKind::NotFound;
    if !is_absent && script.is_file() {
        let cause = std::io::Error::new(error.kind(), error.to_string());
        return LoadError::Unreadable { path: script.to_path_buf(), cause };
    }
    let message = match (is_absent, city.exists()) {
        (true, true) => "there is no city.rhai in this folder".to_owned(),
        (true, false) => "there is no such city".to_owned(),
        _ => format!("{} cannot be read: {error}", script.display()),
    };
    let hint = "name a folder with a city.rhai, such as scripts/manhattan".to_owned();
    LoadError::Missing { path: city.to_path_buf(), message, hint }
}

impl Loaded {
    /// Sets a parameter by its role: `minors.pattern.block_width=90`.
    ///
    /// # Errors
    /// [`ParamError`] when there is no such parameter, or the value does not suit it.
    pub fn set(&mut self, assignment: &str) -> Result<(), ParamError> {
        self.plan.set(assignment)
    }

    /// Lays a preset on something: `village` on the whole city, `minors=village`, `district:old town=medieval_core`,
    /// `quarter:<id>=campus`.
    ///
    /// # Errors
    /// [`PresetError`] when there is no such preset or nothing to lay it on.
    pub fn lay(&mut self, assignment: &str) -> Result<(), PresetError> {
        let (target, name) = assignment.rsplit_once('=').unwrap_or(("city", assignment));
        if target == "city" && assignment.trim().parse::<PresetTarget>().is_ok() {
            let message = format!("`{assignment}` says where, but no preset: write {assignment}=village");
            return Err(PresetError::Target(message));
        }
        let target: PresetTarget = target.trim().parse().map_err(PresetError::Target)?;
        let preset = self.host.preset(name.trim()).map_err(PresetError::Preset)?;
        self.plan.apply(&preset, &target).map_err(PresetError::Plan)
    }

    /// The folders that hold what the city is made from, besides one of further rules; each once, in order.
    pub fn folders(&self) -> Vec<PathBuf> {
        let plan = &self.plan;
        let of_file = |file: &str| self.folder.join(file).parent().map(Path::to_path_buf);
        let districts = match &plan.districts {
            Some(DistrictPlan::File(file)) => of_file(file),
            Some(DistrictPlan::Map { .. }) | None => None,
        };
        let maps = plan.site.folder.as_ref().map(|folder| self.folder.join(folder));
        let imports = plan.imports.iter().filter_map(|import| of_file(&import.file));
        let mut folders: Vec<PathBuf> =
            std::iter::once(self.folder.clone()).chain(maps).chain(districts).chain(imports).collect();
        // What is linked from there changes where it lies.
        let kinds = RuleKind::folders().into_iter().map(|kind| self.folder.join(kind));
        let linked: Vec<PathBuf> =
            folders.iter().cloned().chain(kinds).flat_map(|folder| linked_from(&folder)).collect();
        folders.extend(linked);
        folders.sort();
        folders.dedup();
        folders
    }

    /// Reads the maps and street files that the plan names.
    ///
    /// # Errors
    /// [`LoadError::Source`] for the first file that is missing or wrong.
    pub fn read(&self) -> Result<Sources, LoadError> {
        self.read_with(&Cache::none())
    }

    /// The same, taking maps whose files say the same as before from a cache.
    ///
    /// # Errors
    /// [`LoadError::Source`] for the first file that is missing or wrong, [`LoadError::Scripts`] where it is a text that does not
    /// parse.
    pub fn read_with(&self, cache: &Cache) -> Result<Sources, LoadError> {
        self.read_all(cache).map_err(|error| self.with_text(error))
    }

    /// What is wrong with a value, where the script says it.
    pub fn value_fault(&self, error: &ParamError) -> Fault {
        let file = self.script.display().to_string();
        let place = self.texts.get(&file).and_then(|text| place_in_script(&text, &error.message));
        let (line, column, length) = place.unwrap_or((0, 0, 0));
        Fault { line, column, length, ..Fault::new(file, error.message.clone()).with_hint(error.hint.clone()) }
    }

    /// A text that does not parse is told with the line.
    fn with_text(&self, error: LoadError) -> LoadError {
        let LoadError::Source(SourceError::Syntax { path, line, column, message, hint }) = error else { return error };
        let file = path.display().to_string();
        if let Ok(text) = fs::read_to_string(&path) {
            self.texts.keep_text(&file, &text);
        }
        let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let fault = Fault::new(file, message).with_hint(Some(hint));
        let fault = Fault { line: count(line), column: count(column), length: 1, ..fault };
        LoadError::Scripts { faults: vec![fault], texts: self.texts.clone() }
    }

    fn read_all(&self, cache: &Cache) -> Result<Sources, LoadError> {
        let plan = &self.plan;
        let from_maps = match (&plan.site.folder, plan.site.size) {
            (Some(folder), _) => Some(self.site_of_maps(folder, cache)?),
            (None, Some(size)) => Some(self.drawn_site(size)?),
            (None, None) => None,
        };
        let frame = match &from_maps {
            Some(site) => Frame::of_site(site).map_err(|error| self.frame_error(&error))?,
            None => None,
        };
        let mut files = Vec::new();
        let mut own_site = None;
        for import in &plan.imports {
            let path = self.folder.join(&import.file);
            // Without maps the first file says where the site lies; later ones are read into its frame.
            let known = frame.or_else(|| own_site.as_ref().and_then(|site: &Site| Frame::of_site(site).ok().flatten()));
            let file = read_streets(&path, known, import.units)?;
            if from_maps.is_none() && own_site.is_none() {
                own_site = Some(site_of_streets(&file));
            }
            files.push((import, file_key(&path), file));
        }
        let hint = "give the city a `site`, or `import` streets that say where it lies";
        let site = from_maps.or(own_site);
        let mut site = site.ok_or_else(|| SourceError::kind(&self.folder, "the plan names no site", hint.into()))?;
        let warnings = self.read_districts(&mut site)?;
        let imports =
            files.into_iter().map(|(import, key, file)| import_file(import, key, file, site.bounds)).collect();
        let plan = self.settled(&site)?;
        let name = plan.name.clone().unwrap_or_else(|| self.name.clone());
        let doubts = self.doubts.clone();
        let sources = Sources { name, plan, site: Arc::new(site), imports, warnings, doubts };
        self.check_size(&sources)?;
        Ok(sources)
    }

    /// A site of a size with the maps that the script draws.
    fn drawn_site(&self, size: Vec2) -> Result<Site, SourceError> {
        let mut site = flat_site(size)?;
        site.maps.extend(self.plan.site.drawn.clone());
        if let Some(drawn) = self.plan.site.drawn_districts.clone() {
            site.districts = Arc::new(Districts::of_cells(drawn.names, drawn.cells));
        }
        Ok(site)
    }

    /// Refuses what no machine could hold, before it tries.
    fn check_size(&self, sources: &Sources) -> Result<(), SourceError> {
        let km2 = sources.growing_km2();
        if km2 <= MOST_KM2 {
            return Ok(());
        }
        let message =
            format!("streets would grow on {km2:.0} km²; {MOST_KM2} km² are the most that one city may cover");
        let hint = "give a smaller site (sizes are in metres), or a mask of what to build as `within`";
        Err(SourceError::kind(&self.script, message, hint.into()))
    }

    /// The plan with its values by place read from the site.
    fn settled(&self, site: &Site) -> Result<Plan, LoadError> {
        let mut plan = self.plan.clone();
        let off =
            |landmark: &&script::Landmark| crate::stages::landmarks::share_on(site.bounds, &landmark.ground) < 1.0;
        if let Some(landmark) = plan.landmarks.iter().find(off) {
            let size = site.bounds.size();
            let message = format!("landmark `{}` does not lie on the site", landmark.name);
            let hint = format!("the site goes from [0, 0] to [{:.0}, {:.0}], in metres", size.x, size.y);
            let error = script::ParamError { message, hint: Some(hint) };
            return Err(LoadError::Value { path: self.script.clone(), error });
        }
        plan.settle(site.places()).map_err(|error| LoadError::Value { path: self.script.clone(), error })?;
        Ok(plan)
    }

    /// Reads the districts that a file of polygons tells, and what is odd about it.
    fn read_districts(&self, site: &mut Site) -> Result<Vec<String>, SourceError> {
        let Some(DistrictPlan::File(name)) = &self.plan.districts else { return Ok(Vec::new()) };
        let frame = Frame::of_site(site).map_err(|error| self.frame_error(&error))?;
        let file = read_districts(&self.folder.join(name), frame, site.bounds)?;
        site.districts = Arc::new(file.districts);
        Ok(file.warnings.into_iter().map(|warning| format!("{name}: {warning}")).collect())
    }

    /// The colour map of districts, where the plan or a sidecar with a legend tells of one.
    fn district_map(&self, folder: &Path) -> Option<DistrictMap> {
        match &self.plan.districts {
            Some(DistrictPlan::Map { map, legend }) => {
                Some(DistrictMap { map: map.name.clone(), legend: legend.clone() })
            }
            Some(DistrictPlan::File(_)) => None,
            None => sources::has_legend(&folder.join("districts.png"))
                .then(|| DistrictMap { map: "districts".into(), legend: BTreeMap::new() }),
        }
    }

    fn frame_error(&self, error: &sources::ProjectionError) -> SourceError {
        SourceError::kind(&self.folder, error.to_string(), "maps with streets need a UTM crs such as EPSG:32618".into())
    }

    fn site_of_maps(&self, folder: &str, cache: &Cache) -> Result<Site, SourceError> {
        let plan = &self.plan;
        let folder = self.folder.join(folder);
        let weights = plan.weight_maps();
        let stages = [&plan.highways, &plan.majors, &plan.minors].into_iter().flatten();
        let within = stages.filter_map(|streets| match &streets.within {
            Some(script::Within::Map(map)) => Some(map),
            _ => None,
        });
        let named = plan.within.iter().chain(within).chain(&plan.barred).chain(weights).map(|map| map.name.clone());
        let in_goals = [&plan.highways, &plan.majors, &plan.minors].into_iter().flatten();
        let goals = in_goals.filter_map(|streets| Some(streets.goal().ok()??.map.name));
        let in_chains = [&plan.highways, &plan.majors, &plan.minors].into_iter().flatten();
        let masks = in_chains.flat_map(|streets| streets.masks().unwrap_or_default());
        let present = map_names(&folder)?;
        // A parameter may name a map that is not there, as long as its rule does not ask for it.
        let in_params = plan.param_maps().into_iter().map(|map| map.name.clone()).filter(|name| present.contains(name));
        let names = named.chain(goals).chain(masks).chain(in_params).chain(plan.site.maps.keys().cloned());
        let names: Vec<String> = names.collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut options = BTreeMap::new();
        for name in present {
            let said = plan.site.maps.get(&name).cloned().unwrap_or_default();
            let by_pixels = || {
                let (width, height) = image::image_dimensions(folder.join(format!("{name}.png"))).ok()?;
                said.pixel_size.map(|metres| Vec2::new(f64::from(width), f64::from(height)) * metres)
            };
            if let Some(size) = said.size.or_else(by_pixels).or(plan.site.size) {
                let is_mask = said.units.as_deref().map_or_else(|| is_mask_by_name(&name), |units| units == "mask");
                let (scale, offset) = (said.scale.unwrap_or(1.0), said.offset.unwrap_or(0.0));
                options.insert(name, MapOptions { size_m: size.to_array(), scale, offset, mask: is_mask });
            }
        }
        load_site_with(&folder, &names, &options, self.district_map(&folder).as_ref(), cache)
    }
}

/// Known maps that hold yes or no; others hold numbers unless their sidecar says `mask`.
fn is_mask_by_name(name: &str) -> bool {
    KNOWN_MAPS.contains(&name) && matches!(name, "land" | "parks")
}

fn read_streets(
    path: &Path,
    frame: Option<Frame>,
    units: Option<StreetUnits>,
) -> Result<sources::StreetFile, SourceError> {
    let name = path.to_string_lossy();
    if name.ends_with(".osm") || name.ends_with(".pbf") {
        return read_osm(path, frame);
    }
    let frame = match (units, frame) {
        (Some(StreetUnits::Metres), _) => GeoJsonFrame::LocalMetres,
        (Some(StreetUnits::Degrees), frame) => GeoJsonFrame::Degrees(frame),
        (None, Some(frame)) => GeoJsonFrame::Onto(frame),
        (None, None) => GeoJsonFrame::Detect,
    };
    read_geojson_streets(path, frame)
}

/// The site of a plan that has streets but no maps: what the file says it covers.
fn site_of_streets(file: &sources::StreetFile) -> Site {
    Site {
        bounds: Bounds { min: Point::new(0, 0), ..file.bounds },
        crs: file.frame.map(|frame| frame.projection.crs()),
        origin: file.frame.map(|frame| frame.origin),
        maps: BTreeMap::new(),
        districts: Arc::default(),
    }
}

/// The folders in which files lie that a folder links to.
fn linked_from(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let links = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_symlink()));
    let targets = links.filter_map(|link| link.path().canonicalize().ok());
    targets
        .filter_map(|target| if target.is_dir() { Some(target) } else { target.parent().map(Path::to_path_buf) })
        .collect()
}

fn import_file(import: &StreetImport, key: String, file: sources::StreetFile, bounds: Bounds) -> ImportFile {
    let mut left_out = file.left_out;
    let mut streets = Vec::new();
    for street in file.streets {
        let kept = parts_inside(street, bounds);
        if kept.is_empty() {
            *left_out.entry("outside the site".into()).or_default() += 1;
        }
        streets.extend(kept.into_iter().map(|street| as_planned(street, import)));
    }
    let is_osm = key.ends_with(".osm") || key.ends_with(".pbf");
    let credit = import.credit.clone().or_else(|| is_osm.then(|| "Streets © OpenStreetMap contributors".to_owned()));
    ImportFile { key, streets, left_out, credit }
}

/// The parts of a street between points inside the bounds.
fn parts_inside(street: ImportedStreet, bounds: Bounds) -> Vec<ImportedStreet> {
    let inside = |point: &Vec2| Point::try_from_metres(*point).is_some_and(|point| bounds.contains(point));
    if street.points.iter().all(inside) {
        return vec![street];
    }
    let mut parts = Vec::new();
    let mut start = 0;
    while start < street.points.len() {
        let length = street.points[start..].iter().take_while(|point| inside(point)).count();
        if length >= 2 {
            let range = start..start + length;
            let refs = street.refs.get(range.clone()).map(<[i64]>::to_vec).unwrap_or_default();
            let key = if parts.is_empty() { street.key.clone() } else { format!("{}#{}", street.key, parts.len()) };
            parts.push(ImportedStreet { key, points: street.points[range].to_vec(), refs, ..street.clone() });
        }
        start += length + 1;
    }
    parts
}

/// A street with the class and width that the plan gives streets of its kind.
fn as_planned(mut street: ImportedStreet, import: &StreetImport) -> ImportedStreet {
    let kind = street.class.clone();
    let classes = Classes::default();
    let chosen = import.classes.get(&kind).copied().or(import.class);
    if let Some(class) = chosen {
        street.class = classes.info(class).name.clone();
    }
    let planned = import.widths.get(&kind).copied();
    street.width = planned.or(street.width).or(import.width).or(Some(class_width(&street.class)));
    street
}

impl Sources {
    /// The digest of all that the city and what is said about it are made from. Rules count as they are, whether or not
    /// anything calls them.
    pub fn digest(&self, cache: &Cache) -> Id {
        let Self { name, plan, site: _, imports: _, warnings, doubts } = self;
        let mut digest = Digest::new("sources");
        digest.id(Keys::of(self, cache).buildings).value(&(name, plan.seed, warnings, doubts, self.credits()));
        digest.finish()
    }

    /// Whom maps of the city must name, each once.
    pub fn credits(&self) -> Vec<String> {
        let mut credits: Vec<String> = self.imports.iter().filter_map(|file| file.credit.clone()).collect();
        credits.sort();
        credits.dedup();
        credits
    }

    /// Square kilometres on which streets may grow: the site, as far as masks say; 0 when the plan grows none.
    pub fn growing_km2(&self) -> f64 {
        let plan = &self.plan;
        if plan.highways.is_none() && plan.majors.is_none() && plan.minors.is_none() {
            return 0.0;
        }
        let share = |map: Option<&Arc<Raster>>| {
            let values = map.map_or(&[][..], |map| map.values());
            let inside = values.iter().filter(|&&value| value > 0.5).count();
            if values.is_empty() { 1.0 } else { inside as f64 / values.len() as f64 }
        };
        let within = plan.within.as_ref().and_then(|within| self.site.map(&within.name));
        let size = self.site.bounds.size();
        size.x * size.y / 1e6 * share(self.site.map("land")).min(share(within))
    }

    /// Whether streets may lie anywhere at all.
    pub fn has_legal_land(&self) -> bool {
        let any = |map: Option<&Arc<Raster>>| map.is_none_or(|map| map.values().iter().any(|&value| value > 0.5));
        any(self.site.map("land")) && any(self.plan.within.as_ref().and_then(|within| self.site.map(&within.name)))
    }
}

/// Rule files in a folder.
#[derive(Debug)]
pub(crate) struct RuleFolder(pub PathBuf);

impl Library for RuleFolder {
    fn read(&self, name: &str) -> Option<Result<Source, String>> {
        let path = self.0.join(name);
        match read_script(&path) {
            Ok(text) => Some(Ok(Source { text, path: path.display().to_string() })),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
            Err(error) => Some(Err(format!("{}: {error}", path.display()))),
        }
    }

    fn place(&self) -> String {
        if self.0 == Path::new(".") { "this folder".into() } else { self.0.display().to_string() }
    }

    fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for kind in RuleKind::folders() {
            let Ok(entries) = fs::read_dir(self.0.join(kind)) else { continue };
            let files = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
            names.extend(
                files
                    .filter(|file| file.ends_with(".rhai") && !is_tests(Path::new(file)))
                    .map(|file| format!("{kind}/{file}")),
            );
        }
        names.sort();
        names
    }
}

/// Folders of maps beside a city script.
#[derive(Debug)]
pub(crate) struct MapFolders(pub PathBuf);

impl Sites for MapFolders {
    fn site(&self, request: &SiteRequest) -> Result<SiteInfo, String> {
        let folder = self.0.join(&request.folder);
        let maps = map_names(&folder).map_err(|error| error.to_string())?;
        let size = request.size.or_else(|| {
            let first = maps.first()?;
            sources::map_size(&folder.join(format!("{first}.png")))
        });
        Ok(SiteInfo { maps, size })
    }
}

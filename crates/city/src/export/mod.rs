//! Everything a city is written as. Files appear whole or not at all: each is produced beside its final place first,
//! and all are put there only when every one of them was produced.

pub mod geojson;
pub mod glb;
pub mod layout_file;
pub mod map;
pub mod steps;

#[cfg(test)]
pub(crate) mod samples;

use crate::{Cache, Cancel, City};
use rayon::prelude::*;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::NamedTempFile;

pub use layout_file::{LayoutFile, ReadError, read_layout};
pub use map::{ColourBy, MapOptions, Mark};

/// The name of the report's file.
pub const REPORT: &str = "report.json";

/// What a city can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Format {
    /// `layout.geojson`: streets, blocks, parcels and buildings in local metres.
    Layout,
    /// `map.svg`: a drawn map.
    Svg,
    /// `map.png`: the same map in pixels.
    Png,
    /// `city.glb`: terrain, streets and buildings in 3D.
    Glb,
}

impl Format {
    /// All formats, in the order they are told.
    pub const ALL: [Self; 4] = [Self::Layout, Self::Svg, Self::Png, Self::Glb];

    /// The name of its file.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Layout => "layout.geojson",
            Self::Svg => "map.svg",
            Self::Png => "map.png",
            Self::Glb => "city.glb",
        }
    }

    fn write(self, city: &City, map: &MapOptions, cache: &Cache, out: &mut dyn Write) -> Result<(), Problem> {
        let options = with_credits(city, map);
        match self {
            Self::Layout => geojson::write_layout(city, out)?,
            Self::Svg => map::write_svg(city, &options, cache, out)?,
            Self::Png => out.write_all(&map::png(city, &options, cache)?)?,
            Self::Glb => glb::write(&glb::model(city, cache), out)?,
        }
        Ok(())
    }
}

/// The options, with whom the city owes its streets to.
fn with_credits(city: &City, map: &MapOptions) -> MapOptions {
    let credits = (!city.credits.is_empty()).then(|| city.credits.join(" · "));
    MapOptions { attribution: map.attribution.clone().or(credits), ..map.clone() }
}

/// Why a file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {problem}", path = path.display())]
pub struct ExportError {
    /// The file or folder.
    pub path: PathBuf,
    /// What went wrong.
    #[source]
    pub problem: Problem,
}

/// What can go wrong on the way to a file.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The folder or file can't be written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The build was cancelled before any file was put in its place.
    #[error("stopped; nothing was written")]
    Cancelled,
    /// The map could not be drawn.
    #[error("{0}")]
    Map(#[from] map::MapError),
    /// The model does not fit its format.
    #[error("{0}")]
    Glb(#[from] glb::GlbError),
}

fn at<P: Into<Problem>>(path: &Path) -> impl FnOnce(P) -> ExportError {
    |problem| ExportError { path: path.into(), problem: problem.into() }
}

/// Makes the folder and finds out whether files can be written to it, before hours of work.
///
/// # Errors
/// When it can't be made, is no folder, or refuses new files.
pub fn prepare(folder: &Path) -> Result<(), ExportError> {
    if let Some(file) = folder.ancestors().find(|path| path.exists()).filter(|path| !path.is_dir()) {
        let reason = format!("{} is a file, not a folder\n  hint: name another folder with -o", file.display());
        return Err(at(folder)(io::Error::new(io::ErrorKind::NotADirectory, reason)));
    }
    fs::create_dir_all(folder).map_err(at(folder))?;
    let targets = Format::ALL.map(Format::file_name).into_iter().chain([REPORT]);
    if let Some(path) = targets.map(|name| folder.join(name)).find(|path| path.is_dir()) {
        return Err(at(&path)(io::Error::new(io::ErrorKind::IsADirectory, "a folder stands where the file goes")));
    }
    remove_leftovers(folder);
    new_file(folder).map(drop).map_err(at(folder))
}

/// Writes a city in all formats, and `report.json` with the text of `report`, into a folder, which is made if need be;
/// says which files there are. Either all of them are new afterwards, or none was touched (only a machine that stops
/// between two renames can part them).
///
/// # Errors
/// When a file can't be produced or put in its place, or `cancel` asks to stop while files are still being produced.
pub fn write_all(city: &City, report: &[u8], folder: &Path, cancel: &Cancel) -> Result<Vec<PathBuf>, ExportError> {
    write_formats(city, folder, &Format::ALL, &[(REPORT, report)], cancel)
}

/// The same for some formats and any other files, given as name and content.
///
/// # Errors
/// When a file can't be produced or put in its place.
pub fn write_formats(
    city: &City,
    folder: &Path,
    formats: &[Format],
    others: &[(&str, &[u8])],
    cancel: &Cancel,
) -> Result<Vec<PathBuf>, ExportError> {
    let wanted = Wanted { map: &MapOptions::default(), formats, others, cache: &Cache::none(), is_durable: true };
    write_wanted(city, &wanted, folder, cancel)
}

/// What is to be written.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// How the map is drawn.
    pub map: &'a MapOptions,
    /// The formats.
    pub formats: &'a [Format],
    /// Other files, as name and content.
    pub others: &'a [(&'a str, &'a [u8])],
    /// What earlier exports kept.
    pub cache: &'a Cache,
    /// Whether to wait until the files are on the disk, so that even a machine that stops right after it has them whole.
    pub is_durable: bool,
}

/// The same for all that is wanted.
///
/// # Errors
/// When a file can't be produced or put in its place.
pub fn write_wanted(city: &City, wanted: &Wanted, folder: &Path, cancel: &Cancel) -> Result<Vec<PathBuf>, ExportError> {
    let Wanted { map, formats, others, cache, is_durable } = *wanted;
    prepare(folder)?;
    let mut formats = formats.to_vec();
    formats.sort_unstable();
    formats.dedup();
    let stop = |path: &Path| if cancel.is_cancelled() { Err(at(path)(Problem::Cancelled)) } else { Ok(()) };
    let write = |format: &Format| {
        let path = folder.join(format.file_name());
        stop(&path)?;
        let file = produce(&path, |out| format.write(city, map, cache, &mut Stoppable { out, cancel }));
        stop(&path)?;
        Ok((path, file?))
    };
    // The model and the picture take longest: begun first, so that no thread is left with one of them in the end.
    let files: Vec<_> = formats.par_iter().rev().map(write).collect();
    let mut produced: Vec<_> = files.into_iter().rev().collect::<Result<_, ExportError>>()?;
    for (name, content) in others {
        let path = folder.join(name);
        let file = produce(&path, |out| Ok(out.write_all(content)?))?;
        produced.push((path, file));
    }
    stop(folder)?;
    if is_durable {
        sync(&produced)?;
        stop(folder)?;
    }
    produced.into_iter().map(|(path, file)| put_in_place(file, &path).map(|()| path)).collect()
}

/// Brings files onto the disk, all at the same time: threads that compute need not wait for it.
fn sync(files: &[(PathBuf, NamedTempFile)]) -> Result<(), ExportError> {
    std::thread::scope(|scope| {
        let sync = |(path, file): &(PathBuf, NamedTempFile)| file.as_file().sync_all().map_err(at(path));
        let syncing: Vec<_> = files.iter().map(|file| scope.spawn(move || sync(file))).collect();
        syncing
            .into_iter()
            .try_for_each(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// A writer that fails as soon as the build is cancelled: a large file takes long.
struct Stoppable<'a> {
    out: &'a mut dyn Write,
    cancel: &'a Cancel,
}

impl Write for Stoppable<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.cancel.is_cancelled() { Err(io::Error::other("cancelled")) } else { self.out.write(bytes) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Writes one file so that it is either whole or as before.
///
/// # Errors
/// When `write` fails or the file can't be put in its place.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), ExportError> {
    let file = produce(path, |out| write(out).map_err(Problem::Io))?;
    file.as_file().sync_all().map_err(at(path))?;
    put_in_place(file, path)
}

/// What files are called before they are put in their places.
pub(crate) const UNFINISHED: &str = ".plat-";

/// Age at which such a file is no other program's work any more.
const LEFT_OVER: Duration = Duration::from_secs(6 * 3600);

/// A file that is not yet in its place.
pub(crate) fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(UNFINISHED).tempfile_in(folder)
}

/// Removes what programs that were killed left in a folder.
pub(crate) fn remove_leftovers(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED)) {
        let age = entry.metadata().and_then(|about| about.modified()).ok().and_then(|time| time.elapsed().ok());
        if age.is_some_and(|age| age > LEFT_OVER) {
            // Another program may have been faster.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Whether a file in a folder of results is one that exports write there.
pub(crate) fn is_own(name: &str) -> bool {
    let results = Format::ALL.map(Format::file_name);
    name.starts_with(UNFINISHED) || name == REPORT || results.contains(&name)
}

/// Fills a temporary file in the folder of `path`.
fn produce(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), Problem>,
) -> Result<NamedTempFile, ExportError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = new_file(folder).map_err(at(path))?;
    let mut out = BufWriter::with_capacity(1 << 18, file);
    write(&mut out).map_err(at(path))?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error).map_err(at(path))?;
    make_readable(&file).map_err(at(path))?;
    Ok(file)
}

/// Temporary files are for their owner only; what we write is for everyone to read.
pub(crate) fn make_readable(file: &NamedTempFile) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        file.as_file().set_permissions(fs::Permissions::from_mode(0o644))?;
    }
    let _ = file;
    Ok(())
}

fn put_in_place(file: NamedTempFile, path: &Path) -> Result<(), ExportError> {
    file.persist(path).map(drop).map_err(|error| at(path)(error.error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use samples::{hilly_city, small_city};

    fn listing(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn all_files_are_written_readable_and_the_same_every_time() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("deep/er");
        let files = write_all(&small_city(), b"{}\n", &out, &Cancel::default()).unwrap();
        assert_eq!(listing(&out), ["city.glb", "layout.geojson", "map.png", "map.svg", "report.json"]);
        let before: Vec<_> = files.iter().map(|path| fs::read(path).unwrap()).collect();
        #[cfg(unix)]
        for path in &files {
            use std::os::unix::fs::PermissionsExt;
            assert_eq!(fs::metadata(path).unwrap().permissions().mode() & 0o777, 0o644);
        }
        write_all(&small_city(), b"{}\n", &out, &Cancel::default()).unwrap();
        assert_eq!(files.iter().map(|path| fs::read(path).unwrap()).collect::<Vec<_>>(), before);
    }

    #[test]
    fn a_layout_reads_back_as_it_was() {
        let city = hilly_city();
        let folder = tempfile::tempdir().unwrap();
        write_formats(&city, folder.path(), &[Format::Layout], &[], &Cancel::default()).unwrap();
        let file = read_layout(&folder.path().join("layout.geojson")).unwrap();
        let about = file.about.unwrap();
        assert_eq!((about.seed.as_deref(), about.crs.as_deref()), (Some("1625"), Some("EPSG:32618")));
        assert_eq!(about.origin, Some([579_660.0, 4_503_410.0]));
        let of = |kind: &str| {
            let such = file.features.iter().filter(|f| f.properties.kind.as_deref() == Some(kind));
            such.collect::<Vec<_>>()
        };
        assert_eq!(of("crossing").len(), geojson::crossings(&city).len());
        let positions =
            |ring: &[geom::Point]| ring.iter().chain(ring.first()).map(|p| p.metres().to_array()).collect::<Vec<_>>();
        for (feature, parcel) in of("parcel").iter().zip(city.parcels.iter()) {
            assert_eq!(feature.properties.id, Some(parcel.id.to_string()));
            assert_eq!(feature.geometry, layout_file::Geometry::Polygon(vec![positions(&parcel.polygon.outer)]));
        }
        for (feature, run) in of("street").iter().zip(&city.runs) {
            assert_eq!(feature.properties.width, Some(f64::from(run.half_width) / 512.0));
            assert_eq!((feature.properties.bridge, feature.properties.level), (run.level > 0, f64::from(run.level)));
        }
        for (feature, building) in of("building").iter().zip(city.buildings.iter()) {
            assert!((feature.properties.height.unwrap() - building.height).abs() < 1e-9);
            assert_eq!(feature.properties.parcel, Some(building.parcel.to_string()));
        }
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, |out| out.write_all(b"old")).unwrap();
        let error = write_atomically(&path, |out| {
            out.write_all(b"new, half")?;
            Err(io::Error::other("the disk is full"))
        });
        assert_eq!(error.unwrap_err().to_string(), format!("{}: the disk is full", path.display()));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(listing(folder.path()), ["a.txt"]);
    }

    #[test]
    fn an_impossible_folder_is_found_first() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        assert!(prepare(&file).unwrap_err().to_string().contains("file"));
        assert!(prepare(&file.join("below")).is_err());
        assert!(prepare(&folder.path().join("new")).is_ok());
    }

    #[test]
    fn a_cancelled_export_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let cancel = Cancel::default();
        cancel.cancel();
        let error = write_all(&small_city(), b"{}", folder.path(), &cancel).unwrap_err();
        assert!(matches!(error.problem, Problem::Cancelled));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_file_under_way_hears_of_a_cancelled_build() {
        let (cancel, mut out) = (Cancel::default(), Vec::new());
        let mut file = Stoppable { out: &mut out, cancel: &cancel };
        file.write_all(b"half").unwrap();
        cancel.cancel();
        assert!(file.write_all(b"the rest").is_err());
        assert_eq!(out, b"half");
    }

    #[test]
    fn a_file_in_the_way_is_named_with_a_hint() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "mine").unwrap();
        let error = prepare(&file.join("deep/er")).unwrap_err();
        assert!(error.to_string().contains(&format!("{} is a file", file.display())), "{error}");
        assert!(error.to_string().contains("hint: name another folder with -o"), "{error}");
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    }

    #[test]
    fn a_folder_in_the_way_is_found_before_anything_is_written() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("map.svg")).unwrap();
        assert!(write_all(&small_city(), b"{}", folder.path(), &Cancel::default()).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

//! `site("maps")` and its maps.

use super::drawn::drawn_site;
use crate::fault::{Complaint, Refusal};
use crate::host::{is_inside, kind_of};
use crate::names::hint;
use crate::plan::{MapOptions, MapRef, SitePlan};
use crate::words::options::Options;
use geom::Vec2;
use rhai::{Dynamic, Engine, FuncRegistration, Map, NativeCallContext};
use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a script asks of the one who reads maps.
#[derive(Clone, Debug, PartialEq)]
pub struct SiteRequest {
    /// The folder, relative to the city's own; never outside it.
    pub folder: String,
    /// Width and height in metres, where the script says so.
    pub size: Option<Vec2>,
}

/// What a folder of maps holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteInfo {
    /// The names of its maps: file names without extension.
    pub maps: Vec<String>,
    /// Width and height in metres, where known.
    pub size: Option<Vec2>,
}

/// Looks into folders of maps. This crate reads no files: `city` implements it.
pub trait Sites: Send + Sync + Debug {
    /// What a folder holds, or why it cannot be told.
    fn site(&self, request: &SiteRequest) -> Result<SiteInfo, String>;
}

/// What a script holds of a site.
#[derive(Clone, Debug)]
pub(crate) struct SiteHandle {
    plan: Arc<Mutex<SitePlan>>,
    info: Arc<SiteInfo>,
}

impl SiteHandle {
    /// A site as told, with what its folder holds.
    pub fn new(plan: SitePlan, info: SiteInfo) -> Self {
        Self { plan: Arc::new(Mutex::new(plan)), info: Arc::new(info) }
    }

    fn lock(&self) -> MutexGuard<'_, SitePlan> {
        self.plan.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The site as the script left it.
    pub fn plan(&self) -> SitePlan {
        self.lock().clone()
    }

    pub(super) fn map(&self, name: &str) -> Result<MapRef, Complaint> {
        let name = name.strip_suffix(".png").unwrap_or(name);
        if self.info.maps.iter().any(|known| known == name) {
            return Ok(MapRef { name: name.to_owned() });
        }
        let near = hint(name, self.info.maps.iter().map(String::as_str));
        let help = near.unwrap_or_else(|| format!("put {name}.png, with {name}.json, into the folder of its maps"));
        Err(Complaint::new(format!("the site has no map `{name}`")).hint(help))
    }

    fn map_with(&self, name: &str, options: Map) -> Result<MapRef, Complaint> {
        let map = self.map(name)?;
        let read = map_options(options)?;
        self.lock().maps.insert(map.name.clone(), read);
        Ok(map)
    }
}

pub(super) fn register(engine: &mut Engine, sites: Arc<dyn Sites>) {
    engine.register_type_with_name::<SiteHandle>("site").register_type_with_name::<MapRef>("a map of the site");
    let own = sites.clone();
    FuncRegistration::new("site")
        .with_params_info(["folder"])
        .with_comments(["/// The site whose maps lie in a folder beside the script."])
        .register_into_engine(engine, move |folder: &str| folder_site(&*own, folder, Map::new()));
    FuncRegistration::new("site")
        .with_params_info(["folder", "#{ size }"])
        .with_comments(["/// The same, with the size in metres for maps without sidecars."])
        .register_into_engine(engine, move |folder: &str, options: Map| folder_site(&*sites, folder, options));
    FuncRegistration::new("site")
        .with_params_info(["#{ size: [width, height], name: |x, y| … }"])
        .with_comments([
            "/// A site so many metres wide and high, flat and empty but for the maps that functions of a place draw.",
        ])
        .register_into_engine(engine, |context: NativeCallContext, options: Map| drawn_site(&context, options));
    FuncRegistration::new("map")
        .with_params_info(["this", "name"])
        .with_comments(["/// A map of the site by its file name, with or without .png."])
        .register_into_engine(engine, |site: &mut SiteHandle, name: &str| Ok::<_, Refusal>(site.map(name)?));
    FuncRegistration::new("map")
        .with_params_info(["this", "name", "#{ size_m, pixel_size_m, scale, offset, units }"])
        .with_comments(["/// The same, saying what its sidecar does not."])
        .register_into_engine(engine, |site: &mut SiteHandle, name: &str, options: Map| {
            Ok::<_, Refusal>(site.map_with(name, options)?)
        });
    crate::words::getter(engine, "name", "What the map is called.", |map: &mut MapRef| map.name.clone());
    crate::words::getter(engine, "width", "How far the site reaches to the east, m.", |site: &mut SiteHandle| {
        extent(site).map(|size| size.x)
    });
    crate::words::getter(engine, "height", "How far the site reaches to the north, m.", |site: &mut SiteHandle| {
        extent(site).map(|size| size.y)
    });
}

fn extent(site: &SiteHandle) -> Result<Vec2, Refusal> {
    let size = site.lock().size.or(site.info.size);
    size.ok_or_else(|| {
        Complaint::new("the size of the site is not known").hint("say site(\"maps\", #{ size: [w, h] })").into()
    })
}

fn folder_site(sites: &dyn Sites, folder: &str, options: Map) -> Result<SiteHandle, Refusal> {
    if !is_inside(folder) {
        let help = "maps lie in a folder beside the script, such as \"maps\"";
        return Err(Complaint::new(format!("`{folder}` is not a folder below this one")).hint(help).into());
    }
    let size = Options::new("site", options, &["size"])?.size("size")?;
    let request = SiteRequest { folder: folder.to_owned(), size };
    let help = "maps lie in a folder beside the script; a site without any is site(#{ size: [3000, 2000] })";
    let info = sites.site(&request).map_err(|message| Complaint::new(message).hint(help))?;
    Ok(SiteHandle::new(SitePlan { folder: Some(request.folder), size, ..SitePlan::default() }, info))
}

fn map_options(options: Map) -> Result<MapOptions, Complaint> {
    let mut options = Options::new("site.map", options, &["size_m", "pixel_size_m", "scale", "offset", "units"])?;
    Ok(MapOptions {
        size: options.size("size_m")?,
        pixel_size: options.within("pixel_size_m", 1e-3, 1e5, " m")?,
        scale: options.number("scale")?,
        offset: options.number("offset")?,
        units: options.text("units")?,
    })
}

/// A site, or the complaint that it is none.
pub(super) fn site_of(value: &Dynamic) -> Result<SitePlan, Complaint> {
    let given = kind_of(value);
    let site = value.clone().try_cast::<SiteHandle>();
    let wrong = || Complaint::new(format!("`site` must be site(…), not {given}")).key("site");
    site.map(|site| site.plan()).ok_or_else(wrong)
}

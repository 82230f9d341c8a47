//! `site(#{ size: [3000, 2000], density: |x, y| … })`: sites whose maps a script draws by functions of a place.

use super::site::{SiteHandle, SiteInfo};
use crate::fault::{Complaint, Refusal};
use crate::host::{Spending, is_inside, kind_of, numeric, spend};
use crate::plan::{DrawnDistricts, SitePlan};
use crate::words::options::Options;
use geom::{Cells, Raster, Vec2};
use rhai::{Dynamic, EvalAltResult, FnPtr, Map, NativeCallContext};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Cells along the longer side of a drawn map, at most; none is smaller than [`LEAST_CELL`].
const MOST_CELLS: f64 = 256.0;
/// Smallest cell, metres.
const LEAST_CELL: f64 = 5.0;
/// What drawing a map takes of the operations of its script.
const PRICE: u64 = 1000;
/// Operations that the functions of a map may take besides: some 150 for each of its cells.
const DRAWING: u64 = 10_000_000;
/// The name that tells districts rather than a map.
const DISTRICTS: &str = "districts";

/// A site of a size, with maps drawn.
pub(super) fn drawn_site(context: &NativeCallContext, mut options: Map) -> Result<SiteHandle, Refusal> {
    let size = options.remove("size").map(|size| Map::from([("size".into(), size)]));
    let size = size.map(|size| Options::new("site", size, &["size"])?.size("size")).transpose()?.flatten();
    let size =
        size.ok_or_else(|| Complaint::new("a site without maps needs a size").hint("site(#{ size: [3000, 2000] })"))?;
    let grid = Grid::of(size);
    let mut plan = SitePlan { size: Some(size), ..SitePlan::default() };
    for (name, value) in options {
        if name == DISTRICTS {
            plan.drawn_districts = Some(grid.districts(context, &value)?);
        } else if is_inside(&name) && !name.contains('/') {
            let map = grid.map(context, &name, &value)?;
            plan.drawn.insert(name.into(), Arc::new(map));
        } else {
            let help = "a map is called by letters, digits and _";
            return Err(Complaint::new(format!("`{name}` cannot be the name of a map")).hint(help).into());
        }
    }
    let maps = plan.drawn.keys().cloned().collect();
    Ok(SiteHandle::new(plan, SiteInfo { size: Some(size), maps }))
}

/// A map that a function of a place in metres draws.
pub(crate) fn drawn_map(size: Vec2, at: impl Fn(Vec2) -> f64) -> Raster {
    let grid = Grid::of(size);
    let values = grid.places().map(|place| at(place) as f32).collect();
    Raster::new(grid.columns, grid.rows, grid.cell, Vec2::ZERO, values).expect("finite values, one for each cell")
}

/// The cells of drawn maps. Rows from the north, as in images.
struct Grid {
    columns: usize,
    rows: usize,
    cell: f64,
}

impl Grid {
    fn of(size: Vec2) -> Self {
        let cell = (size.max_element() / MOST_CELLS).max(LEAST_CELL);
        // The size of a site is checked when it is read; until then it may be anything.
        let count = |metres: f64| (metres / cell).ceil().clamp(1.0, MOST_CELLS + 1.0) as usize;
        Self { columns: count(size.x), rows: count(size.y), cell }
    }

    /// The middle of each cell in metres, row by row from the north.
    fn places(&self) -> impl Iterator<Item = Vec2> {
        let at = |column: usize, row: usize| Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.cell;
        (0..self.rows).rev().flat_map(move |row| (0..self.columns).map(move |column| at(column, row)))
    }

    /// What a function says of the middle of each cell, row by row.
    fn ask<T>(
        &self,
        context: &NativeCallContext,
        name: &str,
        value: &Dynamic,
        read: impl Fn(Dynamic) -> Result<T, Complaint>,
    ) -> Result<Vec<T>, Refusal> {
        let keyed = |told: Result<T, Complaint>| told.map_err(|wrong| Refusal::from(wrong.key(name)));
        // Drawing has an allowance of its own, map by map; so that there are not too many, each takes from that of the script.
        spend(PRICE);
        let _spending = Spending::start_with(DRAWING);
        let Some(function) = value.read_lock::<FnPtr>().map(|function| function.clone()) else {
            return self.places().map(|_| keyed(read(value.clone()))).collect();
        };
        let ask = |place: Vec2| {
            let told = function.call_within_context::<Dynamic>(context, (place.x, place.y));
            keyed(read(told.map_err(|error| miscounted(name, error))?))
        };
        self.places().map(ask).collect()
    }

    fn map(&self, context: &NativeCallContext, name: &str, value: &Dynamic) -> Result<Raster, Refusal> {
        let values = self.ask(context, name, value, |value| number(name, &value))?;
        let raster = Raster::new(self.columns, self.rows, self.cell, Vec2::ZERO, values);
        Ok(raster.map_err(|error| Complaint::new(error.to_string()).key(name))?)
    }

    fn districts(&self, context: &NativeCallContext, value: &Dynamic) -> Result<DrawnDistricts, Refusal> {
        let text = |value: Dynamic| {
            let given = kind_of(&value);
            let wrong = |_| Complaint::new(format!("a district is told by its name, not by {given}"));
            value
                .into_string()
                .map_err(|kind| wrong(kind).hint("districts: |x, y| if x < 500 { \"old town\" } else { \"\" }"))
        };
        let told = self.ask(context, DISTRICTS, value, text)?;
        let names: BTreeSet<&String> = told.iter().filter(|name| !name.is_empty()).collect();
        let positions: BTreeMap<&String, u16> =
            names.iter().zip(0..).map(|(name, position)| (*name, position)).collect();
        let label = |column: usize, row: usize| positions.get(&told[row * self.columns + column]).copied();
        let cells = Cells::new(self.columns, self.rows, self.cell, Vec2::ZERO, label);
        let cells = cells.ok_or_else(|| Complaint::new("the site is too large for districts").key("size"))?;
        Ok(DrawnDistricts { names: names.into_iter().cloned().collect(), cells })
    }
}

/// The complaint about a function that takes no place, or never ends; any other error as it is.
fn miscounted(name: &str, error: Refusal) -> Refusal {
    match &*error {
        // It stays what no script can catch; what it says is told from here, for the loop's own place is not known.
        EvalAltResult::ErrorTerminated(_, at) => {
            let message = format!("the map `{name}` was stopped after {DRAWING} operations");
            let complaint = Complaint::new(message).hint("is there an endless loop in its function?").key(name);
            EvalAltResult::ErrorTerminated(Dynamic::from(complaint), *at).into()
        }
        EvalAltResult::ErrorFunctionNotFound(called, _) if called.starts_with("anon$") => {
            let message = format!("the map `{name}` is drawn by a function of x and y");
            Complaint::new(message).hint(format!("{name}: |x, y| 100 * x")).key(name).into()
        }
        _ => error,
    }
}

/// A value of a map: true is 1.
fn number(name: &str, value: &Dynamic) -> Result<f32, Complaint> {
    if let Ok(is_so) = value.as_bool() {
        return Ok(if is_so { 1.0 } else { 0.0 });
    }
    if value.is_string() || value.is_map() || value.is_array() || value.is_unit() {
        let message = format!("the map `{name}` is drawn by numbers, not by {}", kind_of(value));
        let help = match value.is_string() {
            true => "names of districts are drawn by the map called `districts`: districts: |x, y| …".to_owned(),
            false => format!("{name}: |x, y| 100 * x, or a number for all ground"),
        };
        return Err(Complaint::new(message).hint(help));
    }
    Ok(numeric(&format!("the map `{name}`"), value)? as f32)
}

//! Longitude and latitude to metres: Universal Transverse Mercator on WGS 84 (EPSG:326xx and EPSG:327xx).
//!
//! Krüger's series in the third flattening n to n⁶, as in Karney, "Transverse Mercator with an accuracy of a few
//! nanometers", J. Geodesy 85 (2011), eqs. 11, 12, 35, 36. Written here rather than taken from a library because those call the
//! platform's own sine, and positions must be the same everywhere.

use crate::Site;
use geom::Vec2;
use thiserror::Error;

/// Equatorial radius of the WGS 84 ellipsoid, metres.
const RADIUS: f64 = 6_378_137.0;
/// Flattening of the WGS 84 ellipsoid.
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Scale on the central meridian.
const SCALE: f64 = 0.9996;
/// Easting of the central meridian, metres.
const FALSE_EASTING: f64 = 500_000.0;
/// Northing of the equator in southern zones, metres.
const FALSE_NORTHING: f64 = 10_000_000.0;
/// Northernmost latitude of the zones, degrees.
const MAX_LATITUDE: f64 = 84.0;
/// Southernmost latitude of the zones, degrees.
const MIN_LATITUDE: f64 = -80.0;
/// How far from its central meridian a zone is still used, degrees: the series holds a nanometre to 35° and more, but
/// a city that far out would be badly stretched.
const MAX_FROM_MERIDIAN: f64 = 30.0;
/// Terms of the series.
const ORDER: usize = 6;

/// Why a place or a coordinate reference system cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ProjectionError {
    /// Not a UTM zone.
    #[error(
        "`{0}` is not a known coordinate reference system: use EPSG:32601 to 32660 (UTM north) or EPSG:32701 to 32760 (UTM south)"
    )]
    UnknownCrs(String),
    /// Not a position on Earth.
    #[error("longitude {lon}, latitude {lat} is not a position on Earth in degrees")]
    NotOnEarth {
        /// Longitude, degrees.
        lon: f64,
        /// Latitude, degrees.
        lat: f64,
    },
    /// A position too far from the zone.
    #[error("longitude {lon}, latitude {lat} lies too far from {crs}")]
    OutsideZone {
        /// Longitude, degrees.
        lon: f64,
        /// Latitude, degrees.
        lat: f64,
        /// The zone.
        crs: String,
    },
}

/// A UTM zone on WGS 84.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Projection {
    zone: u8,
    south: bool,
}

impl Projection {
    /// The zone of a place in degrees, by sixths of longitude alone (without the exceptions of Norway and Svalbard).
    ///
    /// # Errors
    /// [`ProjectionError::NotOnEarth`], or [`ProjectionError::OutsideZone`] near the poles.
    pub fn utm_for(lon: f64, lat: f64) -> Result<Self, ProjectionError> {
        check_on_earth(lon, lat)?;
        let sixth = ((lon + 180.0) / 6.0).floor().clamp(0.0, 59.0);
        let projection = Self { zone: sixth as u8 + 1, south: lat < 0.0 };
        if !(MIN_LATITUDE..=MAX_LATITUDE).contains(&lat) {
            return Err(ProjectionError::OutsideZone { lon, lat, crs: projection.crs() });
        }
        Ok(projection)
    }

    /// The zone of an EPSG code such as `EPSG:32618`.
    ///
    /// # Errors
    /// [`ProjectionError::UnknownCrs`] for anything else.
    pub fn from_crs(crs: &str) -> Result<Self, ProjectionError> {
        let unknown = || ProjectionError::UnknownCrs(crs.to_owned());
        let code = crs.trim().to_ascii_uppercase();
        let code: u16 = code.strip_prefix("EPSG:").and_then(|code| code.trim().parse().ok()).ok_or_else(unknown)?;
        let (south, zone) = match code {
            32601..=32660 => (false, code - 32600),
            32701..=32760 => (true, code - 32700),
            _ => return Err(unknown()),
        };
        Ok(Self { zone: zone as u8, south })
    }

    /// Its EPSG code, e.g. `EPSG:32618`.
    pub fn crs(&self) -> String {
        format!("EPSG:{}", 32600 + u16::from(self.south) * 100 + u16::from(self.zone))
    }

    /// Easting and northing in metres of a place in degrees. Within 3 000 km of the central meridian this agrees with
    /// PROJ to a micrometre.
    ///
    /// # Errors
    /// [`ProjectionError::NotOnEarth`] and [`ProjectionError::OutsideZone`].
    pub fn project(&self, lon: f64, lat: f64) -> Result<Vec2, ProjectionError> {
        check_on_earth(lon, lat)?;
        let from_meridian = wrapped(lon - self.central_meridian());
        if from_meridian.abs() > MAX_FROM_MERIDIAN || !(MIN_LATITUDE..=MAX_LATITUDE).contains(&lat) {
            return Err(ProjectionError::OutsideZone { lon, lat, crs: self.crs() });
        }
        let (xi, eta) = gauss_schreiber(from_meridian.to_radians(), lat.to_radians());
        let (dxi, deta) = series(&ALPHA, xi, eta);
        Ok(self.false_origin() + Vec2::new(eta + deta, xi + dxi) * (SCALE * rectifying_radius()))
    }

    /// Longitude and latitude in degrees of easting and northing in metres: the inverse of [`Projection::project`].
    pub fn unproject(&self, at: Vec2) -> (f64, f64) {
        let plane = (at - self.false_origin()) / (SCALE * rectifying_radius());
        let (dxi, deta) = series(&BETA, plane.y, plane.x);
        let (xi, eta) = (plane.y - dxi, plane.x - deta);
        let (sin_xi, cos_xi, sinh_eta) = (libm::sin(xi), libm::cos(xi), libm::sinh(eta));
        let longitude = libm::atan2(sinh_eta, cos_xi);
        let conformal = sin_xi / (sinh_eta * sinh_eta + cos_xi * cos_xi).sqrt();
        let latitude = libm::atan(geodetic_tangent(conformal));
        (wrapped(longitude.to_degrees() + self.central_meridian()), latitude.to_degrees())
    }

    fn central_meridian(&self) -> f64 {
        f64::from(self.zone) * 6.0 - 183.0
    }

    fn false_origin(&self) -> Vec2 {
        Vec2::new(FALSE_EASTING, if self.south { FALSE_NORTHING } else { 0.0 })
    }
}

/// A local frame on Earth: metres east and north of a point of a UTM zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The zone.
    pub projection: Projection,
    /// Where (0, 0) lies in the zone.
    pub origin: Vec2,
}

impl Frame {
    /// The frame of a site; `None` when the site does not say where it lies.
    ///
    /// # Errors
    /// [`ProjectionError::UnknownCrs`] when it says so in a system that is not known.
    pub fn of_site(site: &Site) -> Result<Option<Self>, ProjectionError> {
        let (Some(crs), Some(origin)) = (&site.crs, site.origin) else { return Ok(None) };
        Ok(Some(Self { projection: Projection::from_crs(crs)?, origin }))
    }

    /// A frame for a place that has none: the zone of the middle of a box in degrees, with (0, 0) on the whole metre at
    /// the south-west of its corners.
    ///
    /// # Errors
    /// Those of [`Projection::project`] for the corners.
    pub fn around(min: Vec2, max: Vec2) -> Result<Self, ProjectionError> {
        let middle = (min + max) / 2.0;
        let projection = Projection::utm_for(middle.x, middle.y)?;
        let corners = [(min.x, min.y), (max.x, min.y), (min.x, max.y), (max.x, max.y)];
        let mut origin = Vec2::INFINITY;
        for (lon, lat) in corners {
            origin = origin.min(projection.project(lon, lat)?);
        }
        Ok(Self { projection, origin: origin.floor() })
    }

    /// Metres in this frame of a place in degrees.
    ///
    /// # Errors
    /// Those of [`Projection::project`].
    pub fn local(&self, lon: f64, lat: f64) -> Result<Vec2, ProjectionError> {
        Ok(self.projection.project(lon, lat)? - self.origin)
    }

    /// Longitude and latitude in degrees of a place of this frame.
    pub fn degrees(&self, local: Vec2) -> (f64, f64) {
        self.projection.unproject(local + self.origin)
    }
}

fn check_on_earth(lon: f64, lat: f64) -> Result<(), ProjectionError> {
    if (-180.0..=180.0).contains(&lon) && (-90.0..=90.0).contains(&lat) {
        return Ok(());
    }
    Err(ProjectionError::NotOnEarth { lon, lat })
}

/// Degrees between −180 and 180.
fn wrapped(degrees: f64) -> f64 {
    degrees - 360.0 * (degrees / 360.0).round()
}

/// First eccentricity.
fn eccentricity() -> f64 {
    (FLATTENING * (2.0 - FLATTENING)).sqrt()
}

/// Third flattening.
const N: f64 = FLATTENING / (2.0 - FLATTENING);

/// Radius of the circle as long as a meridian.
fn rectifying_radius() -> f64 {
    let n2 = N * N;
    RADIUS / (1.0 + N) * (1.0 + n2 * (1.0 / 4.0 + n2 * (1.0 / 64.0 + n2 / 256.0)))
}

/// Transverse Mercator of the conformal sphere: ξ northward, η eastward, both of radius 1.
fn gauss_schreiber(lon: f64, lat: f64) -> (f64, f64) {
    let tangent = conformal_tangent(libm::tan(lat));
    let (sin_lon, cos_lon) = (libm::sin(lon), libm::cos(lon));
    let xi = libm::atan2(tangent, cos_lon);
    let eta = libm::asinh(sin_lon / (tangent * tangent + cos_lon * cos_lon).sqrt());
    (xi, eta)
}

/// Tangent of the conformal latitude from that of the geodetic one (Karney eqs. 7–9).
fn conformal_tangent(tangent: f64) -> f64 {
    let e = eccentricity();
    let secant = (1.0 + tangent * tangent).sqrt();
    let sigma = libm::sinh(e * libm::atanh(e * tangent / secant));
    tangent * (1.0 + sigma * sigma).sqrt() - sigma * secant
}

/// Tangent of the geodetic latitude from that of the conformal one, by Newton's method (Karney eqs. 19–21).
fn geodetic_tangent(conformal: f64) -> f64 {
    let e2 = FLATTENING * (2.0 - FLATTENING);
    let mut tangent = conformal;
    // Two rounds reach the last bit for Earth; a fixed number keeps it the same everywhere.
    for _ in 0..5 {
        let reached = conformal_tangent(tangent);
        let steps = (1.0 + (1.0 - e2) * tangent * tangent)
            / ((1.0 - e2) * (1.0 + tangent * tangent).sqrt() * (1.0 + reached * reached).sqrt());
        tangent += (conformal - reached) * steps;
    }
    tangent
}

/// Σ cⱼ sin 2jξ cosh 2jη and Σ cⱼ cos 2jξ sinh 2jη.
fn series(coefficients: &[f64; ORDER], xi: f64, eta: f64) -> (f64, f64) {
    let mut sum = (0.0, 0.0);
    // The smallest terms first, so that they are not lost.
    for (j, c) in coefficients.iter().enumerate().rev() {
        let twice = 2.0 * (j + 1) as f64;
        sum.0 += c * libm::sin(twice * xi) * libm::cosh(twice * eta);
        sum.1 += c * libm::cos(twice * xi) * libm::sinh(twice * eta);
    }
    sum
}

/// c₁n + c₂n² + … from the power `first` on, by Horner's rule.
const fn powers(first: usize, terms: &[f64]) -> f64 {
    let mut sum = 0.0;
    let mut i = terms.len();
    while i > 0 {
        i -= 1;
        sum = sum * N + terms[i];
    }
    let mut power = 0;
    while power < first {
        sum *= N;
        power += 1;
    }
    sum
}

/// Karney eq. 35.
const ALPHA: [f64; ORDER] = [
    powers(1, &[1.0 / 2.0, -2.0 / 3.0, 5.0 / 16.0, 41.0 / 180.0, -127.0 / 288.0, 7891.0 / 37800.0]),
    powers(2, &[13.0 / 48.0, -3.0 / 5.0, 557.0 / 1440.0, 281.0 / 630.0, -1_983_433.0 / 1_935_360.0]),
    powers(3, &[61.0 / 240.0, -103.0 / 140.0, 15061.0 / 26880.0, 167_603.0 / 181_440.0]),
    powers(4, &[49561.0 / 161_280.0, -179.0 / 168.0, 6_601_661.0 / 7_257_600.0]),
    powers(5, &[34729.0 / 80640.0, -3_418_889.0 / 1_995_840.0]),
    powers(6, &[212_378_941.0 / 319_334_400.0]),
];

/// Karney eq. 36.
const BETA: [f64; ORDER] = [
    powers(1, &[1.0 / 2.0, -2.0 / 3.0, 37.0 / 96.0, -1.0 / 360.0, -81.0 / 512.0, 96199.0 / 604_800.0]),
    powers(2, &[1.0 / 48.0, 1.0 / 15.0, -437.0 / 1440.0, 46.0 / 105.0, -1_118_711.0 / 3_870_720.0]),
    powers(3, &[17.0 / 480.0, -37.0 / 840.0, -209.0 / 4480.0, 5569.0 / 90720.0]),
    powers(4, &[4397.0 / 161_280.0, -11.0 / 504.0, -830_251.0 / 7_257_600.0]),
    powers(5, &[4583.0 / 161_280.0, -108_847.0 / 3_991_680.0]),
    powers(6, &[20_648_693.0 / 638_668_800.0]),
];

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// (name, crs, lon, lat, east, north): `pyproj.Transformer.from_crs(4326, epsg)` of PROJ 9.
    const KNOWN: [(&str, &str, f64, f64, f64, f64); 11] = [
        ("Empire State Building", "EPSG:32618", -73.985656, 40.748433, 585_632.081342, 4_511_326.153664),
        ("Statue of Liberty", "EPSG:32618", -74.0445, 40.6892, 580_735.870703, 4_504_695.165219),
        ("Marble Hill", "EPSG:32618", -73.9106, 40.8777, 591_790.156575, 4_525_751.874010),
        ("Krems", "EPSG:32633", 15.6, 48.41, 544_401.421497, 5_362_045.537029),
        ("Krems, east", "EPSG:32633", 15.6142, 48.4092, 545_452.963424, 5_361_964.942525),
        ("San Francisco", "EPSG:32610", -122.4194, 37.7749, 551_130.768481, 4_180_998.881499),
        ("Daly City", "EPSG:32610", -122.5, 37.7, 544_077.034241, 4_172_647.858974),
        ("Porto Alegre", "EPSG:32722", -51.23, -30.0331, 477_824.367679, 6_677_524.613014),
        ("Viamao", "EPSG:32722", -51.1, -30.1, 490_364.913492, 6_670_129.536173),
        ("equator", "EPSG:32631", 3.0, 0.0, 500_000.0, 0.0),
        ("equator, rim of the zone", "EPSG:32631", 0.0, 0.0, 166_021.443081, 0.0),
    ];

    #[test]
    fn agrees_with_proj_to_a_micrometre() {
        for (name, crs, lon, lat, east, north) in KNOWN {
            let at = Projection::from_crs(crs).unwrap().project(lon, lat).unwrap();
            let error = (at - Vec2::new(east, north)).abs().max_element();
            assert!(error <= 2e-6, "{name}: {at} is {error} m from {east}, {north}");
        }
    }

    #[test]
    fn finds_the_zone_of_known_places() {
        for (name, crs, lon, lat, ..) in KNOWN.into_iter().filter(|place| place.2 != 0.0) {
            assert_eq!(Projection::utm_for(lon, lat).unwrap().crs(), crs, "{name}");
        }
        assert_eq!(Projection::utm_for(180.0, 10.0).unwrap().crs(), "EPSG:32660");
        assert_eq!(Projection::utm_for(-180.0, -10.0).unwrap().crs(), "EPSG:32701");
    }

    #[test]
    fn refuses_what_is_no_place_or_no_zone() {
        for (lon, lat) in [(f64::NAN, 0.0), (0.0, f64::NAN), (181.0, 0.0), (0.0, -90.5), (f64::INFINITY, 0.0)] {
            assert!(matches!(Projection::utm_for(lon, lat), Err(ProjectionError::NotOnEarth { .. })));
        }
        assert!(matches!(Projection::utm_for(0.0, 85.0), Err(ProjectionError::OutsideZone { .. })));
        let manhattan = Projection::from_crs("EPSG:32618").unwrap();
        assert!(matches!(manhattan.project(15.6, 48.4), Err(ProjectionError::OutsideZone { .. })));
        for crs in ["EPSG:4326", "EPSG:32600", "EPSG:32661", "EPSG:32761", "32618", "EPSG:", ""] {
            assert_eq!(Projection::from_crs(crs), Err(ProjectionError::UnknownCrs(crs.to_owned())));
        }
        assert_eq!(Projection::from_crs(" epsg:32618").unwrap(), manhattan);
    }

    #[test]
    fn a_frame_around_a_box_holds_it() {
        let frame = Frame::around(Vec2::new(15.59, 48.38), Vec2::new(15.68, 48.42)).unwrap();
        assert_eq!(frame.projection.crs(), "EPSG:32633");
        assert_eq!(frame.origin, frame.origin.floor());
        for (lon, lat) in [(15.59, 48.38), (15.68, 48.38), (15.59, 48.42), (15.68, 48.42)] {
            let local = frame.local(lon, lat).unwrap();
            assert!(local.min_element() >= 0.0 && local.max_element() < 7000.0, "{local}");
        }
    }

    /// A second implementation: proj4rs.
    fn by_proj4rs(zone: u8, south: bool, lon: f64, lat: f64) -> Vec2 {
        let south = if south { " +south" } else { "" };
        let to =
            proj4rs::Proj::from_proj_string(&format!("+proj=utm +zone={zone}{south} +datum=WGS84 +units=m +no_defs"));
        let from = proj4rs::Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs").unwrap();
        let mut at = (lon.to_radians(), lat.to_radians());
        proj4rs::transform::transform(&from, &to.unwrap(), &mut at).unwrap();
        Vec2::new(at.0, at.1)
    }

    proptest! {
        #[test]
        fn agrees_with_proj4rs(zone in 1u8..=60, offset in -6.0..6.0f64, lat in -79.0..83.0f64) {
            let projection = Projection { zone, south: lat < 0.0 };
            let lon = wrapped(projection.central_meridian() + offset);
            let ours = projection.project(lon, lat).unwrap();
            prop_assert!((ours - by_proj4rs(zone, lat < 0.0, lon, lat)).length() < 1e-5);
        }

        #[test]
        fn there_and_back(zone in 1u8..=60, offset in -6.0..6.0f64, lat in -79.9..83.9f64) {
            let projection = Projection { zone, south: lat < 0.0 };
            let lon = wrapped(projection.central_meridian() + offset);
            let (lon_again, lat_again) = projection.unproject(projection.project(lon, lat).unwrap());
            // 1e-11 degrees is about a micrometre.
            prop_assert!(wrapped(lon_again - lon).abs() < 2e-11 / libm::cos(lat.to_radians()).max(0.1) && (lat_again - lat).abs() < 1e-11);
        }
    }
}

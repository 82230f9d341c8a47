use crate::Cache;
use crate::Site;
use crate::sources::{DistrictMap, Legend, MapOptions, SourceError, load_site_with};
use geom::Vec2;
use image::{DynamicImage, RgbImage, Rgba, RgbaImage};
use std::collections::BTreeMap;
use std::fs;
use tempfile::TempDir;

const RED: [u8; 3] = [0xc0, 0x39, 0x2b];
const BLUE: [u8; 3] = [0x29, 0x80, 0xb9];
const WHITE: [u8; 3] = [255; 3];

/// A folder with a map `districts`, row by row from the north, pixels of 10 m.
fn folder(width: u32, pixels: &[[u8; 3]], sidecar: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let bytes = pixels.concat();
    let picture = RgbImage::from_raw(width, pixels.len() as u32 / width, bytes).unwrap();
    picture.save(folder.path().join("districts.png")).unwrap();
    fs::write(folder.path().join("districts.json"), sidecar).unwrap();
    folder
}

fn legend(named: &[(&str, [u8; 3])]) -> Legend {
    named.iter().map(|(name, colour)| ((*name).to_owned(), *colour)).collect()
}

fn read(folder: &TempDir, legend: Legend) -> Result<Site, SourceError> {
    let map = DistrictMap { map: "districts".into(), legend };
    load_site_with(folder.path(), &[], &BTreeMap::<String, MapOptions>::new(), Some(&map), &Cache::none())
}

fn message(result: Result<Site, SourceError>) -> String {
    let error = result.unwrap_err();
    format!("{error} | {}", error.hint())
}

const PLAIN: &str = r#"{"pixel_size_m": 10}"#;

#[test]
fn each_colour_is_a_district() {
    let folder = folder(2, &[RED, BLUE, RED, WHITE], PLAIN);
    let site = read(&folder, legend(&[("old town", RED), ("harbour", BLUE), ("none", WHITE)])).unwrap();
    let at = |x, y| site.districts.name_at(Vec2::new(x, y)).to_owned();
    assert_eq!([at(5.0, 15.0), at(15.0, 15.0), at(5.0, 5.0), at(15.0, 5.0)], ["old town", "harbour", "old town", ""]);
    assert_eq!(site.districts.names(), ["harbour", "old town"]);
    let areas: Vec<_> = site.districts.areas().into_iter().map(|area| (area.name, area.polygon.area())).collect();
    assert_eq!(areas, [("harbour".to_owned(), 100.0), ("old town".to_owned(), 200.0)]);
    assert_eq!(site.bounds.size(), Vec2::splat(20.0));
}

#[test]
fn the_legend_may_stand_in_the_sidecar() {
    let sidecar = r##"{"pixel_size_m": 10, "legend": {"a": "#c0392b", "b": "#2980B9"}}"##;
    let site = read(&folder(2, &[RED, BLUE], sidecar), Legend::new()).unwrap();
    assert_eq!(site.districts.name_at(Vec2::new(15.0, 5.0)), "b");
    for (sidecar, wrong) in [
        (PLAIN, "has no legend"),
        (r#"{"pixel_size_m": 10, "legend": {"a": "red"}}"#, "legend.a is red: a colour is written #rrggbb"),
        (r##"{"pixel_size_m": 10, "legend": {"a": "#c0392b", "b": "#c0392b"}}"##, "`a` has the same colour"),
        (r#"{"pixel_size_m": 10, "legend": ["a"]}"#, "`legend` must be names with colours"),
    ] {
        let error = message(read(&folder(2, &[RED, BLUE], sidecar), Legend::new()));
        assert!(error.contains(wrong), "{error}");
    }
}

#[test]
fn colours_without_a_name_are_told_with_their_share() {
    let folder = folder(4, &[RED, RED, BLUE, WHITE], PLAIN);
    let error = message(read(&folder, legend(&[("a", RED)])));
    assert!(error.contains("does not name: #2980b9 (25.00 %), #ffffff (25.00 %)"), "{error}");
    assert!(error.contains("without anti-aliasing"), "{error}");
    let error = message(read(&folder, legend(&[("a", RED), ("b", BLUE), ("c", WHITE), ("d", [1, 2, 3])])));
    assert!(error.contains("no pixel of `d`, #010203"), "{error}");
    assert!(error.contains("#c0392b (50.00 %), #2980b9 (25.00 %), #ffffff (25.00 %)"), "{error}");
}

#[test]
fn transparent_pixels_belong_to_no_district() {
    let folder = folder(2, &[RED, RED], PLAIN);
    let mut picture = RgbaImage::from_pixel(2, 1, Rgba([RED[0], RED[1], RED[2], 255]));
    picture.put_pixel(1, 0, Rgba([9, 9, 9, 0]));
    DynamicImage::from(picture).save(folder.path().join("districts.png")).unwrap();
    let site = read(&folder, legend(&[("a", RED)])).unwrap();
    assert_eq!([5.0, 15.0].map(|x| site.districts.name_at(Vec2::new(x, 5.0)).to_owned()), ["a", ""]);
}

#[test]
fn districts_cover_the_same_ground_as_other_maps() {
    let folder = folder(2, &[RED, RED], PLAIN);
    image::GrayImage::new(2, 1).save(folder.path().join("land.png")).unwrap();
    fs::write(folder.path().join("land.json"), r#"{"pixel_size_m": 11}"#).unwrap();
    let error = message(read(&folder, legend(&[("a", RED)])));
    assert!(error.contains("do not cover the same rectangle"), "{error}");
}

#[test]
fn files_that_are_none_are_told() {
    let folder = folder(2, &[RED, RED], PLAIN);
    let map = DistrictMap { map: "distrikts".into(), legend: Legend::new() };
    let error = message(load_site_with(folder.path(), &[], &BTreeMap::new(), Some(&map), &Cache::none()));
    assert!(error.contains("no map `distrikts`") && error.contains("did you mean `districts`?"), "{error}");
    fs::write(folder.path().join("districts.png"), "no picture").unwrap();
    assert!(message(read(&folder, legend(&[("a", RED)]))).contains("is not a readable PNG"));
    fs::remove_file(folder.path().join("districts.json")).unwrap();
    assert!(message(read(&folder, legend(&[("a", RED)]))).contains("has no sidecar"));
}

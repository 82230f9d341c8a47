//! OpenStreetMap PBF (`.osm.pbf`): blobs of compressed protocol buffers.

use super::error::SourceError;
use super::imported::Tags;
use super::osm::OsmData;
use geom::Vec2;
use osmpbf::{Blob, BlobReader, BlobType, HeaderBlock, PrimitiveBlock, Way};
use rustc_hash::FxHashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Features of the format that are understood.
const FEATURES: [&str; 2] = ["OsmSchema-V0.6", "DenseNodes"];

const HINT: &str = "fetch or export the file again as OpenStreetMap PBF (.osm.pbf)";

/// Reads the ways that are streets, then the nodes they refer to: nodes come first in a file, and most are not needed.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<OsmData, SourceError> {
    let file = File { path, blobs: blobs_of(path, bytes)? };
    let mut data = OsmData::default();
    file.read_header(&mut data)?;
    let mut needed = FxHashSet::default();
    file.each_block(|block| read_ways(block, &mut data, &mut needed))?;
    file.each_block(|block| {
        read_nodes(block, &mut data, &needed);
        Ok(())
    })?;
    Ok(data)
}

/// A file cut into its blobs.
struct File<'a> {
    path: &'a Path,
    /// With the byte each starts at.
    blobs: Vec<(u64, Blob)>,
}

impl File<'_> {
    fn read_header(&self, data: &mut OsmData) -> Result<(), SourceError> {
        let header = match self.blobs.first() {
            Some((at, blob)) if blob.get_type() == BlobType::OsmHeader => self.decode(*at, || blob.to_headerblock())?,
            _ => {
                return Err(SourceError::kind(
                    self.path,
                    "is not an OpenStreetMap file: it has no header",
                    HINT.to_owned(),
                ));
            }
        };
        self.check_features(&header)?;
        if let Some(bbox) = header.bbox() {
            data.set_bounds(Vec2::new(bbox.left, bbox.bottom), Vec2::new(bbox.right, bbox.top));
        }
        Ok(())
    }

    fn check_features(&self, header: &HeaderBlock) -> Result<(), SourceError> {
        match header.required_features().iter().find(|feature| !FEATURES.contains(&feature.as_str())) {
            None => Ok(()),
            Some(feature) => {
                let hint = "convert it to a plain extract: `osmium cat in.osm.pbf -o out.osm.pbf`";
                Err(SourceError::kind(
                    self.path,
                    format!("needs the feature {feature}, which is not known"),
                    hint.to_owned(),
                ))
            }
        }
    }

    /// Calls `read` with every block of data.
    fn each_block(&self, mut read: impl FnMut(&PrimitiveBlock) -> Result<(), String>) -> Result<(), SourceError> {
        for (at, blob) in self.blobs.iter().filter(|(_, blob)| blob.get_type() == BlobType::OsmData) {
            let block = self.decode(*at, || blob.to_primitiveblock())?;
            self.guarded(*at, || read(&block))?;
        }
        Ok(())
    }

    fn decode<T>(&self, at: u64, decode: impl FnOnce() -> osmpbf::Result<T>) -> Result<T, SourceError> {
        self.guarded(at, || decode().map_err(|e| e.to_string()))
    }

    /// Numbers of a damaged block can overflow inside the decoder, which a build with overflow checks turns into a panic.
    fn guarded<T>(&self, at: u64, work: impl FnOnce() -> Result<T, String>) -> Result<T, SourceError> {
        catch_unwind(AssertUnwindSafe(work))
            .unwrap_or_else(|_| Err("numbers in this block make no sense".to_owned()))
            .map_err(|message| SourceError::damaged(self.path, at, message))
    }
}

/// Cuts a file into blobs, and sees that it ends where the last one does.
fn blobs_of(path: &Path, bytes: &[u8]) -> Result<Vec<(u64, Blob)>, SourceError> {
    let (mut blobs, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let (blob, size) = first_blob(&bytes[at..]).map_err(|message| match at {
            0 => SourceError::kind(path, format!("is not an OpenStreetMap file: {message}"), HINT.to_owned()),
            _ => SourceError::damaged(path, at as u64, message),
        })?;
        blobs.push((at as u64, blob));
        at += size;
    }
    Ok(blobs)
}

/// The blob at the start of some bytes, and how many of them it takes.
fn first_blob(bytes: &[u8]) -> Result<(Blob, usize), String> {
    let cut_off = || "the file is cut off".to_owned();
    let header_size = bytes.first_chunk::<4>().map(|size| u32::from_be_bytes(*size)).ok_or_else(cut_off)?;
    let (header, _) = BlobReader::new_seekable(Cursor::new(bytes))
        .map_err(|e| e.to_string())?
        .next_header_skip_blob()
        .ok_or_else(cut_off)?
        .map_err(|e| e.to_string())?;
    let content_size = usize::try_from(header.get_blob_size()).map_err(|_| "a block of negative size".to_owned())?;
    // The header was read, so its size is small.
    let size = 4 + header_size as usize + content_size;
    let whole = bytes.get(..size).ok_or_else(cut_off)?;
    let blob = BlobReader::new(whole).next().ok_or_else(cut_off)?.map_err(|e| e.to_string())?;
    Ok((blob, size))
}

fn read_ways(block: &PrimitiveBlock, data: &mut OsmData, needed: &mut FxHashSet<i64>) -> Result<(), String> {
    for way in block.groups().flat_map(|group| group.ways()) {
        let tags = tags_of(block, &way)?;
        let before = data.ways.len();
        data.way(way.id(), &tags, refs_of(&way));
        if data.ways.len() > before {
            needed.extend(refs_of(&way));
        }
    }
    Ok(())
}

fn tags_of(block: &PrimitiveBlock, way: &Way) -> Result<Tags, String> {
    let strings = block.raw_stringtable();
    let text = |index: u32| {
        let bytes = strings.get(index as usize).ok_or("a tag refers to a text that is not there")?;
        std::str::from_utf8(bytes).map_err(|_| "a tag is not UTF-8 text")
    };
    let mut tags = Tags::default();
    for (key, value) in way.raw_tags() {
        tags.push(text(key)?, text(value)?);
    }
    Ok(tags)
}

/// Node ids, which are stored as differences.
fn refs_of(way: &Way) -> Vec<i64> {
    let add = |sum: &mut i64, &difference: &i64| {
        *sum = sum.wrapping_add(difference);
        Some(*sum)
    };
    way.raw_refs().iter().scan(0i64, add).collect()
}

fn read_nodes(block: &PrimitiveBlock, data: &mut OsmData, needed: &FxHashSet<i64>) {
    for group in block.groups() {
        let dense = group.dense_nodes().map(|node| (node.id(), Vec2::new(node.lon(), node.lat())));
        let plain = group.nodes().map(|node| (node.id(), Vec2::new(node.lon(), node.lat())));
        data.nodes.extend(dense.chain(plain).filter(|(id, _)| needed.contains(id)));
    }
}

#[cfg(test)]
mod tests {
    use crate::sources::{ImportedStreet, SourceError, StreetFile, parse_osm_pbf, read_osm};
    use proptest::prelude::*;
    use std::path::{Path, PathBuf};

    fn krems() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/krems/krems.osm.pbf")
    }

    fn parse(bytes: &[u8]) -> Result<StreetFile, SourceError> {
        parse_osm_pbf(Path::new("town.osm.pbf"), bytes, None)
    }

    /// A protocol buffer being written.
    #[derive(Clone, Default)]
    struct Message(Vec<u8>);

    impl Message {
        fn varint(&mut self, mut value: u64) {
            while value >= 0x80 {
                self.0.push(value as u8 | 0x80);
                value >>= 7;
            }
            self.0.push(value as u8);
        }

        fn number(mut self, field: u64, value: u64) -> Self {
            self.varint(field << 3);
            self.varint(value);
            self
        }

        fn bytes(mut self, field: u64, bytes: &[u8]) -> Self {
            self.varint(field << 3 | 2);
            self.varint(bytes.len() as u64);
            self.0.extend_from_slice(bytes);
            self
        }

        fn packed(self, field: u64, values: impl IntoIterator<Item = u64>) -> Self {
            let mut packed = Self::default();
            values.into_iter().for_each(|value| packed.varint(value));
            self.bytes(field, &packed.0)
        }
    }

    fn zigzag(value: i64) -> u64 {
        ((value << 1) ^ (value >> 63)) as u64
    }

    fn deltas(values: &[i64]) -> Vec<u64> {
        let before = std::iter::once(0).chain(values.iter().copied());
        values.iter().zip(before).map(|(value, before)| zigzag(value.wrapping_sub(before))).collect()
    }

    fn blob(kind: &str, content: &Message) -> Vec<u8> {
        let blob = Message::default().bytes(1, &content.0).0;
        let header = Message::default().bytes(1, kind.as_bytes()).number(3, blob.len() as u64).0;
        [&(header.len() as u32).to_be_bytes()[..], &header, &blob].concat()
    }

    const STRINGS: [&str; 6] = ["", "highway", "residential", "name", "Main", "tunnel"];

    /// Four dense nodes and two ways; `ids` and `tags` may be nonsense.
    fn town(features: &[&str], ids: &[i64], tags: [u64; 2]) -> Vec<u8> {
        let mut header = Message::default();
        for feature in features {
            header = header.bytes(4, feature.as_bytes());
        }
        let dense = Message::default()
            .packed(1, deltas(ids))
            .packed(8, deltas(&[484_100_000, 484_100_000, 484_120_000, 484_140_000]))
            .packed(9, deltas(&[156_000_000, 156_020_000, 156_020_000, 156_020_000]));
        let way = |id: u64, tags: [u64; 2], refs: &[i64]| {
            Message::default().number(1, id).packed(2, [tags[0], 3]).packed(3, [tags[1], 4]).packed(8, deltas(refs))
        };
        let group = Message::default()
            .bytes(2, &dense.0)
            .bytes(3, &way(30, tags, &[10, 11, 12]).0)
            .bytes(3, &way(31, [1, 2], &[12, 77, 12, 13]).0);
        let mut strings = Message::default();
        for text in STRINGS {
            strings = strings.bytes(1, text.as_bytes());
        }
        let block = Message::default().bytes(1, &strings.0).bytes(2, &group.0);
        [blob("OSMHeader", &header), blob("OSMData", &block)].concat()
    }

    const KNOWN: [&str; 2] = ["OsmSchema-V0.6", "DenseNodes"];
    const IDS: [i64; 4] = [10, 11, 12, 13];

    #[test]
    fn a_town_is_read() {
        let file = parse(&town(&KNOWN, &IDS, [1, 2])).unwrap();
        let got: Vec<_> = file.streets.iter().map(|s| (s.key.as_str(), s.refs.as_slice(), s.name.as_deref())).collect();
        assert_eq!(got, [("30", &[10, 11, 12][..], Some("Main")), ("31", &[12, 13][..], Some("Main"))]);
        // By PROJ.
        for (street, length) in file.streets.iter().zip([370.3217, 222.3131]) {
            assert!((street.length() - length).abs() < 0.003, "{}", street.length());
        }
        assert_eq!(file.streets[0].points[2], file.streets[1].points[0]);
    }

    #[test]
    fn nonsense_in_a_block_is_told_with_its_place() {
        let whole = town(&KNOWN, &IDS, [1, 2]);
        let first = town(&KNOWN, &IDS, [1, 2]).windows(7).position(|bytes| bytes == b"OSMData").unwrap() - 6;
        let error = parse(&town(&KNOWN, &IDS, [1, 99])).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("town.osm.pbf: damaged at byte {first}: a tag refers to a text that is not there")
        );
        // Differences that overflow: an error with overflow checks, else ids that no way has.
        assert!(parse(&town(&KNOWN, &[i64::MIN, i64::MAX, i64::MIN, i64::MAX], [1, 2])).is_err());
        let error = parse(&town(&["HistoricalInformation"], &IDS, [1, 2])).unwrap_err();
        assert!(error.to_string().contains("needs the feature HistoricalInformation"), "{error}");
        assert!(parse(&whole[first..]).unwrap_err().to_string().contains("it has no header"));
    }

    #[test]
    fn what_is_no_pbf_is_said_to_be_none() {
        for bytes in [&b""[..], b"\0", b"hello, this is no map at all", &[0xff; 64], &[0; 64]] {
            let error = parse(bytes).unwrap_err();
            assert!(error.to_string().contains("not an OpenStreetMap file"), "{error}");
        }
    }

    #[test]
    fn a_cut_off_file_is_an_error_wherever_it_is_cut() {
        let whole = town(&KNOWN, &IDS, [1, 2]);
        for length in 0..whole.len() {
            assert!(parse(&whole[..length]).is_err(), "cut at {length} of {}", whole.len());
        }
    }

    #[test]
    fn krems_has_its_streets() {
        let file = read_osm(&krems(), None).unwrap();
        let length: f64 = file.streets.iter().map(ImportedStreet::length).sum();
        assert_eq!((file.streets.len(), file.left_out.values().sum::<usize>()), (378, 460));
        assert!((length - 94_870.0).abs() < 10.0, "{length}");
        assert_eq!(file.frame.unwrap().projection.crs(), "EPSG:32633");
        // 0.0716 by 0.0268 degrees.
        let size = file.bounds.size();
        assert!((size.x - 5330.0).abs() < 60.0 && (size.y - 3030.0).abs() < 60.0, "{size}");
        assert!(file.streets.iter().any(|street| street.level > 0));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn a_damaged_file_never_panics(at in 0.0..1.0f64, bit in 0u8..8, cut in 0.0..1.0f64) {
            let mut bytes = std::fs::read(krems()).unwrap();
            let length = bytes.len() as f64;
            let cut_off = parse(&bytes[..(cut * length) as usize]);
            prop_assert!(cut_off.is_err());
            bytes[(at * length) as usize] ^= 1 << bit;
            let _ = parse(&bytes);
        }

        #[test]
        fn a_damaged_town_never_panics(at in 0.0..1.0f64, byte: u8) {
            let mut bytes = town(&KNOWN, &IDS, [1, 2]);
            let at = (at * bytes.len() as f64) as usize;
            bytes[at] = byte;
            let _ = parse(&bytes);
        }
    }
}

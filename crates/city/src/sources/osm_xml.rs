//! OpenStreetMap XML (`.osm`), API version 0.6.

use super::error::SourceError;
use super::imported::Tags;
use super::osm::OsmData;
use geom::Vec2;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::path::Path;
use std::str::FromStr;

const HINT: &str = "fetch or export the file again as OpenStreetMap XML (.osm)";

/// Reads the ways that are streets, and all nodes.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<OsmData, SourceError> {
    let mut reader = Reader::from_reader(bytes);
    let mut document = Document { path, bytes, at: 0, open: 0, data: OsmData::default(), way: None };
    loop {
        document.at = reader.buffer_position();
        let event = reader.read_event().map_err(|e| document.wrong(reader.error_position(), &e.to_string()))?;
        match event {
            Event::Start(element) => {
                document.start(&element)?;
                document.open += 1;
            }
            Event::Empty(element) => {
                document.start(&element)?;
                document.end(element.name().as_ref());
            }
            Event::End(element) => {
                document.open -= 1;
                document.end(element.name().as_ref());
            }
            Event::Eof => break,
            _ => {}
        }
    }
    document.finish()
}

/// A document while it is read.
struct Document<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// Where the current element starts.
    at: u64,
    /// Elements that are open.
    open: usize,
    data: OsmData,
    way: Option<OpenWay>,
}

/// The way whose children are being read.
struct OpenWay {
    id: i64,
    deleted: bool,
    tags: Tags,
    refs: Vec<i64>,
}

impl Document<'_> {
    fn start(&mut self, element: &BytesStart) -> Result<(), SourceError> {
        let name = element.name();
        if self.open == 0 && name.as_ref() != b"osm" {
            let found = String::from_utf8_lossy(name.as_ref()).into_owned();
            return Err(SourceError::kind(self.path, format!("is XML of kind <{found}>, not <osm>"), HINT.to_owned()));
        }
        match name.as_ref() {
            b"node" => self.node(element),
            b"way" => self.open_way(element),
            b"nd" => self.reference(element),
            b"tag" => self.tag(element),
            b"bounds" => self.bounds(element),
            _ => Ok(()),
        }
    }

    fn end(&mut self, name: &[u8]) {
        if name == b"way"
            && let Some(way) = self.way.take()
            && !way.deleted
        {
            self.data.way(way.id, &way.tags, way.refs);
        }
    }

    fn finish(self) -> Result<OsmData, SourceError> {
        let end = self.bytes.len() as u64;
        if self.open > 0 {
            return Err(self.wrong(end, "the file ends before its last element does: it is cut off"));
        }
        Ok(self.data)
    }

    fn node(&mut self, element: &BytesStart) -> Result<(), SourceError> {
        if self.is_deleted(element)? {
            return Ok(());
        }
        let id = self.number(element, "id")?;
        let at = Vec2::new(self.number(element, "lon")?, self.number(element, "lat")?);
        self.data.nodes.insert(id, at);
        Ok(())
    }

    fn open_way(&mut self, element: &BytesStart) -> Result<(), SourceError> {
        let (id, deleted) = (self.number(element, "id")?, self.is_deleted(element)?);
        self.way = Some(OpenWay { id, deleted, tags: Tags::default(), refs: Vec::new() });
        Ok(())
    }

    fn reference(&mut self, element: &BytesStart) -> Result<(), SourceError> {
        if self.way.is_some() {
            let id = self.number(element, "ref")?;
            self.way.iter_mut().for_each(|way| way.refs.push(id));
        }
        Ok(())
    }

    fn tag(&mut self, element: &BytesStart) -> Result<(), SourceError> {
        if self.way.is_some() {
            let (key, value) = (self.required(element, "k")?, self.required(element, "v")?);
            self.way.iter_mut().for_each(|way| way.tags.push(&key, &value));
        }
        Ok(())
    }

    fn bounds(&mut self, element: &BytesStart) -> Result<(), SourceError> {
        let min = Vec2::new(self.number(element, "minlon")?, self.number(element, "minlat")?);
        let max = Vec2::new(self.number(element, "maxlon")?, self.number(element, "maxlat")?);
        self.data.set_bounds(min, max);
        Ok(())
    }

    /// Deleted in a history, or marked for deletion by an editor.
    fn is_deleted(&self, element: &BytesStart) -> Result<bool, SourceError> {
        let is = |name: &str, value: &str| Ok(self.attribute(element, name)?.as_deref() == Some(value));
        Ok(is("visible", "false")? || is("action", "delete")?)
    }

    fn number<T: FromStr>(&self, element: &BytesStart, name: &str) -> Result<T, SourceError> {
        let text = self.required(element, name)?;
        text.trim().parse().map_err(|_| self.wrong(self.at, &format!("attribute {name}=\"{text}\" is not a number")))
    }

    fn required(&self, element: &BytesStart, name: &str) -> Result<String, SourceError> {
        self.attribute(element, name)?.ok_or_else(|| {
            let element = String::from_utf8_lossy(element.name().as_ref()).into_owned();
            self.wrong(self.at, &format!("<{element}> has no attribute {name}"))
        })
    }

    fn attribute(&self, element: &BytesStart, name: &str) -> Result<Option<String>, SourceError> {
        let wrong = |message: String| self.wrong(self.at, &message);
        let Some(attribute) = element.try_get_attribute(name).map_err(|e| wrong(e.to_string()))? else {
            return Ok(None);
        };
        let value = attribute.decode_and_unescape_value(element.decoder()).map_err(|e| wrong(e.to_string()))?;
        Ok(Some(value.into_owned()))
    }

    /// An error at a byte of the file, given as line and column.
    fn wrong(&self, at: u64, message: &str) -> SourceError {
        let before = &self.bytes[..self.bytes.len().min(at as usize)];
        let line_start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |i| i + 1);
        SourceError::Syntax {
            path: self.path.to_owned(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
            column: 1 + before.len() - line_start,
            message: message.to_owned(),
            hint: HINT.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::sources::{Frame, SourceError, StreetFile, parse_osm_xml};
    use std::path::Path;

    const TOWN: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6">
  <bounds minlat="48.40" minlon="15.59" maxlat="48.42" maxlon="15.63"/>
  <node id="1" lat="48.410" lon="15.600"><tag k="highway" v="crossing"/></node>
  <node id="2" lat="48.410" lon="15.602"/>
  <node id="3" lat="48.412" lon="15.602"/>
  <node id="4" lat="48.414" lon="15.602"/>
  <node id="5" lat="48.410" lon="15.602" visible="false"/>
  <way id="30"><nd ref="1"/><nd ref="2"/><nd ref="2"/><nd ref="3"/>
    <tag k="highway" v="residential"/><tag k="name" v="Untere &amp; Obere Stra&#223;e"/></way>
  <way id="4"><nd ref="1"/><nd ref="2"/><nd ref="99"/><nd ref="3"/><nd ref="98"/><nd ref="3"/><nd ref="4"/>
    <tag k="highway" v="primary"/><tag k="bridge" v="yes"/><tag k="layer" v="2"/><tag k="lanes" v="2"/></way>
  <way id="5"><nd ref="1"/><nd ref="2"/><tag k="highway" v="service"/></way>
  <way id="6"><nd ref="1"/><nd ref="2"/><tag k="highway" v="pedestrian"/><tag k="area" v="yes"/></way>
  <way id="7"><nd ref="1"/><nd ref="2"/><tag k="building" v="yes"/></way>
  <way id="8" action="delete"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/></way>
  <way id="9"><nd ref="1"/><nd ref="99"/><tag k="highway" v="residential"/></way>
  <way id="10"/>
  <relation id="1"><member type="way" ref="30" role=""/><tag k="highway" v="residential"/></relation>
</osm>
"#;

    fn parse(text: impl AsRef<[u8]>) -> Result<StreetFile, SourceError> {
        parse_osm_xml(Path::new("town.osm"), text.as_ref(), None)
    }

    #[test]
    fn a_town_is_read() {
        let file = parse(TOWN).unwrap();
        let got: Vec<_> =
            file.streets.iter().map(|s| (s.key.as_str(), s.refs.as_slice(), s.level, s.class.as_str())).collect();
        assert_eq!(
            got,
            [("30", &[1, 2, 3][..], 0, "minor"), ("4", &[1, 2][..], 2, "major"), ("4/1", &[3, 4][..], 2, "major"),]
        );
        assert_eq!(file.streets[0].name.as_deref(), Some("Untere & Obere Straße"));
        assert_eq!((file.streets[0].width, file.streets[1].width), (Some(14.0), Some(13.5)));
        // Ways meet in their common node: exactly.
        assert_eq!(file.streets[0].points[1], file.streets[1].points[1]);
        let left_out: Vec<_> = file.left_out.iter().map(|(why, n)| (why.as_str(), *n)).collect();
        assert_eq!(left_out, [("area=yes", 1), ("fewer than two nodes in the file", 1), ("highway=service", 1)]);
    }

    #[test]
    fn the_stated_bounds_are_the_bounds() {
        let file = parse(TOWN).unwrap();
        let frame = file.frame.unwrap();
        let south_west = frame.local(15.59, 48.40).unwrap();
        assert!(south_west.min_element() >= 0.0 && south_west.max_element() < 40.0, "{south_west}");
        assert!((file.bounds.size().y - 2224.0).abs() < 40.0, "{}", file.bounds.size());
        let same: Frame = frame;
        assert_eq!(parse_osm_xml(Path::new("town.osm"), TOWN.as_bytes(), Some(same)).unwrap(), file);
    }

    #[test]
    fn wrong_files_are_refused_with_the_line() {
        for (from, to, wrong) in [
            (
                "lat=\"48.410\" lon=\"15.602\"/>",
                "lat=\"48.41O\" lon=\"15.602\"/>",
                "town.osm:5:3: attribute lat=\"48.41O\" is not a number",
            ),
            ("<node id=\"3\"", "<node", "town.osm:6:3: <node> has no attribute id"),
            ("<nd ref=\"2\"/><nd ref=\"2\"/>", "<nd ref=\"2\"/><nd/>", "town.osm:9:42: <nd> has no attribute ref"),
            ("</way>\n  <way id=\"4\">", "</wey>\n  <way id=\"4\">", "town.osm:10:"),
            ("&amp;", "&nonsense;", "town.osm:10:"),
            ("lat=\"48.412\"", "lat=\"148.412\"", "way 30, position 4: longitude 15.602, latitude 148.412"),
            ("lat=\"48.412\"", "lat=\"NaN\"", "way 30, position 4"),
            ("<osm version=\"0.6\">", "<osmChange version=\"0.6\">", "is XML of kind <osmChange>, not <osm>"),
            ("</osm>", "", "the file ends before its last element does"),
        ] {
            let text = TOWN.replacen(from, to, 1);
            assert_ne!(text, TOWN, "{from}");
            let error = parse(&text).unwrap_err();
            assert!(error.to_string().contains(wrong), "{from}: {error}");
            assert!(!error.hint().is_empty());
        }
        let error = parse("<osm version=\"0.6\"/>").unwrap_err();
        assert!(error.to_string().contains("has no street in it"), "{error}");
    }

    #[test]
    fn a_cut_off_file_is_an_error_wherever_it_is_cut() {
        for length in 0..TOWN.trim_end().len() {
            assert!(parse(&TOWN.as_bytes()[..length]).is_err(), "cut at {length}");
        }
    }

    #[test]
    fn a_damaged_file_never_panics() {
        for at in 0..TOWN.len() {
            for bit in 0..8 {
                let mut bytes = TOWN.as_bytes().to_vec();
                bytes[at] ^= 1 << bit;
                let _ = parse(&bytes);
            }
        }
    }
}

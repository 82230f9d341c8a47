//! Street classes: data, not a fixed list.

use serde::{Deserialize, Serialize};

/// A street class: an index into [`Classes`]; smaller is more important.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Class(pub u8);

/// What a class is called and does.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClassInfo {
    /// The name written to files, e.g. `major`.
    pub name: String,
    /// Whether streets of this class close quarters (LSWW11 §3.1).
    pub closes_quarters: bool,
}

/// The classes of one city, most important first.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes(Vec<ClassInfo>);

impl Classes {
    /// Highways that close quarters.
    pub const HIGHWAY: Class = Class(0);
    /// Majors that close quarters.
    pub const MAJOR: Class = Class(1);
    /// Minors, which fill quarters.
    pub const MINOR: Class = Class(2);

    /// The classes in order of importance; at most 255.
    pub fn new(classes: Vec<ClassInfo>) -> Self {
        assert!(classes.len() < 256, "a class is one byte");
        Self(classes)
    }

    /// What the class is called and does.
    pub fn info(&self, class: Class) -> &ClassInfo {
        &self.0[usize::from(class.0)]
    }

    /// The class of that name.
    pub fn named(&self, name: &str) -> Option<Class> {
        self.0.iter().position(|info| info.name == name).map(|i| Class(i as u8))
    }

    /// All classes, most important first.
    pub fn iter(&self) -> impl Iterator<Item = (Class, &ClassInfo)> {
        self.0.iter().enumerate().map(|(i, info)| (Class(i as u8), info))
    }
}

impl Default for Classes {
    /// Highway, major, minor.
    fn default() -> Self {
        let class = |name: &str, closes_quarters| ClassInfo { name: name.into(), closes_quarters };
        Self::new(vec![class("highway", true), class("major", true), class("minor", false)])
    }
}

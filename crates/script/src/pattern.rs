//! Street patterns of a plan: one rule, or several that share the city by weights (PM01 §3.2.2).

use crate::plan::MapRef;
use crate::rule::Rule;
use std::collections::BTreeMap;

/// How much a pattern counts at a place: a formula of maps and numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum WeightPlan {
    /// The same everywhere.
    Number(f64),
    /// Read from a map, clamped to 0 … 1.
    Map(MapRef),
    /// 1 minus another.
    Inverse(Box<Self>),
    /// All of them multiplied.
    Product(Vec<Self>),
    /// All of them added.
    Sum(Vec<Self>),
    /// 1 in these districts, else 0.
    Districts(Vec<String>),
}

impl WeightPlan {
    /// The maps it reads, in the order of the formula.
    pub fn maps(&self) -> Vec<&MapRef> {
        match self {
            Self::Number(_) | Self::Districts(_) => Vec::new(),
            Self::Map(map) => vec![map],
            Self::Inverse(other) => other.maps(),
            Self::Product(all) | Self::Sum(all) => all.iter().flat_map(Self::maps).collect(),
        }
    }
}

impl WeightPlan {
    /// The districts it names, in the order of the formula.
    pub fn districts(&self) -> Vec<&str> {
        match self {
            Self::Number(_) | Self::Map(_) => Vec::new(),
            Self::Districts(names) => names.iter().map(String::as_str).collect(),
            Self::Inverse(other) => other.districts(),
            Self::Product(all) | Self::Sum(all) => all.iter().flat_map(Self::districts).collect(),
        }
    }
}

/// One rule of a pattern.
#[derive(Clone, Debug)]
pub struct PatternPart {
    /// What it is called in addresses, unique in its pattern: the last part of the rule's name, numbered from the second
    /// of that name on: `grid`, `grid2`.
    pub name: String,
    /// How streets grow: a rule with `propose(tip, p)`.
    pub rule: Rule,
    /// How much it counts, and where.
    pub weight: WeightPlan,
}

/// How streets grow: at least one rule. Where none has weight, the first one counts.
#[derive(Clone, Debug)]
pub struct PatternPlan {
    parts: Vec<PatternPart>,
}

impl PatternPlan {
    /// A rule that counts everywhere.
    pub fn of(rule: Rule) -> Self {
        let name = part_name(&rule).to_owned();
        Self { parts: vec![PatternPart { name, rule, weight: WeightPlan::Number(1.0) }] }
    }

    /// Its rules; at least one.
    pub fn parts(&self) -> &[PatternPart] {
        &self.parts
    }

    /// Every rule with what addresses call it: `role` for a single one, else `role.name`.
    pub fn roles(&self, role: &str) -> Vec<(String, &Rule)> {
        match self.parts.as_slice() {
            [part] => vec![(role.to_owned(), &part.rule)],
            parts => parts.iter().map(|part| (format!("{role}.{}", part.name), &part.rule)).collect(),
        }
    }

    /// The rule of a part, or of the only one where no name is given.
    pub(crate) fn rule_mut(&mut self, name: Option<&str>) -> Option<&mut Rule> {
        let is_meant = |part: &&mut PatternPart| name.is_none_or(|name| part.name == name);
        self.parts.iter_mut().find(is_meant).map(|part| &mut part.rule)
    }

    /// The same with every rule changed by what addresses call it.
    #[must_use]
    pub(crate) fn map_rules(&self, role: &str, change: impl Fn(&str, &Rule) -> Rule) -> Self {
        let rules = self.roles(role).into_iter().map(|(role, rule)| change(&role, rule));
        let parts = self.parts.iter().zip(rules).map(|(part, rule)| PatternPart { rule, ..part.clone() });
        Self { parts: parts.collect() }
    }

    /// The same, counting so much.
    #[must_use]
    pub(crate) fn times(mut self, weight: &WeightPlan) -> Self {
        for part in &mut self.parts {
            part.weight = match &part.weight {
                WeightPlan::Number(1.0) => weight.clone(),
                own => WeightPlan::Product(vec![own.clone(), weight.clone()]),
            };
        }
        self
    }

    /// Both together.
    #[must_use]
    pub(crate) fn plus(mut self, other: Self) -> Self {
        for part in other.parts {
            let name = self.free_name(part_name(&part.rule));
            self.parts.push(PatternPart { name, ..part });
        }
        self
    }

    /// Another pattern in each district. Addresses call the rule of a district by its name.
    #[must_use]
    pub(crate) fn by_district(named: BTreeMap<String, Self>, other: Self) -> Self {
        let all = WeightPlan::Districts(named.keys().cloned().collect());
        let mut whole = other.times(&WeightPlan::Inverse(Box::new(all)));
        for (district, pattern) in named {
            let is_one = pattern.parts.len() == 1;
            for part in pattern.times(&WeightPlan::Districts(vec![district.clone()])).parts {
                let name = if is_one { district.clone() } else { format!("{district} {}", part.name) };
                let name = whole.free_name(&name);
                whole.parts.push(PatternPart { name, ..part });
            }
        }
        whole
    }

    fn free_name(&self, name: &str) -> String {
        let is_free = |wanted: &String| self.parts.iter().all(|part| part.name != *wanted);
        let numbered = (2..).map(|number| format!("{name}{number}"));
        let mut names = std::iter::once(name.to_owned()).chain(numbered);
        names.find(is_free).unwrap_or_default()
    }
}

/// The last part of a rule's name.
fn part_name(rule: &Rule) -> &str {
    rule.name().rsplit('/').next().unwrap_or_default()
}

//! Trials: `fn test_…(trial)` is run for several, and what fails is made as simple as it still fails.

use super::standard::{FEATURES, standard};
use crate::city::SiteHandle;
use crate::fault::{Complaint, Refusal};
use crate::host::numeric;
use crate::words::getter;
use geom::{Id, Seed};
use rhai::{Array, Dynamic, Engine, FuncRegistration};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

/// Sizes of sites that are drawn, in metres, the simplest first.
const SIZES: [f64; 5] = [200.0, 300.0, 400.0, 600.0, 800.0];
/// Seeds that are drawn lie below this.
const SEEDS: u64 = 1000;

/// What a random test is run for: all that differs from run to run.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// For the seed of what it builds.
    pub seed: u64,
    /// Side of its site, metres.
    pub size: f64,
    /// What lies on its site: names of standard features.
    pub features: BTreeSet<&'static str>,
    /// Numbers that it does not draw, but takes: by the number they are drawn for.
    pub fixed: BTreeMap<u64, f64>,
}

impl Default for Trial {
    fn default() -> Self {
        Self { seed: 0, size: SIZES[0], features: BTreeSet::new(), fixed: BTreeMap::new() }
    }
}

impl Trial {
    /// The trial of that ordinal for a test: the same each time.
    pub fn random(test: &str, ordinal: u64) -> Self {
        let name = Id::of_text("trial", test).0;
        let seed = Seed((name ^ (name >> 64)) as u64).child(ordinal);
        let below = |purpose: u64, count: usize| (seed.unit(purpose) * count as f64) as usize;
        let drawn = (0_u64..).zip(FEATURES).filter(|(n, _)| seed.unit(10 + n) < 0.35);
        Self {
            seed: below(1, SEEDS as usize) as u64,
            size: SIZES[below(2, SIZES.len()).min(SIZES.len() - 1)],
            features: drawn.map(|(_, feature)| feature.name).collect(),
            fixed: BTreeMap::new(),
        }
    }

    /// Simpler trials, the simplest first; `drawn` is what the test drew for this one: number, low end, value.
    pub fn simpler(&self, drawn: &[(u64, f64, f64)]) -> Vec<Self> {
        let mut found = Vec::new();
        if !self.features.is_empty() {
            found.push(Self { features: BTreeSet::new(), ..self.clone() });
        }
        for feature in &self.features {
            let mut simpler = self.clone();
            simpler.features.remove(feature);
            found.push(simpler);
        }
        let smaller = SIZES.into_iter().filter(|size| *size < self.size);
        found.extend(smaller.map(|size| Self { size, ..self.clone() }));
        let mut seeds: Vec<u64> =
            (0..self.seed.min(4)).chain([self.seed / 2]).filter(|seed| *seed < self.seed).collect();
        seeds.dedup();
        found.extend(seeds.into_iter().map(|seed| Self { seed, ..self.clone() }));
        for &(n, low, value) in drawn {
            let rounded = [low, ((low + value) / 2.0).round(), value.round()];
            let nearer = rounded.into_iter().filter(|other| (other - low).abs() < (value - low).abs());
            found.extend(nearer.map(|other| {
                let mut simpler = self.clone();
                simpler.fixed.insert(n, other);
                simpler
            }));
        }
        found
    }
}

impl fmt::Display for Trial {
    /// `size=300 seed=7 with=hill+water 1=30.5`: what [`Trial::from_str`] reads.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "size={} seed={}", self.size, self.seed)?;
        if !self.features.is_empty() {
            write!(f, " with={}", self.features.iter().copied().collect::<Vec<_>>().join("+"))?;
        }
        self.fixed.iter().try_for_each(|(n, value)| write!(f, " {n}={value}"))
    }
}

impl FromStr for Trial {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut trial = Self::default();
        for part in text.split_whitespace() {
            let wrong = || format!("`{part}` is no part of a trial: write size=300 seed=7 with=hill+water 1=30.5");
            let (key, value) = part.split_once('=').ok_or_else(wrong)?;
            match key {
                "size" => {
                    trial.size = value.parse().ok().filter(|size| (50.0..=2000.0).contains(size)).ok_or_else(wrong)?
                }
                "seed" => trial.seed = value.parse().map_err(|_| wrong())?,
                "with" => {
                    let feature = |name: &str| FEATURES.iter().find(|feature| feature.name == name).map(|f| f.name);
                    trial.features = value.split('+').map(feature).collect::<Option<_>>().ok_or_else(wrong)?;
                }
                number => {
                    let value = value.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(wrong)?;
                    trial.fixed.insert(number.parse().map_err(|_| wrong())?, value);
                }
            }
        }
        Ok(trial)
    }
}

/// A trial as a test has it: it remembers what was drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct TrialHandle {
    trial: Arc<Trial>,
    drawn: Arc<Mutex<BTreeMap<u64, (f64, f64)>>>,
}

impl TrialHandle {
    pub fn new(trial: Trial) -> Self {
        Self { trial: Arc::new(trial), drawn: Arc::default() }
    }

    /// The numbers drawn so far: what for, low end, value.
    pub fn drawn(&self) -> Vec<(u64, f64, f64)> {
        let drawn = self.drawn.lock().unwrap_or_else(PoisonError::into_inner);
        drawn.iter().map(|(n, (low, value))| (*n, *low, *value)).collect()
    }

    fn draw(&self, n: i64, low: f64, high: f64) -> Result<f64, Complaint> {
        let n = u64::try_from(n).map_err(|_| Complaint::new("numbers are drawn for whole numbers from 0"))?;
        if low > high {
            return Err(Complaint::new(format!("nothing lies from {low} to {high}")));
        }
        let fixed = self.trial.fixed.get(&n).map(|value| value.clamp(low, high));
        let value = fixed.unwrap_or_else(|| Seed(self.trial.seed).purpose("draw").range(n, low, high));
        self.drawn.lock().unwrap_or_else(PoisonError::into_inner).insert(n, (low, value));
        Ok(value)
    }

    fn pick(&self, n: i64, list: &Array) -> Result<Dynamic, Complaint> {
        let position = self.draw(n, 0.0, list.len() as f64)? as usize;
        let nothing = || Complaint::new("nothing can be picked from an empty list");
        list.get(position.min(list.len().saturating_sub(1))).cloned().ok_or_else(nothing)
    }

    fn site(&self) -> SiteHandle {
        standard(self.trial.size, &self.trial.features.iter().copied().collect::<Vec<_>>())
    }
}

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<TrialHandle>("a trial");
    getter(engine, "seed", "A seed for what the test builds.", |trial: &mut TrialHandle| trial.trial.seed as i64);
    getter(engine, "size", "Side of its site, m.", |trial: &mut TrialHandle| trial.trial.size);
    FuncRegistration::new("site")
        .with_params_info(["this"])
        .with_comments(["/// The site of a trial: a standard one with whatever was drawn for it."])
        .register_into_engine(engine, |trial: &mut TrialHandle| trial.site());
    FuncRegistration::new("draw")
        .with_params_info(["this", "n", "low", "high"])
        .with_comments(["/// A number of a range, drawn for the number n: the same n, the same draw."])
        .register_into_engine(engine, |trial: &mut TrialHandle, n: i64, low: Dynamic, high: Dynamic| {
            Ok::<_, Refusal>(trial.draw(n, numeric("low", &low)?, numeric("high", &high)?)?)
        });
    FuncRegistration::new("pick")
        .with_params_info(["this", "n", "list"])
        .with_comments(["/// An element of a list, drawn for the number n."])
        .register_into_engine(engine, |trial: &mut TrialHandle, n: i64, list: Array| {
            Ok::<_, Refusal>(trial.pick(n, &list)?)
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_are_written_as_they_are_read() {
        for ordinal in 0..50 {
            let mut trial = Trial::random("some_test", ordinal);
            trial.fixed.extend([(ordinal, ordinal as f64 / 4.0), (7, -3.0)]);
            assert_eq!(trial.to_string().parse(), Ok(trial));
        }
        for bad in ["size", "size=0", "seed=-1", "with=moon", "x=1", "1=nan", "size=1e9"] {
            assert!(bad.parse::<Trial>().is_err(), "{bad}");
        }
    }

    #[test]
    fn cases_differ_and_come_back() {
        let all: Vec<Trial> = (0..40).map(|ordinal| Trial::random("some_test", ordinal)).collect();
        assert_eq!(all[3], Trial::random("some_test", 3));
        assert!(all.iter().any(|trial| trial.features.is_empty()) && all.iter().any(|trial| trial.features.len() > 2));
        assert_ne!(all, (0..40).map(|ordinal| Trial::random("another", ordinal)).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_simpler_ends_at_the_simplest() {
        let mut trial = Trial::random("some_test", 5);
        let drawn = |trial: &Trial| vec![(1, 10.0, trial.fixed.get(&1).copied().unwrap_or(37.3))];
        let mut steps = 0;
        while let Some(simpler) = trial.simpler(&drawn(&trial)).into_iter().next() {
            trial = simpler;
            steps += 1;
            assert!(steps < 100, "{trial}");
        }
        assert_eq!(trial, Trial { fixed: [(1, 10.0)].into(), ..Trial::default() });
    }
}

//! An answer as people read it.

use super::{Answer, DecisionSays, PatternSays};
use std::fmt;

/// The shortest distance (m) between a proposed and a laid end that is worth telling.
const WORTH_TELLING: f64 = 0.05;

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y] = self.place;
        writeln!(f, "{} {} at ({x:.1}, {y:.1}) m", self.kind, self.id)?;
        if !self.differs.is_empty() {
            writeln!(f, "\nThe layout is not what the city gives now; what follows is about the city as it is now.")?;
            self.differs.iter().try_for_each(|line| writeln!(f, "  {line}"))?;
        }
        for fact in &self.facts {
            writeln!(f, "  {:<11}{}", fact.about, fact.text)?;
        }
        self.rules(f)?;
        part(f, "On these values", !self.maps.is_empty())?;
        self.maps.iter().try_for_each(|map| writeln!(f, "  {:<11}{}", map.name, map.value))?;
        self.growth(f)?;
        self.decisions.iter().try_for_each(|decision| decision_says(decision, f))?;
        self.refusals(f)
    }
}

fn part(f: &mut fmt::Formatter<'_>, heading: &str, there_is_any: bool) -> fmt::Result {
    if there_is_any { writeln!(f, "\n{heading}") } else { Ok(()) }
}

fn at([x, y]: [f64; 2]) -> String {
    format!("({x:.1}, {y:.1})")
}

/// The patterns of a blend: `grid (62 %, leads), organic (38 %)`.
fn blended(patterns: &[PatternSays]) -> String {
    let one = |says: &PatternSays| {
        let leads = if says.leads { ", leads" } else { "" };
        format!("{} ({:.0} %{leads})", says.name, says.share * 100.0)
    };
    patterns.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// What a rule did, a step a line, and what came of it.
fn decision_says(says: &DecisionSays, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    writeln!(f, "\n{}", says.heading())?;
    for (number, step) in says.steps.iter().enumerate() {
        if let Some(left_out) = says.left_out.filter(|left_out| left_out.behind == number) {
            writeln!(f, "  …         {} further steps, without those that did something or printed", left_out.count)?;
        }
        let file = step.file.as_ref().map_or(String::new(), |file| format!("{file}:"));
        writeln!(f, "  line {:<4} {}", format!("{file}{}", step.line), step.told)?;
    }
    says.outcome.iter().try_for_each(|line| writeln!(f, "  then      {line}"))
}

impl Answer {
    fn rules(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        part(f, "By these rules", !self.rules.is_empty())?;
        for rule in &self.rules {
            let line = rule.line.map_or(String::new(), |line| format!(":{line}"));
            writeln!(f, "  {} = {}: {}{line}, fn {}", rule.role, rule.name, rule.file, rule.function)?;
        }
        part(f, "With these parameters", !self.parameters.is_empty())?;
        let width = self.parameters.iter().map(|says| says.address.chars().count()).max().unwrap_or(0);
        for says in &self.parameters {
            let here = says.here.as_ref().map_or(String::new(), |here| format!(" (here {here})"));
            let about = if says.about.is_empty() { String::new() } else { format!("   {}", says.about) };
            writeln!(f, "  {:<width$}  {}{here}{about}", says.address, says.value)?;
        }
        Ok(())
    }

    fn growth(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        part(f, "It grew", !self.pieces.is_empty())?;
        for piece in &self.pieces {
            let moved = match piece.moved {
                moved if moved > WORTH_TELLING => format!(" ({moved:.1} m from the end that was proposed)"),
                _ => String::new(),
            };
            writeln!(f, "  step {:<4} {} to {}: {}{moved}", piece.step, at(piece.from), at(piece.to), piece.outcome)?;
            if !piece.patterns.is_empty() {
                writeln!(f, "            by {}", blended(&piece.patterns))?;
            }
        }
        part(f, "It descends from", !self.lineage.is_empty())?;
        for says in &self.lineage {
            writeln!(
                f,
                "  step {:<4} street {}, {}, from {}: {}",
                says.step,
                says.street,
                says.stage,
                at(says.at),
                says.how
            )?;
        }
        Ok(())
    }

    fn refusals(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        part(f, "Refused at its ends", !self.refused.is_empty())?;
        for says in &self.refused {
            writeln!(
                f,
                "  step {:<4} {:<5} {} to {}: {}",
                says.step,
                says.branch,
                at(says.from),
                at(says.to),
                says.reason
            )?;
        }
        Ok(())
    }
}

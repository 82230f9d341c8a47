//! Progress on a terminal.

use city::progress::{Progress, Stage};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;

/// A bar a stage on a terminal; a line a stage elsewhere; nothing when quiet.
pub struct Bars {
    bar: Mutex<Option<ProgressBar>>,
    is_quiet: bool,
    is_terminal: bool,
}

impl Bars {
    /// Bars on standard error.
    pub fn new(is_quiet: bool) -> Self {
        Self { bar: Mutex::new(None), is_quiet, is_terminal: std::io::stderr().is_terminal() }
    }

    /// Takes a bar that still stands off the terminal.
    pub fn clear(&self) {
        if let Ok(mut bar) = self.bar.lock()
            && let Some(bar) = bar.take()
        {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bars {
    fn begin(&self, stage: Stage, parts: u64) {
        if self.is_quiet || !self.is_terminal {
            return;
        }
        let bar = if parts == 0 { ProgressBar::new_spinner() } else { ProgressBar::new(parts) };
        let style = ProgressStyle::with_template("{msg:>10} {wide_bar} {pos}/{len}");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_message(stage.name());
        if let Ok(mut slot) = self.bar.lock() {
            *slot = Some(bar);
        }
    }

    fn advance(&self, parts: u64) {
        if self.is_quiet || !self.is_terminal {
            return;
        }
        if let Ok(slot) = self.bar.lock()
            && let Some(bar) = slot.as_ref()
        {
            bar.inc(parts);
        }
    }

    fn end(&self, stage: Stage, outcome: &str) {
        self.clear();
        if !self.is_quiet {
            eprintln!("{:>10}  {outcome}", stage.name());
        }
    }
}

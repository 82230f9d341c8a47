//! The city while it grew: the streets after a derivation step (PM01 figure 9), made on a thread of their own.

use crate::evidence::Evidence;
use crate::render::Gpu;
use crate::scene::MapScene;
use crate::task::Task;
use crate::worker::{Ready, Wake};
use city::export::steps::city_after;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Steps of a whole play.
const FRAMES: u32 = 150;

/// Least time between two steps that are played.
const BEAT: Duration = Duration::from_millis(70);

/// What a step shows.
#[derive(Debug)]
pub struct Moment {
    /// The step; 0 before anything grew.
    pub step: u32,
    /// The last step there is.
    pub last: u32,
    /// The stages: name, first and last step.
    pub stages: Vec<(String, u32, u32)>,
    /// Kilometres of street by then.
    pub kilometres: f64,
    /// The map by then; none without a device.
    pub map: Option<MapScene>,
}

/// The growth of a city, step by step.
#[derive(Debug, Default)]
pub struct Timeline {
    /// What is shown in place of the finished city.
    pub moment: Option<Arc<Moment>>,
    /// Why nothing can be shown.
    pub problem: Option<String>,
    wanted: Option<u32>,
    making: Task<Moment>,
    /// Since when it plays.
    playing: Option<Instant>,
}

impl Timeline {
    /// Shows a step.
    pub fn go(&mut self, step: u32) {
        self.wanted = Some(step);
    }

    /// Goes on by itself from here, from the start where it is at the end; or stops.
    pub fn play(&mut self, plays: bool) {
        self.playing = plays.then(Instant::now);
        if plays && self.moment.as_ref().is_none_or(|moment| moment.step >= moment.last) {
            self.go(0);
        }
    }

    /// Whether it plays.
    pub fn plays(&self) -> bool {
        self.playing.is_some()
    }

    /// Whether a step is on its way.
    pub fn is_busy(&self) -> bool {
        self.making.is_busy() || self.wanted.is_some()
    }

    /// Shows the finished city again.
    pub fn leave(&mut self) {
        *self = Self::default();
    }

    /// Takes a step in once it is there, and begins the next one. Returns how soon to be called again.
    pub fn catch_up(
        &mut self,
        ready: &Arc<Ready>,
        evidence: &Arc<Evidence>,
        gpu: Option<&Gpu>,
        wake: &Wake,
    ) -> Option<Duration> {
        self.making.catch_up();
        match self.making.done.take() {
            Some(Ok(moment)) => self.moment = Some(Arc::new(moment)),
            Some(Err(problem)) => (self.problem, self.playing, self.wanted) = (Some(problem), None, None),
            None => {}
        }
        if self.making.is_busy() {
            return None;
        }
        if self.wanted.is_none() {
            let again = self.next()?;
            if again > Duration::ZERO {
                return Some(again);
            }
        }
        if let Some(step) = self.wanted.take() {
            let (ready, evidence, gpu) = (ready.clone(), evidence.clone(), gpu.cloned());
            self.making.begin("timeline", wake.clone(), move || moment(step, &ready, &evidence, gpu.as_ref()));
        }
        None
    }

    /// What is played next; how long until then.
    fn next(&mut self) -> Option<Duration> {
        let since = self.playing?.elapsed();
        let moment = self.moment.as_ref()?;
        if since < BEAT {
            return Some(BEAT - since);
        }
        if moment.step >= moment.last {
            self.playing = None;
            return None;
        }
        self.playing = Some(Instant::now());
        self.wanted = Some((moment.step + (moment.last / FRAMES).max(1)).min(moment.last));
        Some(Duration::ZERO)
    }
}

fn moment(step: u32, ready: &Ready, evidence: &Evidence, gpu: Option<&Gpu>) -> Result<Moment, String> {
    let trace = evidence.trace(ready)?;
    let then = city_after(&ready.built.city, trace, step);
    let stages = trace.stages().filter(|(_, stage)| stage.last_step() > 0);
    let stages = stages.map(|(start, stage)| (stage.name.to_owned(), start + 1, start + stage.last_step())).collect();
    let length = |run: &streets::runs::Run| -> f64 {
        let place = |key| then.graph.at(key).metres();
        run.nodes.windows(2).map(|pair| place(pair[0]).distance(place(pair[1]))).sum()
    };
    Ok(Moment {
        step,
        last: trace.last_step(),
        stages,
        kilometres: then.runs.iter().map(length).sum::<f64>() / 1000.0,
        map: gpu.map(|gpu| MapScene::of(gpu, &then, None, None)),
    })
}

//! Calling a rule's function a million times: everything that one call leaves behind for the next is kept.

use crate::effects::AskedAt;
use crate::fault::{Complaint, Fault, Refusal};
use crate::param::Params;
use crate::rule::{Entry, Rule, RuleKind, Stage};
use geom::Vec2;
use rhai::Dynamic;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What a script holds of a native value during one call: `tip`, `block`, `shape`.
#[derive(Debug)]
pub(crate) struct Handle<C>(Arc<Mutex<Option<C>>>);

impl<C> Clone for Handle<C> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<C> Handle<C> {
    fn empty() -> Self {
        Self(Arc::new(Mutex::new(None)))
    }

    fn lock(&self) -> MutexGuard<'_, Option<C>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Works on the value. Refused once the call is over.
    pub fn with<R>(&self, work: impl FnOnce(&mut C) -> Result<R, Complaint>) -> Result<R, Refusal> {
        match self.lock().as_mut() {
            Some(value) => Ok(work(value)?),
            None => Err(Complaint::new("this value was kept from an earlier call").into()),
        }
    }
}

/// What a call is about lies somewhere: parameters that differ by place are read there.
pub(crate) trait Located {
    /// The place in metres.
    fn place(&self) -> Vec2;
}

/// What is kept between the calls of one thread.
struct Desk<C> {
    stage: Stage,
    handle: Handle<C>,
}

/// A function of a rule, ready to be called from any thread.
pub(crate) struct Caller<C> {
    rule: Rule,
    entry: Entry,
    params: Params,
    /// The same as a script receives them, where they are the same everywhere.
    everywhere: Dynamic,
    desks: Mutex<Vec<Desk<C>>>,
}

impl<C: Located + Send + 'static> Caller<C> {
    /// The function of a kind that the rule has.
    pub fn new(rule: Rule, kind: RuleKind) -> Self {
        let (entry, params) = (rule.settled_entry(kind), rule.params().ready());
        let everywhere = Dynamic::from(params.clone());
        Self { rule, entry, params, everywhere, desks: Mutex::new(Vec::new()) }
    }

    /// The rule.
    pub fn rule(&self) -> &Rule {
        &self.rule
    }

    /// Calls the function with a context, and gives the context back as the function left it.
    pub fn call(&self, context: C) -> Result<C, Box<Fault>> {
        let mut desk = self.take_desk();
        let _asked = AskedAt::place(context.place());
        let params =
            if self.params.differ() { Dynamic::from(self.params.at(context.place())) } else { self.everywhere.clone() };
        *desk.handle.lock() = Some(context);
        let arguments = [Dynamic::from(desk.handle.clone()), params];
        // A desk that saw an error or a panic is thrown away: nothing of it is used again.
        match catch_unwind(AssertUnwindSafe(|| self.rule.run(&self.entry, &mut desk.stage, arguments))) {
            Ok(Ok(_)) => {}
            Ok(Err(error)) => return Err(Box::new(self.rule.fault_of(*error))),
            Err(panic) => return Err(Box::new(self.rule.fault_of_panic(&*panic))),
        }
        let left = desk.handle.lock().take();
        self.lock().push(desk);
        left.ok_or_else(|| Box::new(Fault::new(self.rule.path(), "the call lost its value")))
    }

    fn take_desk(&self) -> Desk<C> {
        let idle = self.lock().pop();
        idle.unwrap_or_else(|| Desk { stage: self.rule.stage(), handle: Handle::empty() })
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Desk<C>>> {
        self.desks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Faults, Host, Source, StreetPattern};
    use geom::{Bounds, Point, Seed};
    use std::sync::Arc;
    use streets::growth::{Fields, GrowthRules, Tip};

    fn tip(age: u32) -> Tip {
        let bounds = Bounds::between(Point::new(0, 0), Point::new(1024, 1024));
        let mut tip = Tip::new(streets::Classes::MINOR, Seed(1), Arc::new(Fields::plain(bounds)));
        (tip.is_seed, tip.age) = (false, age);
        tip
    }

    #[test]
    fn a_panic_inside_is_a_fault_and_the_next_call_is_well() {
        let text = "fn propose(tip, p) {\n  tip.ahead(10);\n  if tip.age == 1 { fail_inside(); }\n}".to_owned();
        let rule = Host::new(vec![]).rule_of("mine", &Source { text, path: "mine.rhai".into() }).expect("loads");
        let faults = Arc::new(Faults::default());
        let pattern = StreetPattern::new(rule, 0, Arc::new(streets::Classes::default()), faults.clone());
        let lengths = [0, 1, 0].map(|age| {
            let mut tip = tip(age);
            pattern.propose(&mut tip);
            tip.slots.ahead.map(|slot| slot.length)
        });
        assert_eq!(lengths, [Some(10.0), None, Some(10.0)]);
        let told: Vec<String> = faults.sorted().into_iter().map(|fault| fault.message).collect();
        assert_eq!(told, ["the program failed inside: as the test wants"]);
    }
}

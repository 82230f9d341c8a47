//! The derivation as a priority queue: instead of rewriting a string step by step, proposals wait for the step at which
//! they would be tested (Barrett, "L-systems considered harmful").

use super::lineage::Proposal;
use geom::Id;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Proposals by (time, lineage): the order in which they are tested depends on nothing else.
#[derive(Debug, Default)]
pub(super) struct Queue {
    heap: BinaryHeap<Reverse<(u32, Id, u32)>>,
    waiting: Vec<Proposal>,
    free: Vec<u32>,
}

impl Queue {
    pub fn push(&mut self, proposal: Proposal) {
        let (time, id) = (proposal.lineage.time, proposal.lineage.id);
        let place = match self.free.pop() {
            Some(place) => {
                self.waiting[place as usize] = proposal;
                place
            }
            None => {
                self.waiting.push(proposal);
                (self.waiting.len() - 1) as u32
            }
        };
        self.heap.push(Reverse((time, id, place)));
    }

    pub fn pop(&mut self) -> Option<Proposal> {
        let Reverse((.., place)) = self.heap.pop()?;
        self.free.push(place);
        Some(self.waiting[place as usize])
    }

    pub fn clear(&mut self) {
        self.heap.clear();
        self.waiting.clear();
        self.free.clear();
    }
}

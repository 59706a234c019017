//! Syntax tree → NFA (Thompson 1968) → DFA (subsets) → minimal DFA (Moore's partition refinement), over D and S.

use super::parse::Node;
use super::{DEAD, Event, LIVE_STATES_MAX};
use crate::error::{Error, Result};
use std::collections::HashMap;

/// Sets of NFA states to build before giving up. They can be exponentially many; what ends in 31 states and needs
/// more than this on the way is no expression that anybody writes.
const SUBSETS_MAX: usize = 2048;

/// A minimal automaton without its dead state; states are numbered in breadth-first order from the start, 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Dfa {
    /// `next[state][event]`, [`DEAD`] where nothing can be accepted any more.
    pub(super) next: Vec<[u32; 2]>,
    /// Bit `q` is set where state `q` accepts.
    pub(super) accepting: u32,
}

/// The automaton of an expression, or an error where it has too many states.
pub(super) fn compile(node: &Node) -> Result<Dfa> {
    let mut nfa = Nfa::default();
    let start = nfa.state();
    let accept = nfa.append(node, start);
    let (next, accepting) = nfa.subsets(start, accept)?;
    let class = moore(&next, &accepting);
    number(&next, &accepting, &class)
}

fn too_large(what: String) -> Error {
    Error::usage(what, format!("write a simpler one: it may need at most {LIVE_STATES_MAX}"))
}

#[derive(Default)]
struct Nfa {
    /// States reached without an event.
    free: Vec<Vec<usize>>,
    /// States reached by each event.
    on: Vec<[Option<usize>; 2]>,
}

impl Nfa {
    fn state(&mut self) -> usize {
        self.free.push(Vec::new());
        self.on.push([None; 2]);
        self.free.len() - 1
    }

    /// Add the states that read `node` from `start`; returns where it ends.
    fn append(&mut self, node: &Node, start: usize) -> usize {
        match node {
            Node::Event(event) => self.append_events(start, &[*event]),
            Node::Any => self.append_events(start, &Event::ALL),
            Node::Sequence(parts) => parts.iter().fold(start, |from, part| self.append(part, from)),
            Node::Either(parts) => {
                let end = self.state();
                for part in parts {
                    let from = self.state();
                    self.free[start].push(from);
                    let to = self.append(part, from);
                    self.free[to].push(end);
                }
                end
            }
            Node::Repeat { body, may_skip, may_loop } => {
                // Its own entry and exit, so that a loop in `body` cannot be entered from outside.
                let (from, end) = (self.state(), self.state());
                self.free[start].push(from);
                let to = self.append(body, from);
                self.free[to].push(end);
                if *may_loop {
                    self.free[to].push(from);
                }
                if *may_skip {
                    self.free[start].push(end);
                }
                end
            }
        }
    }

    fn append_events(&mut self, start: usize, events: &[Event]) -> usize {
        let (from, to) = (self.state(), self.state());
        self.free[start].push(from);
        for &event in events {
            self.on[from][event as usize] = Some(to);
        }
        to
    }

    /// All states that are reached from `states` without an event, sorted.
    fn closure(&self, states: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut inside = vec![false; self.free.len()];
        let mut open: Vec<usize> = states.into_iter().collect();
        while let Some(q) = open.pop() {
            if !std::mem::replace(&mut inside[q], true) {
                open.extend(&self.free[q]);
            }
        }
        (0..inside.len()).filter(|&q| inside[q]).collect()
    }

    /// The complete DFA: transitions and whether each state accepts. State 0 is the start.
    fn subsets(&self, start: usize, accept: usize) -> Result<(Vec<[usize; 2]>, Vec<bool>)> {
        let first = self.closure([start]);
        let mut number = HashMap::from([(first.clone(), 0)]);
        let mut sets = vec![first];
        let mut next = Vec::new();
        while next.len() < sets.len() {
            let set = sets[next.len()].clone();
            next.push(Event::ALL.map(|event| {
                let target = self.closure(set.iter().filter_map(|&q| self.on[q][event as usize]));
                *number.entry(target).or_insert_with_key(|target| {
                    sets.push(target.clone());
                    sets.len() - 1
                })
            }));
            if sets.len() > SUBSETS_MAX {
                return Err(too_large(format!(
                    "the light path expression needs more than {SUBSETS_MAX} states to compile"
                )));
            }
        }
        let accepting = sets.iter().map(|set| set.binary_search(&accept).is_ok()).collect();
        Ok((next, accepting))
    }
}

/// The class of each state: equal for states that accept the same continuations.
fn moore(next: &[[usize; 2]], accepting: &[bool]) -> Vec<usize> {
    let mut class: Vec<usize> = accepting.iter().map(|&a| usize::from(a)).collect();
    let mut count = 0;
    loop {
        let mut names = HashMap::new();
        let refined: Vec<usize> = (0..next.len())
            .map(|q| {
                let fresh = names.len();
                *names.entry((class[q], next[q].map(|n| class[n]))).or_insert(fresh)
            })
            .collect();
        class = refined;
        if names.len() == count {
            return class;
        }
        count = names.len();
    }
}

/// One state for each class that can still accept, numbered breadth first.
fn number(next: &[[usize; 2]], accepting: &[bool], class: &[usize]) -> Result<Dfa> {
    let classes = class.iter().max().map_or(0, |&c| c + 1);
    let mut member = vec![0; classes];
    for (q, &c) in class.iter().enumerate() {
        member[c] = q;
    }
    // In a minimal complete automaton only one state can be dead: it rejects and leads to itself.
    let dead = |c: usize| !accepting[member[c]] && next[member[c]].iter().all(|&n| class[n] == c);
    let mut numbers = vec![None; classes];
    numbers[class[0]] = Some(0);
    let mut order = vec![class[0]];
    let mut rows = Vec::new();
    while rows.len() < order.len() {
        let from = member[order[rows.len()]];
        rows.push(next[from].map(|n| {
            let c = class[n];
            if dead(c) {
                return DEAD;
            }
            *numbers[c].get_or_insert_with(|| {
                order.push(c);
                order.len() as u32 - 1
            })
        }));
    }
    if rows.len() > LIVE_STATES_MAX {
        return Err(too_large(format!("the light path expression needs {} states", rows.len())));
    }
    let accepting = (0..rows.len()).filter(|&q| accepting[member[order[q]]]).map(|q| 1 << q).sum();
    Ok(Dfa { next: rows, accepting })
}

//! Light path expressions: which paths are in the image, as a minimal automaton that a kernel can step.
//!
//! Heckbert's notation (Adaptive Radiosity Textures, SIGGRAPH 1990): L light, E eye, D a diffuse (non-delta)
//! vertex, S a specular (delta) vertex. `L(D|S)+SE` is read from the light; what starts with E is read from the
//! eye, and means the same paths written backwards. Between L and E stand D, S, `.` (either), groups, `|`, and
//! the quantifiers `*` `+` `?`; blanks are ignored. At the top level `|` separates whole expressions: `LE|LDE`.
//!
//! reads: the text of `--paths`. writes: a table of at most [`LIVE_STATES_MAX`] states, held by every joton and
//! eye path as one number, and masks of states as one u32.

mod automaton;
mod parse;

use crate::error::Result;
use crate::film::{LAYERS, Layer};
use automaton::Dfa;
use std::fmt;

/// A vertex of a light path, between the light and the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Event {
    /// Diffuse: scattered by something that is not a delta distribution.
    D = 0,
    /// Specular: reflected or refracted by a delta distribution.
    S = 1,
}

impl Event {
    /// Both events, in the order of the columns of [`LightPaths::transitions`].
    pub const ALL: [Event; 2] = [Event::D, Event::S];
}

/// States that a table has room for; the last one is [`DEAD`].
pub const STATES_MAX: usize = 32;
/// The state from which nothing is accepted any more: all 32 states, live and dead, fit five bits and one u32 mask.
pub const DEAD: u32 = 31;
/// Live states that an expression may need.
pub const LIVE_STATES_MAX: usize = STATES_MAX - 1;

/// The paths that are in the image: a regular language over D and S, in light order, between L and E.
#[derive(Debug, Clone)]
pub struct LightPaths {
    /// As the user wrote it.
    expression: String,
    dfa: Dfa,
}

impl LightPaths {
    /// The state of a path that has just left its light.
    pub const START: u32 = 0;

    /// Read an expression; a usage error says at which column it fails.
    pub fn parse(expression: &str) -> Result<Self> {
        let node = parse::parse(expression)?;
        Ok(Self { expression: expression.trim().to_owned(), dfa: automaton::compile(&node)? })
    }

    /// Every path from a light to the eye.
    pub fn everything() -> Self {
        Self::parse("L.*E").expect("a valid constant")
    }

    /// True where no path is left out, however it was written.
    pub fn is_everything(&self) -> bool {
        self.dfa.next == [[Self::START; 2]] && self.dfa.accepting == 1
    }

    /// Number of live states; they are numbered from 0 ([`Self::START`]).
    pub fn states(&self) -> u32 {
        self.dfa.next.len() as u32
    }

    /// The state after one more vertex, walking from the light. [`DEAD`] leads to itself.
    pub fn step(&self, state: u32, event: Event) -> u32 {
        self.dfa.next.get(state as usize).map_or(DEAD, |row| row[event as usize])
    }

    /// The states, as a mask, from which `event` leads to one of these.
    pub fn states_before(&self, mask: u32, event: Event) -> u32 {
        (0..DEAD).filter(|&q| mask >> self.step(q, event) & 1 == 1).map(|q| 1 << q).sum()
    }

    /// `table[state][event]` for the device; rows that are not live lead to [`DEAD`].
    pub fn transitions(&self) -> [[u32; 2]; STATES_MAX] {
        std::array::from_fn(|q| Event::ALL.map(|event| self.step(q as u32, event)))
    }

    /// Bit `q` is set where a path in state `q` that meets `k` specular vertices and then the eye is in the image.
    ///
    /// Exact for every `k`: S^k is one map of the states onto themselves, raised to a power by squaring.
    pub fn accept_mask_after_specular(&self, k: u32) -> u32 {
        let compose = |first: &[u32; STATES_MAX], then: &[u32; STATES_MAX]| first.map(|q| then[q as usize]);
        let mut after: [u32; STATES_MAX] = std::array::from_fn(|q| q as u32);
        let mut power: [u32; STATES_MAX] = std::array::from_fn(|q| self.step(q as u32, Event::S));
        let mut left = k;
        while left > 0 {
            if left & 1 == 1 {
                after = compose(&after, &power);
            }
            power = compose(&power, &power);
            left >>= 1;
        }
        (0..STATES_MAX).filter(|&q| self.dfa.accepting >> after[q] & 1 == 1).map(|q| 1 << q).sum()
    }

    /// Whether the path whose vertices between L and E are `events`, in light order ("SD"), is in the image.
    /// Other letters than D and S match nothing.
    pub fn matches(&self, events: &str) -> bool {
        let end = events.chars().try_fold(Self::START, |state, letter| match letter {
            'D' => Some(self.step(state, Event::D)),
            'S' => Some(self.step(state, Event::S)),
            _ => None,
        });
        end.is_some_and(|state| self.dfa.accepting >> state & 1 == 1)
    }

    /// Which layers can hold any light at all, in the order of [`Layer::ALL`]: exact, by the product of this
    /// automaton with the one that tells the layers apart.
    pub fn layers(&self) -> [bool; LAYERS] {
        let mut found = [false; LAYERS];
        let mut seen = [[false; Class::COUNT]; STATES_MAX];
        let mut open = vec![(Self::START, Class::Nothing)];
        while let Some((state, class)) = open.pop() {
            if state == DEAD || std::mem::replace(&mut seen[state as usize][class as usize], true) {
                continue;
            }
            if self.dfa.accepting >> state & 1 == 1 {
                found[class.layer() as usize] = true;
            }
            open.extend(Event::ALL.map(|event| (self.step(state, event), class.step(event))));
        }
        found
    }
}

impl fmt::Display for LightPaths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.expression)
    }
}

/// Two path sets are equal where they hold the same paths: minimal automata, numbered alike, decide it.
impl PartialEq for LightPaths {
    fn eq(&self, other: &Self) -> bool {
        self.dfa == other.dfa
    }
}

impl Eq for LightPaths {}

/// What a path from the light has met so far: enough to tell its layer.
#[derive(Clone, Copy)]
enum Class {
    /// L
    Nothing,
    /// L S+
    Specular,
    /// L D S*
    Diffuse,
    /// L S+ D S*
    SpecularDiffuse,
    /// Two or more D.
    Interreflected,
}

impl Class {
    const COUNT: usize = 5;

    fn step(self, event: Event) -> Self {
        match (self, event) {
            (Class::Nothing, Event::S) => Class::Specular,
            (Class::Nothing, Event::D) => Class::Diffuse,
            (Class::Specular, Event::D) => Class::SpecularDiffuse,
            (Class::Diffuse | Class::SpecularDiffuse, Event::D) => Class::Interreflected,
            (class, _) => class,
        }
    }

    fn layer(self) -> Layer {
        match self {
            Class::Nothing | Class::Specular => Layer::Emission,
            Class::Diffuse => Layer::Direct,
            Class::SpecularDiffuse => Layer::Caustic,
            Class::Interreflected => Layer::Diffuse,
        }
    }
}

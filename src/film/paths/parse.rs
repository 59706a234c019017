//! Text of a light path expression → syntax tree, in light order.
//!
//! expression = ends ("|" ends)*          ends = "L" sequence "E" | "E" sequence "L"
//! sequence   = (atom ("*" | "+" | "?")*)*  atom = "D" | "S" | "." | "(" sequence ("|" sequence)* ")"

use super::Event;
use crate::error::{Error, Result};

/// Longest expression, in characters: far beyond what fits 31 states and still instant to compile.
const LENGTH_MAX: usize = 1000;
/// Deepest nesting of groups: bounds the recursion.
const DEPTH_MAX: u32 = 64;

/// A regular expression over D and S.
#[derive(Debug, Clone)]
pub(super) enum Node {
    Event(Event),
    Any,
    Sequence(Vec<Node>),
    Either(Vec<Node>),
    Repeat { body: Box<Node>, may_skip: bool, may_loop: bool },
}

impl Node {
    /// The same words, spelt backwards.
    fn reversed(self) -> Self {
        match self {
            Node::Sequence(parts) => Node::Sequence(parts.into_iter().rev().map(Node::reversed).collect()),
            Node::Either(parts) => Node::Either(parts.into_iter().map(Node::reversed).collect()),
            Node::Repeat { body, may_skip, may_loop } => {
                Node::Repeat { body: Box::new(body.reversed()), may_skip, may_loop }
            }
            leaf @ (Node::Event(_) | Node::Any) => leaf,
        }
    }
}

/// What stands between L and E.
pub(super) fn parse(text: &str) -> Result<Node> {
    let symbols: Vec<(usize, char)> = (1..).zip(text.chars()).filter(|(_, c)| !c.is_whitespace()).collect();
    let end = text.chars().count() + 1;
    let mut parser = Parser { text, symbols, at: 0, end };
    if end > LENGTH_MAX + 1 {
        return Err(Error::usage(
            format!("the light path expression is {} characters long", end - 1),
            format!("write at most {LENGTH_MAX}"),
        ));
    }
    let mut parts = vec![parser.whole_path()?];
    while let Some((column, symbol)) = parser.next() {
        if symbol != '|' {
            return Err(parser.error(
                column,
                format!("\"{symbol}\" after the end of the path"),
                "end with the E (or L) there, or separate whole expressions by \"|\"",
            ));
        }
        parts.push(parser.whole_path()?);
    }
    Ok(Node::Either(parts))
}

struct Parser<'a> {
    text: &'a str,
    /// Column, from 1, and character; no blanks.
    symbols: Vec<(usize, char)>,
    at: usize,
    /// The column after the last character.
    end: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<(usize, char)> {
        self.symbols.get(self.at).copied()
    }

    fn next(&mut self) -> Option<(usize, char)> {
        let symbol = self.peek();
        self.at += usize::from(symbol.is_some());
        symbol
    }

    fn error(&self, column: usize, what: impl AsRef<str>, remedy: &str) -> Error {
        Error::usage(
            format!("light path expression \"{}\", column {column}: {}", self.text, what.as_ref()),
            remedy,
        )
    }

    /// L … E, or E … L reversed.
    fn whole_path(&mut self) -> Result<Node> {
        const BOTH_ENDS: &str = "write L … E (from the light) or E … L (from the eye), for example L(S|D)*E";
        let (first, last) = match self.next() {
            Some((_, 'L')) => ('L', 'E'),
            Some((_, 'E')) => ('E', 'L'),
            Some((column, c)) => {
                return Err(self.error(column, format!("a path cannot start with \"{c}\""), BOTH_ENDS));
            }
            None => return Err(self.error(self.end, "a path is missing", BOTH_ENDS)),
        };
        let body = self.sequence(0)?;
        match self.next() {
            Some((_, c)) if c == last => {}
            Some((column, c)) if c == first => {
                let what = format!("\"{c}\" stands inside the path");
                return Err(self.error(column, what, "L and E stand only at the ends, once each"));
            }
            Some((column, ')')) => {
                return Err(self.error(column, "\")\" without \"(\"", "remove it or open a group before it"));
            }
            Some((column, c)) => {
                let what = format!("\"{c}\" before the path has ended with {last}");
                return Err(self.error(column, what, BOTH_ENDS));
            }
            None => {
                return Err(self.error(self.end, format!("the path does not end with {last}"), BOTH_ENDS));
            }
        }
        Ok(if first == 'E' { body.reversed() } else { body })
    }

    /// Atoms with their quantifiers, up to what cannot belong to a sequence.
    fn sequence(&mut self, depth: u32) -> Result<Node> {
        let mut parts = Vec::new();
        while let Some((column, symbol)) = self.peek() {
            let atom = match symbol {
                'L' | 'E' | '|' | ')' => break,
                'D' => Node::Event(Event::D),
                'S' => Node::Event(Event::S),
                '.' => Node::Any,
                '(' => {
                    self.at += 1;
                    parts.push(self.group(column, depth + 1)?);
                    continue;
                }
                '*' | '+' | '?' => {
                    let what = format!("\"{symbol}\" has nothing to repeat");
                    return Err(self.error(
                        column,
                        what,
                        "put D, S, \".\" or a group before it; L and E occur once",
                    ));
                }
                _ => {
                    let what = format!("\"{symbol}\" is not part of the notation");
                    return Err(self.error(column, what, "use L E D S . ( ) | * + ?"));
                }
            };
            self.at += 1;
            parts.push(self.quantified(atom));
        }
        Ok(Node::Sequence(parts))
    }

    /// What follows "(" at `open`, up to and with ")" and its quantifiers.
    fn group(&mut self, open: usize, depth: u32) -> Result<Node> {
        if depth > DEPTH_MAX {
            return Err(self.error(
                open,
                "groups are nested too deeply",
                &format!("nest at most {DEPTH_MAX}"),
            ));
        }
        let mut parts = Vec::new();
        loop {
            let part = self.sequence(depth)?;
            let empty = matches!(&part, Node::Sequence(atoms) if atoms.is_empty());
            match self.next() {
                Some((column, '|' | ')')) if empty => {
                    return Err(self.error(
                        column,
                        "an alternative is empty",
                        "put D, S or \".\" there; \"?\" makes a group optional",
                    ));
                }
                Some((_, '|')) => parts.push(part),
                Some((_, ')')) => {
                    parts.push(part);
                    return Ok(self.quantified(Node::Either(parts)));
                }
                Some((column, c)) => {
                    let what = format!("\"{c}\" stands inside a group");
                    return Err(self.error(column, what, "L and E stand only at the ends, outside groups"));
                }
                None => return Err(self.error(open, "\"(\" is never closed", "add \")\"")),
            }
        }
    }

    fn quantified(&mut self, mut body: Node) -> Node {
        while let Some((_, symbol @ ('*' | '+' | '?'))) = self.peek() {
            self.at += 1;
            let (may_skip, may_loop) = (symbol != '+', symbol != '?');
            body = Node::Repeat { body: Box::new(body), may_skip, may_loop };
        }
        body
    }
}

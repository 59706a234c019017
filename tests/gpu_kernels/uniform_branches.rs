//! No kernel branches on uniforms alone: no condition of a branch and no bound of a loop follows from uniform buffers and
//! constants. Mesa's software device clones and compiles a kernel with such a branch at every dispatch, and keeps each clone.
//!
//! The conditions are read from naga's module. A value is as far from constant as what it is computed from; functions
//! take theirs from all calls; a variable that is set under a condition is a choice of its own, but for a loop's counter.

use joton::backend::gpu::{SOURCES, Variant, link, link_source};
use naga::{Block, Expression, Function, Handle, LocalVariable, Module, Statement};
use std::collections::HashMap;

/// What a value depends on, from the least to the most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Depends {
    Constants,
    /// … and uniform buffers.
    Uniforms,
    /// … and what differs from one invocation to the next, or what a driver cannot know.
    Lane,
}
use Depends::{Constants, Lane, Uniforms};

/// Values that are stored in a variable.
#[derive(Debug, Clone, Copy)]
struct Stored {
    /// What is stored whatever the conditions.
    always: Depends,
    /// What is added to the variable in a loop.
    step: Depends,
    /// Stores in branches and loops that add to the variable.
    steps: u32,
    /// Other stores in branches and loops.
    choices: u32,
}

impl Stored {
    const NOTHING: Self = Self { always: Constants, step: Constants, steps: 0, choices: 0 };

    fn value(&self) -> Depends {
        match (self.steps, self.choices) {
            (0 | 1, 0) => self.always.max(self.step),
            _ => Lane,
        }
    }
}

/// Rounds over all functions, and over the variables of one: more than twice the levels of calls.
const ROUNDS: u32 = 16;

/// The variables, arguments and results of all functions, grown until nothing changes.
struct Analysis<'a> {
    module: &'a Module,
    /// Of all calls, as the last round found them, and as this one does.
    arguments: HashMap<(Option<Handle<Function>>, u32), Depends>,
    passed: HashMap<(Option<Handle<Function>>, u32), Depends>,
    results: HashMap<Handle<Function>, Depends>,
    /// The variables of the function at hand are known.
    settled: bool,
    /// Conditions that depend on uniforms alone, as they read.
    found: Vec<String>,
}

struct Body<'a> {
    function: &'a Function,
    handle: Option<Handle<Function>>,
    locals: HashMap<Handle<LocalVariable>, Stored>,
}

impl<'a> Analysis<'a> {
    /// Conditions on uniforms alone in a module: function and what is wrong.
    fn of(module: &'a Module) -> Vec<String> {
        let (arguments, passed) = (HashMap::new(), HashMap::new());
        let mut all =
            Self { module, arguments, passed, results: HashMap::new(), settled: false, found: Vec::new() };
        // nothing calls itself: values settle after a round for each level of calls, down and up again
        for _ in 0..ROUNDS {
            all.found.clear();
            for entry in &module.entry_points {
                all.body(&entry.function, None);
            }
            for (handle, function) in module.functions.iter() {
                all.body(function, Some(handle));
            }
            all.arguments = std::mem::take(&mut all.passed);
        }
        all.found.sort();
        all.found.dedup();
        all.found
    }

    fn body(&mut self, function: &'a Function, handle: Option<Handle<Function>>) {
        let mut body = Body { function, handle, locals: HashMap::new() };
        // each variable takes from those before it
        for round in 1..=ROUNDS {
            self.settled = round == ROUNDS;
            if let Some(handle) = handle {
                self.results.insert(handle, Constants);
            }
            let mut locals: HashMap<_, Stored> = HashMap::new();
            for (local, variable) in function.local_variables.iter() {
                let init = variable.init.map_or(Constants, |e| self.value(&body, e));
                locals.insert(local, Stored { always: init, ..Stored::NOTHING });
            }
            self.stores(&body, &function.body, false, &mut locals);
            body.locals = locals;
        }
        self.conditions(&body, &function.body);
    }

    fn value(&self, body: &Body<'_>, e: Handle<Expression>) -> Depends {
        let of = |e: Handle<Expression>| self.value(body, e);
        match &body.function.expressions[e] {
            Expression::Literal(_)
            | Expression::Constant(_)
            | Expression::Override(_)
            | Expression::ZeroValue(_) => Constants,
            Expression::Compose { components, .. } => {
                components.iter().map(|c| of(*c)).max().unwrap_or(Constants)
            }
            Expression::AccessIndex { base, index } => match &body.function.expressions[*base] {
                Expression::Compose { components, .. } => of(components[*index as usize]),
                _ => of(*base),
            },
            // which element is not known before the kernel runs
            Expression::Access { .. } => Lane,
            Expression::Splat { value, .. } => of(*value),
            Expression::Swizzle { vector, .. } => of(*vector),
            Expression::Load { pointer } => of(*pointer),
            Expression::GlobalVariable(g) => match self.module.global_variables[*g].space {
                naga::AddressSpace::Uniform => Uniforms,
                _ => Lane,
            },
            Expression::LocalVariable(v) => body.locals.get(v).map_or(Constants, Stored::value),
            Expression::FunctionArgument(i) => match body.handle {
                // what an entry point gets are numbers of the invocation, and of the dispatch
                None => Lane,
                Some(_) => self.arguments.get(&(body.handle, *i)).copied().unwrap_or(Lane),
            },
            Expression::CallResult(f) => self.results.get(f).copied().unwrap_or(Constants),
            Expression::Unary { expr, .. } | Expression::As { expr, .. } => of(*expr),
            Expression::Binary { left, right, .. } => of(*left).max(of(*right)),
            Expression::Select { condition, accept, reject } => {
                of(*condition).max(of(*accept)).max(of(*reject))
            }
            Expression::Relational { argument, .. } => of(*argument),
            Expression::Math { arg, arg1, arg2, arg3, .. } => {
                [Some(*arg), *arg1, *arg2, *arg3].into_iter().flatten().map(of).max().unwrap_or(Constants)
            }
            _ => Lane,
        }
    }

    /// Collect what is stored, passed and returned. `chosen`: in a branch or a loop.
    fn stores(
        &mut self,
        body: &Body<'_>,
        block: &Block,
        chosen: bool,
        locals: &mut HashMap<Handle<LocalVariable>, Stored>,
    ) {
        for statement in block {
            match statement {
                Statement::Block(inner) => self.stores(body, inner, chosen, locals),
                Statement::If { condition, accept, reject } => {
                    // constants choose before anything runs
                    let chosen = chosen || self.value(body, *condition) != Constants;
                    self.stores(body, accept, chosen, locals);
                    self.stores(body, reject, chosen, locals);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.stores(body, &case.body, true, locals);
                    }
                }
                Statement::Loop { body: inner, continuing, .. } => {
                    self.stores(body, inner, true, locals);
                    self.stores(body, continuing, true, locals);
                }
                Statement::Store { pointer, value } => {
                    let Some(local) = root(body.function, *pointer) else { continue };
                    let depends = self.value(body, *value);
                    let stored = locals.entry(local).or_insert(Stored::NOTHING);
                    match (chosen, step(body.function, local, *value)) {
                        (false, _) => stored.always = stored.always.max(depends),
                        (true, Some(step)) => {
                            stored.steps += 1;
                            stored.step = stored.step.max(self.value(body, step));
                        }
                        (true, None) => stored.choices += 1,
                    }
                }
                Statement::Call { function, arguments, .. } => {
                    for (i, argument) in arguments.iter().enumerate() {
                        // what is passed by pointer may be stored to
                        let depends = match root(body.function, *argument) {
                            Some(local) => {
                                locals.entry(local).or_insert(Stored::NOTHING).choices += 1;
                                Lane
                            }
                            None => self.value(body, *argument),
                        };
                        if !self.settled {
                            continue;
                        }
                        let known = self.passed.entry((Some(*function), i as u32)).or_insert(Constants);
                        // a function is compiled into each of its callers: one with uniforms is enough
                        *known = match (*known, depends) {
                            (Uniforms, _) | (_, Uniforms) => Uniforms,
                            (a, b) => a.max(b),
                        };
                    }
                }
                Statement::Return { value: Some(value) } => {
                    if let Some(handle) = body.handle {
                        let depends = if chosen { Lane } else { self.value(body, *value) };
                        let known = self.results.entry(handle).or_insert(Constants);
                        *known = (*known).max(depends);
                    }
                }
                _ => {}
            }
        }
    }

    fn conditions(&mut self, body: &Body<'_>, block: &Block) {
        for statement in block {
            let condition = match statement {
                Statement::If { condition, .. } => Some(*condition),
                Statement::Switch { selector, .. } => Some(*selector),
                Statement::Loop { break_if, .. } => *break_if,
                _ => None,
            };
            if condition.is_some_and(|c| self.value(body, c) == Uniforms) {
                let name = body.function.name.as_deref().unwrap_or("the entry point");
                let mut read = Vec::new();
                if let Some(c) = condition {
                    self.uniforms(body, c, &mut read);
                }
                read.dedup();
                self.found.push(format!("{name}: {}", read.join(", ")));
            }
            let inner: Vec<&Block> = match statement {
                Statement::Block(inner) => vec![inner],
                Statement::If { accept, reject, .. } => vec![accept, reject],
                Statement::Switch { cases, .. } => cases.iter().map(|c| &c.body).collect(),
                Statement::Loop { body, continuing, .. } => vec![body, continuing],
                _ => Vec::new(),
            };
            for block in inner {
                self.conditions(body, block);
            }
        }
    }

    /// Names of the uniforms, arguments and variables that an expression reads.
    fn uniforms(&self, body: &Body<'_>, e: Handle<Expression>, read: &mut Vec<String>) {
        let name = |name: &Option<String>| name.clone().unwrap_or_default();
        let all = &body.function.expressions;
        match &all[e] {
            Expression::AccessIndex { base, index } => {
                if let Expression::GlobalVariable(g) = all[*base] {
                    let variable = &self.module.global_variables[g];
                    let field = match &self.module.types[variable.ty].inner {
                        naga::TypeInner::Struct { members, .. } => name(&members[*index as usize].name),
                        _ => index.to_string(),
                    };
                    read.push(format!("{}.{field}", name(&variable.name)));
                } else {
                    self.uniforms(body, *base, read);
                }
            }
            Expression::GlobalVariable(g) => read.push(name(&self.module.global_variables[*g].name)),
            Expression::LocalVariable(v) => read.push(name(&body.function.local_variables[*v].name)),
            Expression::FunctionArgument(i) => {
                read.push(name(&body.function.arguments[*i as usize].name));
            }
            Expression::Load { pointer: e }
            | Expression::Unary { expr: e, .. }
            | Expression::As { expr: e, .. } => {
                self.uniforms(body, *e, read);
            }
            Expression::Binary { left, right, .. } => {
                self.uniforms(body, *left, read);
                self.uniforms(body, *right, read);
            }
            _ => {}
        }
    }
}

/// The variable that a pointer leads to.
fn root(function: &Function, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
    match function.expressions[pointer] {
        Expression::LocalVariable(v) => Some(v),
        Expression::Access { base, .. } | Expression::AccessIndex { base, .. } => root(function, base),
        _ => None,
    }
}

/// What is added, where a value is a variable and something more.
fn step(
    function: &Function,
    local: Handle<LocalVariable>,
    value: Handle<Expression>,
) -> Option<Handle<Expression>> {
    use naga::BinaryOperator::{Add, Subtract};
    let Expression::Binary { op: Add | Subtract, left, right } = function.expressions[value] else {
        return None;
    };
    let is_variable = |e: Handle<Expression>| {
        matches!(function.expressions[e], Expression::Load { pointer }
            if matches!(function.expressions[pointer], Expression::LocalVariable(v) if v == local))
    };
    [(left, right), (right, left)].into_iter().find(|(a, _)| is_variable(*a)).map(|(_, b)| b)
}

fn branches(source: &str) -> Vec<String> {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    Analysis::of(&module)
}

/// No kernel, in none of its variants, branches on uniforms alone.
#[test]
fn no_kernel_branches_on_uniforms_alone() {
    let kernels = SOURCES.iter().map(|(path, _)| *path).filter(|path| path.starts_with("passes/"));
    let mut found = Vec::new();
    for path in kernels {
        for bits in 0..4 {
            let variant =
                Variant { subgroups: bits & 1 != 0, small_scene: bits & 2 != 0, ..Variant::default() };
            let source = link(path, variant).unwrap_or_else(|e| panic!("{e}"));
            found.extend(branches(&source).into_iter().map(|what| format!("{path}: {what}")));
        }
    }
    found.sort();
    found.dedup();
    assert!(
        found.is_empty(),
        "branches on uniforms alone: pass the uniform through own(), or make it an override\n{}",
        found.join("\n")
    );
}

/// Each way to branch on uniforms alone is found, and what depends on an invocation, or on constants, is not taken for it.
#[test]
fn branches_on_uniforms_are_found() {
    let kernel = |body: &str| {
        let head = "@group(0) @binding(0) var<uniform> pass_info: PassInfo;
            @group(0) @binding(1) var<uniform> map_info: MapInfo;
            @group(0) @binding(2) var<storage, read_write> status: array<u32>;
            override LARGE: bool = false;
            fn bound(n: u32) -> u32 { var s = 0u; for (var i = 0u; i < n; i += 1u) { s += i; } return s; }
            fn larger(n: u32) -> u32 { return 2u * n; }
            @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {";
        link_source(&format!("{head}{body}}}"), Variant::default()).unwrap_or_else(|e| panic!("{e}"))
    };
    for body in [
        "if pass_info.pass_index == PILOT_PASS { status[id.x] = 1u; }",
        "let pilot = pass_info.pass_index == PILOT_PASS; if !pilot && id.x > 3u { status[id.x] = 1u; }",
        "if LARGE && pass_info.targets > 3u { status[id.x] = 1u; }",
        "for (var i = 0u; i < pass_info.targets; i += 1u) { status[id.x] = i; }",
        "var i = 0u; while i + 1u < pass_info.targets && id.x > i { i += 1u; } status[id.x] = i;",
        "var i = 0u; loop { status[id.x] = i; continuing { i += 1u; break if i > map_info.lanes; } }",
        "switch pass_info.pass_index { case 1u: { status[id.x] = 1u; } default: {} }",
        "status[id.x] = bound(id.y) + bound(pass_info.targets);",
        "if larger(map_info.lanes) > 3u { status[id.x] = 1u; }",
        "var n = map_info.lanes; n += 3u; if n > 7u { status[id.x] = 1u; }",
    ] {
        assert_eq!(branches(&kernel(body)).len(), 1, "{body}: {:?}", branches(&kernel(body)));
    }
    for body in [
        "if id.x >= map_info.lanes { return; } status[id.x] = 1u;",
        "if LARGE { status[id.x] = 1u; }",
        "for (var i = 0u; i < 4u; i += 1u) { status[id.x] = bound(i); }",
        "let n = pass_info.targets | id.z; for (var i = 0u; i < n; i += 1u) { status[id.x] = i; }",
        "for (var i = id.x; i < map_info.lanes; i += 64u) { status[i] = 1u; }",
        "if status[0] == pass_info.pass_index { status[id.x] = 1u; }",
        "var kind = 0u; if id.x > 3u { kind = map_info.lanes; } if kind == 1u { status[id.x] = 1u; }",
        "status[id.x] = select(1u, 2u, pass_info.pass_index == PILOT_PASS);",
    ] {
        assert_eq!(branches(&kernel(body)), Vec::<String>::new(), "{body}");
    }
}

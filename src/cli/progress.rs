//! Progress: what a render says while it goes on, to a terminal, to a log or to another program.

use super::tell;
use indicatif::{ProgressBar, ProgressStyle};
use joton::render::Progress;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What takes less is not told where lines are kept.
const PLAIN: Duration = Duration::from_secs(5);
/// Least time between two lines for a program.
const JSON: Duration = Duration::from_millis(500);
/// Part of the work that must be done before it tells how long the rest takes.
const TOLD: f64 = 0.02;

/// How progress is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
pub(super) enum Kind {
    /// A bar on a terminal, else lines.
    Auto,
    /// A bar on the terminal's last line.
    Bar,
    /// A line every five seconds.
    Plain,
    /// An object a line: `event` is step, progress, message, warning, done or wrote.
    Json,
    /// None.
    Off,
}

/// Tells what a command does.
pub(super) struct Narrator {
    kind: Kind,
    is_quiet: bool,
    bar: ProgressBar,
    /// The step of the set-up that goes on, and what waits for it to take long.
    step: Arc<(Mutex<Option<Step>>, Condvar)>,
    told: Instant,
    /// Which of how many renders goes on, and the seconds of those before.
    render: (usize, usize, f64),
}

/// A step of the set-up.
#[derive(Clone, Copy)]
struct Step {
    what: &'static str,
    since: Instant,
}

impl Narrator {
    /// Begin; where it is quiet nothing is said but errors.
    pub(super) fn new(kind: Kind, is_quiet: bool) -> Self {
        let on_terminal = std::io::IsTerminal::is_terminal(&std::io::stderr());
        let kind = match kind {
            _ if is_quiet => Kind::Off,
            Kind::Auto if on_terminal => Kind::Bar,
            Kind::Auto => Kind::Plain,
            kind => kind,
        };
        let bar = if kind == Kind::Bar { ProgressBar::new_spinner() } else { ProgressBar::hidden() };
        let step: Arc<(Mutex<Option<Step>>, Condvar)> = Arc::default();
        if kind == Kind::Plain {
            let step = Arc::clone(&step);
            std::thread::spawn(move || tell_long_steps(&step));
        }
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { kind, is_quiet, bar, step, told: Instant::now(), render: (0, 1, 0.0) }
    }

    /// A step of the set-up begins.
    pub(super) fn step(&self, what: &'static str) {
        self.bar.set_message(what);
        if self.kind == Kind::Json {
            tell(serde_json::json!({ "event": "step", "what": what }));
        }
        self.set_step(Some(Step { what, since: Instant::now() }));
    }

    /// The set-up is over: from here on there are passes.
    pub(super) fn begin(&mut self) {
        self.set_step(None);
        self.told = Instant::now();
        if self.kind == Kind::Bar {
            self.bar.set_length(1000);
            self.bar.set_message("");
            if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}") {
                self.bar.set_style(style);
            }
        }
    }

    /// What follows is render `number`, from 0 on, of so many, and those before took so many seconds.
    pub(super) fn part(&mut self, number: usize, count: usize, seconds_before: f64) {
        self.render = (number, count, seconds_before);
    }

    /// A batch is done.
    pub(super) fn show(&mut self, p: &Progress<'_>) {
        let (number, count, seconds_before) = self.render;
        let (done, seconds) = ((number as f64 + p.done) / count as f64, seconds_before + p.seconds);
        let seconds_left = (done > TOLD).then(|| seconds / done * (1.0 - done));
        match self.kind {
            Kind::Bar => {
                self.bar.set_position((done * 1000.0) as u64);
                self.bar.set_message(line(p, seconds, seconds_left));
            }
            Kind::Plain if self.told.elapsed() >= PLAIN => {
                tell(format_args!("joton: {}", line(p, seconds, seconds_left)));
                self.told = Instant::now();
            }
            Kind::Json if self.told.elapsed() >= JSON => {
                tell(serde_json::json!({
                    "event": "progress",
                    "passes": p.passes,
                    "seconds": seconds,
                    "error_estimate": p.error.map(|e| e.total),
                    "done": done,
                    "seconds_left": seconds_left,
                }));
                self.told = Instant::now();
            }
            _ => {}
        }
    }

    /// The passes are over.
    pub(super) fn end(&self) {
        self.bar.finish_and_clear();
    }

    /// Say something, as a person reads it, or with the fields that a program reads.
    fn say(&self, event: &str, words: &str, fields: serde_json::Value) {
        if self.is_quiet {
            return;
        }
        self.bar.suspend(|| match (self.kind, fields) {
            (Kind::Json, serde_json::Value::Object(mut fields)) => {
                fields.insert("event".into(), event.into());
                tell(serde_json::Value::Object(fields));
            }
            _ => tell(format_args!("joton: {words}")),
        });
    }

    /// A line of its own.
    pub(super) fn message(&self, words: &str) {
        self.say("message", words, serde_json::json!({ "message": words }));
    }

    /// What was repaired or cannot be meant.
    pub(super) fn warning(&self, words: &str) {
        self.say("warning", &format!("warning: {words}"), serde_json::json!({ "message": words }));
    }

    /// How it ended.
    pub(super) fn done(&self, words: &str, fields: serde_json::Value) {
        self.say("done", words, fields);
    }

    /// Files that were written.
    pub(super) fn wrote(&self, files: &[String]) {
        self.say("wrote", &format!("wrote {}", files.join(", ")), serde_json::json!({ "files": files }));
    }

    fn set_step(&self, step: Option<Step>) {
        let (current, changed) = &*self.step;
        *current.lock().unwrap_or_else(PoisonError::into_inner) = step;
        changed.notify_all();
    }
}

impl Drop for Narrator {
    fn drop(&mut self) {
        self.set_step(None);
        self.bar.finish_and_clear();
    }
}

/// Tell steps that take long, until there are no more.
fn tell_long_steps((current, changed): &(Mutex<Option<Step>>, Condvar)) {
    let mut step = current.lock().unwrap_or_else(PoisonError::into_inner);
    // before the first one
    while step.is_none() {
        let waited = changed.wait_timeout(step, PLAIN).unwrap_or_else(PoisonError::into_inner);
        step = waited.0;
        if waited.1.timed_out() && step.is_none() {
            return;
        }
    }
    let mut told: Option<&'static str> = None;
    while let Some(Step { what, since }) = *step {
        if since.elapsed() >= PLAIN && told != Some(what) {
            tell(format_args!("joton: {what} …"));
            told = Some(what);
        }
        let waited = changed.wait_timeout(step, PLAIN).unwrap_or_else(PoisonError::into_inner);
        step = waited.0;
    }
}

/// What a bar says of a render: at most 45 characters.
fn line(p: &Progress<'_>, seconds: f64, seconds_left: Option<f64>) -> String {
    let error = p.error.map_or(String::new(), |e| format!(", error {:.2} %", e.total * 100.0));
    let left = seconds_left.map_or(String::new(), |s| format!(", {} left", duration(s)));
    format!("{}, {}{error}{left}", passes(p.passes), duration(seconds))
}

/// So many passes.
pub(super) fn passes(count: u64) -> String {
    if count == 1 { "1 pass".into() } else { format!("{count} passes") }
}

/// Seconds, minutes and hours, three digits or so.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{s:.1} s"),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 5970.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_times_read_well() {
        assert_eq!([0, 1, 2].map(passes), ["0 passes", "1 pass", "2 passes"]);
        let read = [0.04, 9.94, 9.96, 99.4, 99.6, 5969.0, 5971.0].map(duration);
        assert_eq!(read, ["0.0 s", "9.9 s", "10 s", "99 s", "2 min", "99 min", "1.7 h"]);
    }
}

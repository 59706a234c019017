//! Plot: error over time, log-log, a panel for each scene, one legend for all.
//!
//! SVG, because its text is set by whoever shows it: nothing here needs a font. On white, so that it reads on a dark page
//! as well as on a light one.

use super::{Clock, Summary};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error as StdError;
use std::ops::Range;

/// Width of a picture of three panels in a row, pixels: what a page of text has room for.
const WIDTH: u32 = 900;
/// Most panels in a row.
const COLUMNS: usize = 3;
/// Height of a panel, pixels.
const HEIGHT: u32 = 310;
/// Room of a panel around its axes, pixels: left, right, above, below.
const LEFT: i32 = 52;
const RIGHT: i32 = 14;
const ABOVE: i32 = 42;
const BELOW: i32 = 46;
/// Sizes of text, pixels.
const TEXT: i32 = 13;
const TITLE: i32 = 16;
/// What a letter is wide in the legend at most, pixels: the font is not known.
const LETTER: i32 = 8;
/// Line and gaps of an entry of the legend, pixels.
const SAMPLE: i32 = 24;
const GAP: i32 = 8;
/// Height of a row of the legend, pixels.
const ROW: i32 = 24;
/// Colours that the colour-blind tell apart: Okabe and Ito, "Color Universal Design" (2008).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(0, 0, 0),
    RGBColor(240, 228, 66),
];
const INK: RGBColor = RGBColor(40, 40, 40);
const GRID: RGBColor = RGBColor(222, 222, 222);
/// Room around the points, as a factor.
const MARGIN: f64 = 1.3;
/// The least range of an axis, as a factor: the widest gap between the ticks 1, 2, 5, 10 is 2.5, so that one is in it.
const RANGE_MIN: f64 = 4.0;
/// From this range on an axis has a tick for each power of ten, below it at 1, 2 and 5 times each.
const DECADES: f64 = 100.0;

/// The name of an axis of time.
fn name_of(clock: Clock) -> &'static str {
    match clock {
        Clock::Cpu => "CPU seconds",
        Clock::Wall => "seconds",
    }
}

/// A point of a curve: time and error.
type Point = (f64, f64);
type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn StdError>>;

/// Error over time as an SVG picture, by one clock or by several; an error in the plotting library's words.
pub fn error_plot(summaries: &[Summary], clocks: &[Clock]) -> Result<String, String> {
    draw(summaries, clocks).map_err(|e| e.to_string())
}

fn draw(summaries: &[Summary], clocks: &[Clock]) -> Result<String, Box<dyn StdError>> {
    let scenes = distinct(summaries.iter().map(|s| s.scene.as_str()));
    let devices = distinct(summaries.iter().map(|s| s.device.as_str()));
    let names: Vec<String> = devices
        .iter()
        .filter_map(|device| summaries.iter().find(|s| s.device == *device))
        .map(|s| plain_name(&s.device, &s.device_name))
        .collect();
    let panels: Vec<(&str, Clock)> =
        scenes.iter().flat_map(|scene| clocks.iter().map(|clock| (*scene, *clock))).collect();
    // clocks of a scene lie side by side
    let columns = if clocks.len() > 1 { clocks.len() } else { panels.len().clamp(1, COLUMNS) };
    let rows = panels.len().div_ceil(columns).max(1);
    let legend = legend_places(&names);
    let below = legend.last().map_or(0, |last| last.1 + ROW);
    let mut svg = String::new();
    {
        let size = (WIDTH, HEIGHT * rows as u32 + below as u32 + GAP as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let (top, rest) = root.split_vertically(below + GAP);
        for (i, (name, place)) in names.iter().zip(&legend).enumerate() {
            draw_entry(&top, name, *place, COLOURS[i % COLOURS.len()])?;
        }
        for ((scene, clock), panel) in panels.iter().zip(rest.split_evenly((rows, columns))) {
            let curve = |device: &&str| points(summaries, scene, device, *clock);
            let curves: Vec<Vec<Point>> = devices.iter().map(curve).collect();
            let by_reference = summaries.iter().any(|s| s.scene == **scene && s.rel_mse.is_some());
            let error = if by_reference { "relMSE" } else { "estimated relMSE" };
            draw_panel(&panel, scene, name_of(*clock), error, &curves)?;
        }
        root.present()?;
    }
    Ok(svg)
}

/// A device in words that do not need the manual.
fn plain_name(device: &str, device_name: &str) -> String {
    match device {
        // as the device tells itself: NAME (software, Vulkan, DRIVER)
        "gpu" => match device_name.split_once("(software, ").and_then(|(_, api)| api.split_once(',')) {
            Some((api, _)) => format!("joton, gpu (software {api})"),
            None => "joton, gpu".into(),
        },
        "cpu" => "joton, cpu".into(),
        "cpu-reference" => "path tracer".into(),
        _ => device.into(),
    }
}

/// Where entries of the legend begin, in rows as wide as the picture.
fn legend_places(names: &[String]) -> Vec<(i32, i32)> {
    let (mut x, mut y) = (LEFT, GAP);
    let place = |name: &String| {
        let width = SAMPLE + GAP + LETTER * name.chars().count() as i32 + GAP;
        if x > LEFT && x + width > WIDTH as i32 {
            (x, y) = (LEFT, y + ROW);
        }
        let at = (x, y);
        x += width;
        at
    };
    names.iter().map(place).collect()
}

fn draw_entry(area: &Panel<'_>, name: &str, (x, y): (i32, i32), colour: RGBColor) -> Drawn {
    let middle = y + ROW / 2;
    area.draw(&PathElement::new([(x, middle), (x + SAMPLE, middle)], colour.stroke_width(3)))?;
    let style = text(TEXT, HPos::Left, VPos::Center);
    Ok(area.draw(&Text::new(name, (x + SAMPLE + GAP, middle), style))?)
}

fn draw_panel(panel: &Panel<'_>, scene: &str, time: &str, error: &str, curves: &[Vec<Point>]) -> Drawn {
    let (width, height) = panel.dim_in_pixel();
    let (right, bottom) = (width as i32 - RIGHT, height as i32 - BELOW);
    let all = || curves.iter().flatten();
    let (times, errors) = (range(all().map(|p| p.0)), range(all().map(|p| p.1)));
    let x = |time: f64| LEFT + (share(&times, time) * f64::from(right - LEFT)).round() as i32;
    let y = |error: f64| bottom - (share(&errors, error) * f64::from(bottom - ABOVE)).round() as i32;

    let say =
        |what: String, at: (i32, i32), style: TextStyle<'static>| panel.draw(&Text::new(what, at, style));
    for tick in ticks(&times) {
        panel.draw(&PathElement::new([(x(tick), ABOVE), (x(tick), bottom)], GRID))?;
        say(label(tick), (x(tick), bottom + 6), text(TEXT, HPos::Center, VPos::Top))?;
    }
    for tick in ticks(&errors) {
        panel.draw(&PathElement::new([(LEFT, y(tick)), (right, y(tick))], GRID))?;
        say(label(tick), (LEFT - 6, y(tick)), text(TEXT, HPos::Right, VPos::Center))?;
    }
    panel.draw(&Rectangle::new([(LEFT, ABOVE), (right, bottom)], INK))?;
    say(scene.into(), ((LEFT + right) / 2, 4), text(TITLE, HPos::Center, VPos::Top))?;
    say(error.into(), (4, ABOVE - 6), text(TEXT, HPos::Left, VPos::Bottom))?;
    say(time.into(), ((LEFT + right) / 2, bottom + 24), text(TEXT, HPos::Center, VPos::Top))?;

    for (i, curve) in curves.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let places: Vec<(i32, i32)> = curve.iter().map(|p| (x(p.0), y(p.1))).collect();
        for place in &places {
            panel.draw(&Circle::new(*place, 3, colour.filled()))?;
        }
        if places.len() > 1 {
            panel.draw(&PathElement::new(places, colour.stroke_width(2)))?;
        }
    }
    Ok(())
}

fn text(size: i32, across: HPos, down: VPos) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(&INK).pos(Pos::new(across, down))
}

/// What a logarithmic axis can show of a device on a scene, by time.
fn points(summaries: &[Summary], scene: &str, device: &str, clock: Clock) -> Vec<Point> {
    let of_curve = summaries.iter().filter(|s| s.scene == scene && s.device == device);
    let mut points: Vec<Point> = of_curve
        .filter_map(|s| Some((clock.read(s.seconds, s.cpu_seconds), s.error()?)))
        .filter(|p| [p.0, p.1].iter().all(|x| x.is_finite() && *x > 0.0))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// What holds all values, with room around; one decade where there are none.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (lo, hi) = values.fold((f64::INFINITY, 0.0_f64), |(lo, hi), v| (lo.min(v), hi.max(v)));
    if lo > hi {
        return 0.1..1.0;
    }
    let factor = (RANGE_MIN / (hi / lo)).sqrt().max(MARGIN);
    lo / factor..hi * factor
}

/// How far along a logarithmic axis a value lies, 0 to 1.
fn share(range: &Range<f64>, value: f64) -> f64 {
    (value / range.start).ln() / (range.end / range.start).ln()
}

/// Round values in a range: powers of ten, and where these are few, 2 and 5 times them.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let steps: &[u8] = if range.end / range.start < DECADES { &[1, 2, 5] } else { &[1] };
    let decades = range.start.log10().floor() as i32..=range.end.log10().floor() as i32;
    // as text, so that 1e-5 is the number that is printed so
    let of_decade = |d: i32| steps.iter().filter_map(move |step| format!("{step}e{d}").parse().ok());
    decades.flat_map(of_decade).filter(|tick| range.contains(tick)).collect()
}

/// A tick as it is read most easily.
fn label(tick: f64) -> String {
    if (1e-2..1e4).contains(&tick) { format!("{tick}") } else { format!("{tick:e}") }
}

/// Each name once, in the order of their first appearance.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = Vec::new();
    for name in names {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(scene: &str, device: &str, device_name: &str, seconds: f64, error: f64) -> Summary {
        Summary {
            scene: scene.into(),
            device: device.into(),
            device_name: device_name.into(),
            step: seconds,
            seeds: 1,
            seconds,
            cpu_seconds: 2.0 * seconds,
            passes: 1.0,
            rel_mse: Some(error),
            estimated_rel_mse: None,
            rel_bias_squared: None,
            rel_variance: None,
        }
    }

    /// Texts of a plot, in the order of the file.
    fn texts(plot: &str) -> Vec<String> {
        let document = roxmltree::Document::parse(plot).expect("SVG");
        let texts = document.descendants().filter(|node| node.has_tag_name("text"));
        texts.filter_map(|node| Some(node.text()?.trim().to_owned())).collect()
    }

    /// Whoever sees the plot reads what was measured without knowing what it was asked for by.
    #[test]
    fn devices_have_plain_names() {
        let software = "llvmpipe (LLVM 15.0.6, 256 bits) (software, Vulkan, llvmpipe Mesa 22.3.6)";
        assert_eq!(plain_name("gpu", software), "joton, gpu (software Vulkan)");
        assert_eq!(plain_name("gpu", "GeForce (GPU, Vulkan, NVIDIA 550)"), "joton, gpu");
        assert_eq!(plain_name("cpu", "CPU, 2 threads"), "joton, cpu");
        assert_eq!(plain_name("cpu-reference", "CPU path tracer, 2 threads"), "path tracer");
        assert_eq!(plain_name("mitsuba-path", "Mitsuba"), "mitsuba-path");
    }

    /// Every axis has a tick, and a range of many decades has no more than one for each.
    #[test]
    fn axes_have_round_ticks() {
        assert_eq!(ticks(&(0.5..20.0)), [0.5, 1.0, 2.0, 5.0, 10.0]);
        assert_eq!(ticks(&(3e-5..0.2)), [1e-4, 1e-3, 1e-2, 1e-1]);
        for value in [1.0, 2.1, 5.5, 9.9, 3e-7, 4e5] {
            let one = range([value].into_iter());
            assert!(one.contains(&value) && !ticks(&one).is_empty(), "{value}: {one:?}");
        }
        assert!(!ticks(&range([].into_iter())).is_empty());
        assert_eq!([1e-5, 2e-3, 0.01, 1.0, 50.0, 2e4].map(label), ["1e-5", "2e-3", "0.01", "1", "50", "2e4"]);
    }

    /// Values and pixels: what is ten times as far on a logarithmic axis of two decades is half way along.
    #[test]
    fn shares_are_logarithmic() {
        assert!((share(&(1e-4..1e-2), 1e-3) - 0.5).abs() < 1e-12);
        assert_eq!(share(&(2.0..8.0), 2.0), 0.0);
    }

    /// Three scenes by one clock lie in a row 900 pixels wide; one legend names each device once; a longer time lies
    /// farther right, and a smaller error farther down.
    #[test]
    fn scenes_lie_in_a_row_under_one_legend() {
        let mut summaries = Vec::new();
        for scene in ["cornell", "spheres", "pool"] {
            for (seconds, error) in [(1.0, 1e-2), (4.0, 1e-3)] {
                summaries.push(summary(scene, "cpu", "CPU, 2 threads", seconds, error));
                summaries.push(summary(scene, "cpu-reference", "", seconds, 10.0 * error));
            }
        }
        let plot = error_plot(&summaries, &[Clock::Cpu]).expect("a plot");
        let document = roxmltree::Document::parse(&plot).expect("SVG");
        let number = |node: &roxmltree::Node<'_, '_>, name| -> f64 {
            node.attribute(name).and_then(|a| a.parse().ok()).expect("a number")
        };
        let root = document.root_element();
        assert_eq!([number(&root, "width"), number(&root, "height")], [900.0, 350.0]);
        let circles: Vec<_> = document.descendants().filter(|node| node.has_tag_name("circle")).collect();
        assert_eq!(circles.len(), 12);
        for (panel, pair) in circles.chunks(2).enumerate() {
            let [x, y] = ["cx", "cy"].map(|name| [number(&pair[0], name), number(&pair[1], name)]);
            assert!(x[0] < x[1] && y[0] < y[1], "{x:?} {y:?}");
            // two curves in each panel
            let columns = (panel / 2) as f64 * 300.0..(panel / 2 + 1) as f64 * 300.0;
            assert!(columns.contains(&x[0]) && columns.contains(&x[1]), "panel {}: {x:?}", panel / 2);
        }
        let texts = texts(&plot);
        let count = |text: &str| texts.iter().filter(|t| *t == text).count();
        for (text, times) in
            [("joton, cpu", 1), ("path tracer", 1), ("pool", 1), ("relMSE", 3), ("CPU seconds", 3)]
        {
            assert_eq!(count(text), times, "{text} in {texts:?}");
        }
        let both = error_plot(&summaries, &[Clock::Cpu, Clock::Wall]).expect("a plot");
        assert_eq!(both.matches("<circle").count(), 24, "in panels of both clocks");
    }

    /// A legend wider than the picture goes on in another row, and no entry begins beyond its edge.
    #[test]
    fn a_long_legend_has_rows() {
        let names: Vec<String> = (0..12).map(|i| format!("another renderer {i}")).collect();
        let places = legend_places(&names);
        assert!(places.iter().all(|p| p.0 < WIDTH as i32), "{places:?}");
        let rows: std::collections::BTreeSet<i32> = places.iter().map(|p| p.1).collect();
        assert!(rows.len() > 1);
        let places: std::collections::BTreeSet<_> = places.into_iter().collect();
        assert_eq!(places.len(), names.len(), "each has a place of its own");
    }
}

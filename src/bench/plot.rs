//! Plot: error over processor seconds and over seconds, log-log, one row of panels for each scene.
//!
//! SVG, because its text is set by whoever shows it: nothing here needs a font.

use super::Summary;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error as StdError;

/// Size of a panel, pixels.
const PANEL: (u32, u32) = (640, 440);
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
/// Room around the points, as a factor.
const MARGIN: f64 = 1.3;

/// Ticks wanted on an axis; fewer would leave a range within one decade without any.
const TICKS: usize = 16;

/// A point of a curve: time and error.
type Point = (f64, f64);

/// What is on an axis of time, and how to read it.
struct Axis {
    name: &'static str,
    of: fn(&Summary) -> f64,
}

/// Error against time as an SVG picture; an error in the plotting library's words.
pub fn error_plot(summaries: &[Summary]) -> Result<String, String> {
    draw(summaries).map_err(|e| e.to_string())
}

fn draw(summaries: &[Summary]) -> Result<String, Box<dyn StdError>> {
    let axes = [
        Axis { name: "processor seconds", of: |s| s.cpu_seconds },
        Axis { name: "seconds", of: |s| s.seconds },
    ];
    let scenes = distinct(summaries.iter().map(|s| s.scene.as_str()));
    let devices = distinct(summaries.iter().map(|s| s.device.as_str()));
    let mut svg = String::new();
    {
        let size = (PANEL.0 * axes.len() as u32, PANEL.1 * scenes.len().max(1) as u32);
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let panels = root.split_evenly((scenes.len().max(1), axes.len()));
        for (i, panel) in panels.iter().enumerate() {
            let Some(scene) = scenes.get(i / axes.len()) else { continue };
            let axis = &axes[i % axes.len()];
            let curves: Vec<(usize, &str, Vec<Point>)> = devices
                .iter()
                .enumerate()
                .map(|(colour, device)| (colour, *device, points(summaries, scene, device, axis)))
                .filter(|(_, _, points)| !points.is_empty())
                .collect();
            let by_reference = summaries.iter().any(|s| s.scene == **scene && s.rel_mse.is_some());
            let error = if by_reference { "relMSE" } else { "estimated relMSE" };
            draw_panel(panel, scene, axis.name, error, &curves)?;
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw_panel(
    panel: &DrawingArea<SVGBackend<'_>, Shift>,
    scene: &str,
    time: &str,
    error: &str,
    curves: &[(usize, &str, Vec<Point>)],
) -> Result<(), Box<dyn StdError>> {
    let all = || curves.iter().flat_map(|c| c.2.iter().copied());
    let x = range(all().map(|p| p.0));
    let y = range(all().map(|p| p.1));
    let mut chart = ChartBuilder::on(panel)
        .caption(scene, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(72)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.15))
        .x_labels(TICKS)
        .y_labels(TICKS)
        .x_desc(time)
        .y_desc(error)
        .x_label_formatter(&|v| format!("{v}"))
        .y_label_formatter(&|v| format!("{v:.0e}"))
        .draw()?;
    for (colour, device, points) in curves {
        let colour = COLOURS[colour % COLOURS.len()];
        chart
            .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?
            .label(*device)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
        chart.draw_series(points.iter().map(|p| Circle::new(*p, 4, colour.filled())))?;
    }
    if !curves.is_empty() {
        // errors fall from the upper left: the lower left stays free
        let corner = SeriesLabelPosition::LowerLeft;
        let mut legend = chart.configure_series_labels();
        legend.position(corner).background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw()?;
    }
    Ok(())
}

/// What a logarithmic axis can show of a device on a scene, by time.
fn points(summaries: &[Summary], scene: &str, device: &str, axis: &Axis) -> Vec<Point> {
    let of_curve = summaries.iter().filter(|s| s.scene == scene && s.device == device);
    let mut points: Vec<Point> = of_curve
        .filter_map(|s| Some(((axis.of)(s), s.error()?)))
        .filter(|p| [p.0, p.1].iter().all(|x| x.is_finite() && *x > 0.0))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// What holds all values, with room around; one decade where there are none.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (lo, hi) = values.fold((f64::INFINITY, 0.0_f64), |(lo, hi), v| (lo.min(v), hi.max(v)));
    if lo > hi { 0.1..1.0 } else { lo / MARGIN..hi * MARGIN }
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

//! Rows of the tables.

use super::Effort;
use super::measure::{Pair, Subject};
use super::twins::Case;
use joton::plan::Part;

/// Head of the table of what is skipped.
pub const HEAD: &str = "| skip | scene | CPU ms a pass, skipped | kept | kept/skipped | relMSE, skipped | kept | time to equal \
                        error, kept/skipped | images |\n|---|---|---|---|---|---|---|---|---|";

/// Head of the table of what is needed.
pub const NEEDED_HEAD: &str =
    "| part | scene | plan, CPU ms | with the part kept | same plan | same bits |\n|---|---|---|---|---|---|";

const MILLISECONDS: f64 = 1e3;

/// A skip where it applies.
pub fn skipped(effort: &Effort, part: Part, case: &Case) -> joton::Result<String> {
    row(part.name(), effort, case, &[part])
}

/// All skips of a scene.
pub fn together(effort: &Effort, case: &Case, keep: &[Part]) -> joton::Result<String> {
    row("**all**", effort, case, keep)
}

fn row(name: &str, effort: &Effort, case: &Case, keep: &[Part]) -> joton::Result<String> {
    eprintln!("{name}: {}", case.name);
    let subject = Subject::new(effort, case)?;
    let Pair { costs: [skipped, kept], ratio, same_bits } = subject.pair(keep)?;
    let (errors, equal_error, images) = if same_bits {
        ("the same | the same".to_string(), ratio[0], "same bits".to_string())
    } else {
        let errors = format!("{:.2e} | {:.2e}", skipped.rel_mse, kept.rel_mse);
        // noise falls with the passes
        (errors, ratio[0] * kept.rel_mse / skipped.rel_mse, format!("p = {:.2}", subject.p_value(keep)?))
    };
    Ok(format!(
        "| {name} | {} | {:.1} | {:.1} | {:.2} ({:.2}–{:.2}) | {errors} | {equal_error:.2} | {images} |",
        case.name,
        skipped.pass * MILLISECONDS,
        kept.pass * MILLISECONDS,
        ratio[0],
        ratio[1],
        ratio[2],
    ))
}

/// A part where it is needed: keeping it must be what is done anyway.
pub fn needed(effort: &Effort, part: Part, case: &Case) -> joton::Result<String> {
    eprintln!("{} needed: {}", part.name(), case.name);
    let subject = Subject::new(effort, case)?;
    let [(own, own_seconds), (kept, kept_seconds)] = [&[][..], &[part]].map(|keep| subject.timed_plan(keep));
    let same = (own.layers, own.features, own.caustic_jotons, own.diffuse_jotons, own.settings.shadow_rays)
        == (kept.layers, kept.features, kept.caustic_jotons, kept.diffuse_jotons, kept.settings.shadow_rays)
        && own.skipped == kept.skipped;
    let yes = |is: bool| if is { "yes" } else { "no" };
    Ok(format!(
        "| {} | {} | {:.1} | {:.1} | {} | {} |",
        part.name(),
        case.name,
        own_seconds * MILLISECONDS,
        kept_seconds * MILLISECONDS,
        yes(same),
        yes(subject.is_same_with(&[part])?)
    ))
}

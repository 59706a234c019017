//! `joton slurm SCENE`: scripts that render a scene on a cluster: an array of tasks, a part of the passes each, and a job that merges
//! the parts.

use super::bands;
use super::checkpoint::absolute;
use super::device::check_reference;
use super::render::{self, RenderArguments};
use super::{Arguments, Command as Subcommand, DONE, say};
use clap::{Args, Parser};
use joton::output;
use joton::render::PassRange;
use joton::{Error, Result};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Arguments of `joton slurm`.
#[derive(Debug, Args)]
pub(super) struct SlurmArguments {
    /// A scene file (.toml) or a mesh (.obj), where all nodes see it.
    scene: PathBuf,
    /// Tasks, at most; each renders a part of the passes.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    tasks: u64,
    /// Passes of all tasks together.
    #[arg(long, value_name = "N")]
    passes: u64,
    /// Where the picture goes: .exr or .png; may be repeated [default: SCENE's name, .png and .exr, in the current folder].
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Folder of scripts, parts and logs, where all nodes see it [default: SCENE's name, .slurm].
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// An option of sbatch for the tasks that render, like --sbatch=--gres=gpu:1; may be repeated.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Submit both jobs, not only write them.
    #[arg(long)]
    submit: bool,
    /// Options of joton render for every task, behind --.
    #[arg(last = true, value_name = "OPTION")]
    options: Vec<OsString>,
}

/// Seconds before the end of a task's time at which it keeps what it has and asks for more.
const NOTICE: u32 = 60;

pub(super) fn run(a: &SlurmArguments) -> Result<u8> {
    let (outputs, threads) = checked(a)?;
    let tasks = Tasks::new(a.passes, a.tasks)?;
    let folder = match &a.folder {
        Some(folder) => folder.clone(),
        None => PathBuf::from(a.scene.file_stem().unwrap_or_default()).with_extension("slurm"),
    };
    for path in &outputs {
        render::kind_of(path)?;
    }
    // what is wrong is told here, and not by each task, nor by the merge when all have rendered
    render::check_outputs(&a.scene, outputs.iter())?;
    let scene = absolute(&a.scene)?;
    let read = joton::scene::load(&scene)?.files;
    output::check_not_read(&outputs, &read)?;
    std::fs::create_dir_all(&folder).map_err(|e| Error::system(&folder, "create", &e))?;
    let folder = absolute(&folder)?;
    let outputs: Vec<PathBuf> = outputs.iter().map(|path| absolute(path)).collect::<Result<_>>()?;
    let program = std::env::current_exe().map_err(|e| Error::system(Path::new("joton"), "find", &e))?;
    let scripts = Scripts { program, scene, folder, outputs, tasks, threads, a };
    let [array, merge] = scripts.write()?;
    let first_and_last = [0, scripts.tasks.count - 1].map(|task| scripts.tasks.range(task));
    say(format_args!(
        "{} tasks of {} passes, {} to {}",
        scripts.tasks.count, scripts.tasks.each, first_and_last[0], first_and_last[1]
    ));
    if a.submit {
        let id = sbatch(&[array.as_os_str().into()])?;
        let dependency = format!("--dependency=afterok:{id}");
        let merge_id = sbatch(&[dependency.into(), "--kill-on-invalid-dep=yes".into(), merge.into()])?;
        say(format_args!("job {id} renders, job {merge_id} merges"));
    } else {
        say(format_args!("sbatch --parsable {}", quoted(&array)));
        say(format_args!(
            "sbatch --dependency=afterok:ID --kill-on-invalid-dep=yes {}   # ID: what the first one printed",
            quoted(&merge)
        ));
    }
    Ok(DONE)
}

/// Where the picture goes, and threads of each task; refuses options that no task could be told.
fn checked(a: &SlurmArguments) -> Result<(Vec<PathBuf>, Option<u16>)> {
    let words = ["joton", "render", "--pass-range", "0..1", "--checkpoint", "part"].map(OsString::from);
    let words = words.into_iter().chain(a.options.iter().cloned());
    let refuse =
        |what: String| Error::usage(format!("options of joton render: {what}"), "see joton render --help");
    let told = Arguments::try_parse_from(words.chain(["--".into(), a.scene.clone().into()]));
    let told =
        told.map_err(|e| refuse(super::refuse(&e).err().unwrap_or_else(|| "they render nothing".into())))?;
    let threads = told.threads;
    match told.command {
        Subcommand::Render(told) if told.output.is_empty() => {
            told.settings()?;
            render::checked_stop(&told)?;
            bands::check(&told, &a.output)?;
            check_reference(&told.device, told.reference)?;
            if told.report.is_some() {
                let what = "--report: all tasks would write one file";
                return Err(Error::usage(what, "leave it out; the merge writes report.json in the folder"));
            }
            let mut whole: RenderArguments = *told;
            (whole.pass_range, whole.output) = (None, a.output.clone());
            Ok((whole.outputs(), threads))
        }
        _ => Err(Error::usage("a task has no picture", "give -o before the --")),
    }
}

/// The passes in parts of equal length, but for the last.
struct Tasks {
    passes: u64,
    each: u64,
    count: u64,
}

impl Tasks {
    fn new(passes: u64, most: u64) -> Result<Self> {
        // so few that no number below overflows
        PassRange::new(0, passes)?;
        // no part begins elsewhere
        let each = passes.div_ceil(most).next_multiple_of(PassRange::HEAD);
        Ok(Self { passes, each, count: passes.div_ceil(each) })
    }

    fn range(&self, task: u64) -> String {
        let first = task * self.each;
        format!("{first}..{}", (first + self.each).min(self.passes))
    }
}

struct Scripts<'a> {
    program: PathBuf,
    scene: PathBuf,
    folder: PathBuf,
    outputs: Vec<PathBuf>,
    tasks: Tasks,
    threads: Option<u16>,
    a: &'a SlurmArguments,
}

impl Scripts<'_> {
    /// Write both; where they are.
    fn write(&self) -> Result<[PathBuf; 2]> {
        let [array, merge] = ["render.sh", "merge.sh"].map(|name| self.folder.join(name));
        let text = self.array();
        self.check_parts(&array, &text)?;
        let merge_text = self.merge();
        let part = |path: &PathBuf, text: String| -> output::Part<'_> {
            (path.clone(), Box::new(move || text.into_bytes()))
        };
        output::write_set(vec![part(&array, text), part(&merge, merge_text)])?;
        Ok([array, merge])
    }

    /// Refuse to go on with parts that other tasks rendered: they go on as they were told.
    fn check_parts(&self, array: &Path, text: &str) -> Result<()> {
        let Ok(before) = std::fs::read_to_string(array) else { return Ok(()) };
        let files = std::fs::read_dir(&self.folder).map_err(|e| Error::system(&self.folder, "read", &e))?;
        let is_part = |file: &std::fs::DirEntry| file.path().extension().is_some_and(|kind| kind == "joton");
        let work = |script: &str| -> Vec<String> {
            script.lines().filter(|line| !line.starts_with('#')).map(String::from).collect()
        };
        if files.flatten().any(|file| is_part(&file)) && work(&before) != work(text) {
            let what = format!("{}: holds parts of a render that was told otherwise", self.folder.display());
            return Err(Error::usage(what, "name another --folder, or remove this one"));
        }
        Ok(())
    }

    /// The first lines of both.
    fn head(&self, what: &str, log: &str) -> String {
        let name = self.scene.file_stem().unwrap_or_default().to_string_lossy();
        let word: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        // a percent sign names a job's or a task's number
        let log = self.folder.join(log).to_string_lossy().into_owned();
        let folder = self.folder.to_string_lossy();
        let log = log.replacen(&*folder, &folder.replace('%', "%%"), 1);
        format!(
            "#!/bin/sh\n#SBATCH --job-name={word}-{what}\n#SBATCH --output=\"{log}\"\n#SBATCH --open-mode=append\n"
        )
    }

    fn array(&self) -> String {
        let Self { tasks, .. } = self;
        let options: String = self.a.sbatch.iter().map(|option| format!("#SBATCH {option}\n")).collect();
        let told: String = self.a.options.iter().map(|word| format!(" {}", quoted(word))).collect();
        format!(
            r#"{head}#SBATCH --array=0-{last}
#SBATCH --requeue
#SBATCH --signal=B:USR1@{NOTICE}
{options}# Passes of one task of {count}. A task that was killed, or had no time left, goes on from what it kept.
first=$((SLURM_ARRAY_TASK_ID * {each}))
end=$((first + {each}))
[ "$end" -le {passes} ] || end={passes}
part={folder}/part-$SLURM_ARRAY_TASK_ID.joton
no_time=
if [ -e "$part" ]; then
    {program}{threads} resume "$part" &
else
    {program} render {scene} --pass-range "$first..$end" --checkpoint "$part"{told} &
fi
joton=$!
trap 'kill -TERM $joton' TERM INT
trap 'no_time=1; kill -TERM $joton' USR1
# a signal ends wait, but not joton
while :; do
    wait $joton
    code=$?
    kill -0 $joton 2>/dev/null || break
done
if [ -n "$no_time" ] && [ $code -ne 0 ]; then
    scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
fi
exit $code
"#,
            threads = self.threads.map_or(String::new(), |n| format!(" --threads {n}")),
            head = self.head("render", "render-%a.log"),
            last = tasks.count - 1,
            count = tasks.count,
            each = tasks.each,
            passes = tasks.passes,
            folder = quoted(&self.folder),
            program = quoted(&self.program),
            scene = quoted(&self.scene),
        )
    }

    fn merge(&self) -> String {
        let outputs: String = self.outputs.iter().map(|path| format!(" -o {}", quoted(path))).collect();
        format!(
            "{head}# After all tasks: their parts are one picture.\nexec {program} merge {folder}/part-*.joton{outputs} --report {folder}/report.json\n",
            head = self.head("merge", "merge.log"),
            program = quoted(&self.program),
            folder = quoted(&self.folder),
        )
    }
}

/// Submit a script; the job's number.
fn sbatch(words: &[OsString]) -> Result<String> {
    let ended = Command::new("sbatch").arg("--parsable").args(words).output().map_err(|e| {
        Error::usage(
            format!("sbatch does not run: {e}"),
            "submit where Slurm is installed, or leave out --submit",
        )
    })?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).split_whitespace().collect::<Vec<_>>().join(" ");
    if !ended.status.success() {
        return Err(Error::usage(format!("sbatch: {}", text(&ended.stderr)), "submit the scripts by hand"));
    }
    // NUMBER, or NUMBER;CLUSTER
    Ok(text(&ended.stdout).split(';').next().unwrap_or_default().to_string())
}

/// A word of a shell's.
fn quoted(word: impl AsRef<std::ffi::OsStr>) -> String {
    let word = word.as_ref().to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,%@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.into_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

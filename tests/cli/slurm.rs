//! The scripts that `joton slurm` writes. What a real Slurm makes of them: scripts/test-slurm.sh.

use crate::folder::{Ended, Folder, bits};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Run a script as a task of Slurm's would be; what `scontrol` and `sbatch` are asked for lands in the file calls.
fn run(folder: &Folder, script: &Path, task: &str) -> bool {
    let bin = folder.path("bin");
    fs::create_dir_all(&bin).expect("a folder");
    for name in ["scontrol", "sbatch"] {
        let program = bin.join(name);
        fs::write(&program, "#!/bin/sh\necho \"$(basename \"$0\") $*\" >>\"$CALLS\"\necho 7\n")
            .expect("written");
        assert!(Command::new("chmod").arg("+x").arg(&program).status().expect("chmod runs").success());
    }
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").expect("a PATH"));
    let mut command = Command::new("sh");
    command.arg(script).env("SLURM_ARRAY_TASK_ID", task).env("SLURM_ARRAY_JOB_ID", "5");
    command.env("PATH", path).env("CALLS", folder.path("calls"));
    command.status().expect("sh runs").success()
}

/// The tasks of an array, in any order, and the merge after them give the picture of one machine; names with spaces and quotes, options of
/// `joton render` with both. A task that is started again goes on.
#[cfg(unix)]
#[test]
fn tasks_make_the_picture() {
    let folder = Folder::new();
    fs::rename(folder.path("cornell.toml"), folder.path("it's a box.toml")).expect("renamed");
    let options = "--size 24x24 --device cpu --seed 2 --paths LD+E";
    let mut command = folder.command("slurm --tasks 3 --passes 70 -o picture.exr --folder");
    command.args(["my jobs", "--sbatch=--time=10", "it's a box.toml", "--"]);
    let written = command.args(options.split(' ')).output().expect("joton runs");
    let told = String::from_utf8(written.stdout).expect("UTF-8");
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    assert!(told.starts_with("3 tasks of 32 passes, 0..32 to 64..70\n"), "{told}");
    let [render, merge] = ["my jobs/render.sh", "my jobs/merge.sh"].map(|name| folder.path(name));
    let script = fs::read_to_string(&render).expect("a script");
    for line in
        ["#SBATCH --array=0-2\n", "#SBATCH --time=10\n", "#SBATCH --requeue\n", "--signal=B:USR1@60\n"]
    {
        assert!(script.contains(line), "{line} is not in\n{script}");
    }
    for task in ["2", "0", "1", "0"] {
        assert!(run(&folder, &render, task), "task {task}");
    }
    assert!(run(&folder, &merge, ""), "the merge");
    assert!(!folder.path("calls").exists(), "nothing was to be requeued");
    // other options of sbatch make no other parts; other passes do
    let again = |passes: &str, more: &str| {
        let mut command =
            folder.command(&format!("slurm --tasks 3 --passes {passes} -o picture.exr --folder"));
        command
            .args(["my jobs", more, "it's a box.toml", "--"])
            .args(options.split(' '))
            .output()
            .expect("joton runs")
    };
    assert!(again("70", "--sbatch=--time=20").status.success());
    let refused = Ended::of(again("80", "--sbatch=--time=20"));
    refused.is_refusal("slurm", &["my jobs: holds parts of a render that was told otherwise", "--folder"]);
    let mut command = folder.command("render --pass-range 0..70 --checkpoint whole.joton -o whole.exr");
    let ended = command.args(options.split(' ')).arg("it's a box.toml").status().expect("joton runs");
    assert!(ended.success());
    assert!(bits(&folder, "picture.exr") == bits(&folder, "whole.exr"));
}

/// A task that is told that its time is over keeps what it has and asks to be started again; one that is told to end keeps it and asks for
/// nothing.
#[cfg(unix)]
#[test]
fn a_task_without_time_asks_for_more() {
    let folder = Folder::new();
    for (signal, asks) in [("USR1", true), ("TERM", false)] {
        folder.done("slurm cornell.toml --tasks 1 --passes 1000000 --folder jobs -o x.exr -- --size 64x64 --device cpu");
        let script = folder.path("jobs/render.sh");
        // sh takes the signals that Slurm sends to the script
        let text = fs::read_to_string(&script).expect("a script");
        let text = text.replacen("joton=$!", &format!("joton=$!\n(sleep 3; kill -{signal} $$) &"), 1);
        fs::write(&script, text).expect("written");
        assert!(!run(&folder, &script, "0"), "it did not end by itself");
        assert!(folder.path("jobs/part-0.joton").exists(), "{signal}: nothing is kept");
        let calls = fs::read_to_string(folder.path("calls")).unwrap_or_default();
        assert_eq!(calls, if asks { "scontrol requeue 5_0\n" } else { "" }, "{signal}");
        for file in ["calls", "jobs/part-0.joton"] {
            fs::remove_file(folder.path(file)).ok();
        }
    }
}

/// What no task could do is refused before anything is written.
#[test]
fn what_no_task_can_do_is_refused() {
    let folder = Folder::new();
    let slurm = "slurm cornell.toml --tasks 4 --passes 64";
    for (words, told) in [
        (format!("{slurm} -- --passes 3"), &["options of joton render", "--passes"][..]),
        (format!("{slurm} -- --sise 3"), &["options of joton render", "--sise"]),
        (format!("{slurm} -- -o x.exr"), &["give -o before the --"]),
        (format!("{slurm} -- --paths XYZ"), &["XYZ"]),
        (format!("{slurm} -- --every 0"), &["--every"]),
        (format!("{slurm} -- --reference"), &["--reference"]),
        (format!("{slurm} -- --report r.json"), &["--report"]),
        (format!("{slurm} -o x.exr -o ./x.exr"), &["./x.exr", "twice"]),
        ("slurm cornell.toml --tasks 1 --passes 18446744073709551615".into(), &["too many passes"]),
        (format!("{slurm} -o x.jpg"), &["x.jpg"]),
        ("slurm none.toml --tasks 4 --passes 64".into(), &["none.toml"]),
        ("slurm cornell.toml --tasks 0 --passes 64".into(), &["--tasks"]),
        ("slurm cornell.toml --tasks 4 --passes 0".into(), &["has no passes"]),
        ("slurm cornell.toml --passes 64".into(), &["--tasks"]),
    ] {
        folder.fails(&words, told);
    }
    assert!(!folder.path("cornell.slurm").exists());
    if Command::new("sbatch").arg("--version").output().is_err() {
        folder.fails(&format!("{slurm} --submit"), &["sbatch does not run", "--submit"]);
    }
}

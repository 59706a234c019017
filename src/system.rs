//! System: what the process asks of its system that has no safe counterpart in the standard library. The only file with
//! unsafe code; each use says why it is sound.
#![allow(unsafe_code)]

/// Layers of Vulkan that a program without a window does not need, each by the variable that switches it off. Mesa's device
/// selection connects to a Wayland or X server to learn which GPU drives the screen; where there is none, libwayland prints
/// "error: XDG_RUNTIME_DIR is invalid or not set in the environment" for every instance. joton sorts devices itself.
const LAYERS_OFF: [(&str, &str); 1] = [("NODEVICE_SELECT", "1")];
/// Variables by which a user asks that layer for a device: then it is loaded.
const LAYER_WANTED: [&str; 2] = ["MESA_VK_DEVICE_SELECT", "DRI_PRIME"];

/// Leave out what only programs with windows need. Call it first of all: no other thread may run.
pub(crate) fn leave_windows_out() {
    let is_set = |name: &&str| std::env::var_os(name).is_some();
    if LAYER_WANTED.iter().any(is_set) {
        return;
    }
    for (name, value) in LAYERS_OFF.iter().filter(|(name, _)| !is_set(name)) {
        // SAFETY: the environment must not be read by another thread meanwhile; main calls this before it starts any.
        unsafe { std::env::set_var(name, value) };
    }
}

/// Mesa's software Vulkan takes so many threads, where the user has not said how many. Call it before any other thread runs.
pub(crate) fn limit_software_devices(threads: u16) {
    const THREADS: &str = "LP_NUM_THREADS";
    if std::env::var_os(THREADS).is_none() {
        // SAFETY: the environment must not be read by another thread meanwhile; main calls this before it starts any.
        unsafe { std::env::set_var(THREADS, threads.to_string()) };
    }
}

/// Let all threads allocate from one heap: what a software device has used to compile a kernel is free for the next one then,
/// whichever thread compiles it. Call it before any other thread runs; those that have a heap of their own keep it.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn share_heap() {
    // SAFETY: it sets a number of the allocator, under its lock; where it does not know it, nothing happens.
    unsafe { libc::mallopt(libc::M_ARENA_MAX, 1) };
}

/// Other allocators are left as they are.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(crate) fn share_heap() {}

/// Give the pages of all heaps back that nothing lies in.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(crate) fn give_back() {
    // SAFETY: the allocator does it under its lock; what is in use stays where it is.
    unsafe { libc::malloc_trim(0) };
}

/// Other allocators are left as they are.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(crate) fn give_back() {}

/// Let `install` set handlers for signals; those that were ignored before, as `nohup` and shells do for programs in the
/// background, are ignored again.
#[cfg(unix)]
pub(crate) fn keep_ignored(install: impl FnOnce()) {
    let ignored: Vec<libc::c_int> =
        [libc::SIGINT, libc::SIGTERM, libc::SIGHUP].into_iter().filter(|s| is_ignored(*s)).collect();
    install();
    for signal in ignored {
        // SAFETY: no function is installed; the call fails for unknown signals only, and then does nothing.
        unsafe { libc::signal(signal, libc::SIG_IGN) };
    }
}

/// Let `install` set handlers for signals.
#[cfg(not(unix))]
pub(crate) fn keep_ignored(install: impl FnOnce()) {
    install();
}

/// Where a file grows larger than the system allows (`ulimit -f`), that is an error of the write, and not the end of the process with all
/// that it has rendered.
#[cfg(unix)]
pub(crate) fn outlive_large_files() {
    // SAFETY: no function is installed; the signal exists on every system that has the call.
    unsafe { libc::signal(libc::SIGXFSZ, libc::SIG_IGN) };
}

/// Only Unix ends processes for that.
#[cfg(not(unix))]
pub(crate) fn outlive_large_files() {}

#[cfg(unix)]
fn is_ignored(signal: libc::c_int) -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action the call only writes the current one, to a struct of its own type that is ours; all zeros
    // is a valid value of it, should the call fail.
    let action = unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr());
        action.assume_init()
    };
    action.sa_sigaction == libc::SIG_IGN
}

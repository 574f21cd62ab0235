//! The settings of glibc's allocator for a service.
//!
//! By itself glibc moves the size from which memory is mapped, and so goes back to the system when it is freed, up to 32 MiB.
//! Then a storm of large scenes holds 1.6 times what is counted; with a fixed size 1.15 times, and with two arenas at most as
//! much as is counted. Only the environment of a
//! process sets it without unsafe code, so the process begins once more, as itself.

/// Begins once more with the settings, unless somebody has set some.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub(super) fn settle() {
    use std::env;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    const NAME: &str = "GLIBC_TUNABLES";
    const SETTINGS: &str =
        "glibc.malloc.mmap_threshold=131072:glibc.malloc.trim_threshold=131072:glibc.malloc.arena_max=2";
    let mut arguments = env::args_os();
    if let (None, Ok(program), Some(name)) = (env::var_os(NAME), env::current_exe(), arguments.next()) {
        // It comes back only if that failed: then memory is bounded less tightly.
        let _ = Command::new(program).arg0(name).args(arguments).env(NAME, SETTINGS).exec();
    }
}

/// Other allocators do not need it.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub(super) fn settle() {}

//! The memory of the machine, or of the container that the service runs in.

use std::fs;

/// Assumed where the system does not say.
const UNKNOWN: u64 = 4 << 30;

/// Bytes: the container's limit (control groups, version 2) or the machine's memory, whichever is less.
pub(crate) fn available() -> u64 {
    let limit = fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| total(&text));
    [limit, machine].into_iter().flatten().min().unwrap_or(UNKNOWN)
}

/// The total in bytes, as `/proc/meminfo` has it in kB.
fn total(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_found() {
        assert_eq!(total("MemFree: 1 kB\nMemTotal:       24632456 kB\n"), Some(24_632_456 << 10));
        assert_eq!(total("MemTotal: much"), None);
        assert!(available() > 64 << 20);
    }
}

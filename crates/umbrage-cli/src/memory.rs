//! How much memory the process has used.
//!
//! Linux has it in a file; what `getrusage` tells there can be the peak of the process that started this one.

/// The most memory that the process has held so far, in bytes, where the system tells.
#[cfg(target_os = "linux")]
pub(crate) fn peak_bytes() -> Option<u64> {
    peak_in(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// The most memory that the process has held so far, in bytes, where the system tells.
#[cfg(all(unix, not(target_os = "linux")))]
pub(crate) fn peak_bytes() -> Option<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let unit_bytes = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
    Some(u64::try_from(getrusage(UsageWho::RUSAGE_SELF).ok()?.max_rss()).ok()? * unit_bytes)
}

/// The most memory that the process has held so far, in bytes, where the system tells.
#[cfg(not(unix))]
pub(crate) fn peak_bytes() -> Option<u64> {
    None
}

/// The line `VmHWM:     1234 kB` of a process' status.
#[cfg(target_os = "linux")]
fn peak_in(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_read() {
        assert_eq!(peak_in("Name:\tumbrage\nVmHWM:\t    1234 kB\nVmRSS:\t 9 kB\n"), Some(1234 * 1024));
        assert_eq!(peak_in("Name:\tumbrage\n"), None);
        assert!(peak_bytes().is_some_and(|bytes| bytes > 100_000));
    }
}

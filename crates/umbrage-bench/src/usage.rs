//! What this process has used so far, as the system tells it.

#[cfg(unix)]
use nix::sys::resource::{Usage, UsageWho, getrusage};

/// Bytes of a unit of `ru_maxrss`.
#[cfg(target_vendor = "apple")]
const MEMORY_UNIT_BYTES: u64 = 1;
/// Bytes of a unit of `ru_maxrss`.
#[cfg(all(unix, not(target_vendor = "apple")))]
const MEMORY_UNIT_BYTES: u64 = 1024;

#[cfg(unix)]
fn usage() -> Option<Usage> {
    getrusage(UsageWho::RUSAGE_SELF).ok()
}

/// Processor time of all threads, in seconds.
#[cfg(unix)]
pub fn cpu_seconds() -> Option<f64> {
    let usage = usage()?;
    Some([usage.user_time(), usage.system_time()].iter().map(|t| t.tv_sec() as f64 + 1e-6 * t.tv_usec() as f64).sum())
}

/// Processor time of all threads, in seconds.
#[cfg(not(unix))]
pub fn cpu_seconds() -> Option<f64> {
    None
}

/// The most memory that was held at a time, in bytes.
#[cfg(unix)]
pub fn peak_bytes() -> Option<u64> {
    Some(u64::try_from(usage()?.max_rss()).ok()? * MEMORY_UNIT_BYTES)
}

/// The most memory that was held at a time, in bytes.
#[cfg(not(unix))]
pub fn peak_bytes() -> Option<u64> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use std::hint::black_box;
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn memory_that_was_held_and_time_that_was_spent_are_counted() {
        const BYTES: usize = 64 << 20;
        let (cpu, peak) = (cpu_seconds().unwrap(), peak_bytes().unwrap());
        let held = black_box(vec![1_u8; BYTES]);
        let begin = Instant::now();
        let mut sum = 0_u64;
        while begin.elapsed() < Duration::from_millis(100) {
            sum += held.iter().step_by(4096).map(|&byte| u64::from(byte)).sum::<u64>();
        }
        black_box((held, sum));
        assert!(peak_bytes().unwrap() >= BYTES as u64 && peak_bytes().unwrap() >= peak);
        assert!(cpu_seconds().unwrap() > cpu);
    }
}

//! What a bake in steps may take: time (`--time-limit`) and memory (`--memory-limit`).
//!
//! Both limits work in the same way. While a step runs, the progress callback asks whether one is reached, and cancels
//! the step if so: what it held is given back, and the step before is the result. What a whole step took tells how much
//! finer the next one can be. Of both a little is left: time for writing the file, memory for what a step takes between
//! two looks and until it ends.
//!
//! The limit of memory is one of what the process has held at most, resident, as the system counts it. That is what the
//! system ends a process for; it has in it what an allocator holds back, stacks and the program itself; and no peak
//! between two looks is missed. A counting allocator would count less, and would cost every bake, also one without a
//! limit. A look costs 10 us, and there is one in 10 ms, and none where there is no limit.

use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use bytesize::ByteSize;

use crate::exit_code::ExitCode;
use crate::method::positive;
use crate::{memory, output, summary};

/// Of a limit of time, so much is left for writing the file, and this share.
const WRITING: Duration = Duration::from_millis(100);
const WRITING_SHARE: f64 = 0.01;
/// Of a limit of memory, so much is left, and this share (which [`TooLittle`] and `umbrage help bake` tell, too).
/// Between two reports of progress scenes at usual tolerances take up to 7 % more; three polygons at a hundredth of
/// them, which grow by 130 MB a second, a quarter now and then, as refinement goes by rounds.
const SPARE_BYTES: u64 = 8 << 20;
const SPARE_SHARE: f64 = 0.125;
/// How often memory is looked at.
const LOOK_EVERY_MS: u64 = 10;
/// How often it is looked at while a scene is read, and nothing reports progress.
const WATCH_EVERY: Duration = Duration::from_millis(2);

/// Which limit ended the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Limit {
    /// Of time.
    Time,
    /// Of memory.
    Memory,
}

/// Shares of the time after which a sketch ends its refinement, and every other step. A round of refinement, what is put together and
/// written must fit into what is left: a quarter is enough for scenes whose last round takes a third of a step.
const SKETCHED: f64 = 0.25;
const REFINED: f64 = 0.75;

/// The limits of a bake; by default there are none.
#[derive(Debug, Default)]
pub(crate) struct Limits {
    until: Option<Instant>,
    /// When a quarter of the time is over, and when most of it is.
    quarter: Option<Instant>,
    most: Option<Instant>,
    memory: Option<MemoryLimit>,
}

/// A limit of memory, and what is known of it.
#[derive(Debug)]
struct MemoryLimit {
    bytes: u64,
    /// What a step may hold, with the rest of the process.
    step_bytes: u64,
    /// What the process had held before it baked.
    before_bytes: u64,
    begin: Instant,
    /// When memory is looked at again, in milliseconds since `begin`.
    next_look_ms: AtomicU64,
    is_passed: AtomicBool,
}

/// A limit was reached before there was any result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TooLittle {
    #[error(
        "the time limit ended before the first and coarsest step, at tolerance {tolerance}, was done: nothing was \
         written. Give it more time, or a greater --tolerance"
    )]
    Time { tolerance: f64 },
    #[error(
        "the memory limit of {}, of which an eighth and 8 MiB stay free, is too small for the first and coarsest step, \
         at tolerance {tolerance}: the process had held {} when it was given up, and {} before it began. Nothing was \
         written. Give it more memory, or a greater --tolerance",
        summary::bytes(*.limit_bytes), summary::bytes(*.held_bytes), summary::bytes(*.before_bytes)
    )]
    Memory { tolerance: f64, limit_bytes: u64, held_bytes: u64, before_bytes: u64 },
}

/// Memory cannot be limited here.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("--memory-limit: this system does not tell how much memory a process has held. Leave it out")]
pub(crate) struct MemoryUnknown;

impl Limits {
    /// Limits of a bake that began at `begin` and now starts with its first step.
    ///
    /// # Errors
    /// [`MemoryUnknown`] where memory is limited that cannot be told.
    pub(crate) fn new(begin: Instant, time: Option<Duration>, memory: Option<ByteSize>) -> Result<Self, MemoryUnknown> {
        let memory = memory.map(|limit| MemoryLimit::new(limit.as_u64())).transpose()?;
        let share = |share: f64| time.and_then(|limit| begin.checked_add(limit.mul_f64(share)));
        let until = time.and_then(|limit| last_moment(begin, limit));
        Ok(Self { until, quarter: share(SKETCHED), most: share(REFINED), memory })
    }

    /// Whether there is any.
    pub(crate) fn is_any(&self) -> bool {
        self.until.is_some() || self.memory.is_some()
    }

    /// Whether time is over.
    pub(crate) fn is_time_over(&self) -> bool {
        self.until.is_some_and(|until| Instant::now() >= until)
    }

    /// Whether the process holds more memory than it may, while stages run that report no progress.
    pub(crate) fn is_memory_over(&self) -> bool {
        self.memory.as_ref().is_some_and(MemoryLimit::look)
    }

    /// Whether so much of a limit is used up that a sketch, which is to be there early, must come to its end.
    pub(crate) fn must_end_sketch(&self) -> bool {
        self.quarter.is_some_and(|quarter| Instant::now() >= quarter)
            || self.memory.as_ref().is_some_and(|memory| memory.room() < 2.0)
    }

    /// Whether so much of the time is over that what is refined must be put together as it is.
    pub(crate) fn must_end_step(&self) -> bool {
        self.most.is_some_and(|most| Instant::now() >= most)
    }

    /// Whether the step that runs is to be cancelled. Called from many threads, often.
    pub(crate) fn is_reached(&self) -> bool {
        self.is_time_over() || self.memory.as_ref().is_some_and(MemoryLimit::look)
    }

    /// Which limit keeps a finer step from being made, where one does.
    pub(crate) fn reached(&self) -> Limit {
        match &self.memory {
            Some(memory) if memory.is_passed.load(Ordering::Relaxed) => Limit::Memory,
            _ => Limit::Time,
        }
    }

    /// So many times what the last step took, in `took_s`, are allowed for the next one; less than 1 where it cannot be
    /// made.
    pub(crate) fn room(&self, took_s: f64) -> f64 {
        let left_s = |until: Instant| until.saturating_duration_since(Instant::now()).as_secs_f64();
        let of_time = self.until.map_or(f64::INFINITY, |until| left_s(until) / took_s);
        of_time.min(self.memory.as_ref().map_or(f64::INFINITY, MemoryLimit::room))
    }

    /// The error where this limit was reached in the first step, at `tolerance`.
    pub(crate) fn too_little(&self, limit: Limit, tolerance: f64) -> TooLittle {
        match (&self.memory, limit) {
            (Some(memory), Limit::Memory) => TooLittle::Memory {
                tolerance,
                limit_bytes: memory.bytes,
                held_bytes: memory::peak_bytes().unwrap_or(memory.bytes),
                before_bytes: memory.before_bytes,
            },
            _ => TooLittle::Time { tolerance },
        }
    }

    /// What is told of a result at another tolerance than the one `asked` for: what stood in the way.
    pub(crate) fn why_coarser(&self, limit: Limit, asked: f64) -> String {
        match (&self.memory, limit) {
            (Some(memory), Limit::Memory) => {
                format!("the memory limit of {} was reached before tolerance {asked}", summary::bytes(memory.bytes))
            }
            _ => format!("the time limit is too short for tolerance {asked}"),
        }
    }
}

impl Limit {
    /// The option, and what of it would give a better result.
    pub(crate) fn way_out(self) -> &'static str {
        match self {
            Self::Time => "A longer --time-limit",
            Self::Memory => "A greater --memory-limit",
        }
    }
}

impl MemoryLimit {
    fn new(bytes: u64) -> Result<Self, MemoryUnknown> {
        Ok(Self {
            bytes,
            step_bytes: bytes.saturating_sub(SPARE_BYTES + (bytes as f64 * SPARE_SHARE) as u64),
            before_bytes: memory::peak_bytes().ok_or(MemoryUnknown)?,
            begin: Instant::now(),
            next_look_ms: AtomicU64::new(0),
            is_passed: AtomicBool::new(false),
        })
    }

    /// Whether a step has held too much; looks where the last look was some time ago.
    fn look(&self) -> bool {
        let due_ms = self.next_look_ms.load(Ordering::Relaxed);
        let now_ms = self.begin.elapsed().as_millis() as u64;
        // Of the threads that come by at that time, one looks.
        let is_mine = now_ms >= due_ms
            && self
                .next_look_ms
                .compare_exchange(due_ms, now_ms + LOOK_EVERY_MS, Ordering::Relaxed, Ordering::Relaxed)
                .is_ok();
        if is_mine {
            self.room();
        }
        self.is_passed.load(Ordering::Relaxed)
    }

    /// What a step may hold over the most that was held so far, nearly always by the last step.
    fn room(&self) -> f64 {
        let held = memory::peak_bytes().unwrap_or(u64::MAX);
        if held > self.step_bytes {
            self.is_passed.store(true, Ordering::Relaxed);
        }
        self.step_bytes as f64 / held as f64
    }
}

/// Ends when it is dropped.
#[derive(Debug)]
pub(crate) struct Watch(Arc<AtomicBool>);

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Looks, while a scene is read, whether the process holds more than it may, and then ends it: nothing has been written yet.
///
/// # Errors
/// [`MemoryUnknown`] where memory is limited that cannot be told.
pub(crate) fn watch_reading(bytes: u64) -> Result<Watch, MemoryUnknown> {
    let limit = MemoryLimit::new(bytes)?;
    let is_over = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&is_over);
    // Where the program alone holds more, the first step tells so, with what would be needed.
    if limit.room() < 1.0 {
        return Ok(Watch(is_over));
    }
    thread::spawn(move || {
        while !seen.load(Ordering::Relaxed) {
            if limit.room() < 1.0 {
                let limit = summary::bytes(limit.bytes);
                output::error(&format!(
                    "the memory limit of {limit}, of which an eighth and 8 MiB stay free, was reached while the scene was read. Nothing \
                     was written. Give it more memory, or smaller pictures"
                ));
                process::exit(ExitCode::Failed.into());
            }
            thread::sleep(WATCH_EVERY);
        }
    });
    Ok(Watch(is_over))
}

/// When a bake must end, so that its file is there within the limit; `None` where it never comes.
fn last_moment(begin: Instant, limit: Duration) -> Option<Instant> {
    let for_writing = WRITING + limit.mul_f64(WRITING_SHARE);
    begin.checked_add(limit.saturating_sub(for_writing))
}

/// Seconds, more than 0.
pub(crate) fn time_limit(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(text)?).map_err(|error| error.to_string())
}

/// A size of memory.
pub(crate) fn memory_limit(text: &str) -> Result<ByteSize, String> {
    text.parse().map_err(|_| "a size is a number with its unit, such as 500MB or 2GiB".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    fn with_memory(bytes: u64) -> Limits {
        Limits::new(Instant::now(), None, Some(ByteSize(bytes))).unwrap()
    }

    #[test]
    fn sizes_have_units_of_thousands_or_of_1024() {
        let bytes = |text| memory_limit(text).map(|size| size.as_u64());
        assert_eq!(
            ["500MB", "2GiB", "1.5 GiB", "64m", "1000"].map(bytes),
            [500_000_000, 2 << 30, 3 << 29, 64_000_000, 1000].map(Ok)
        );
        for wrong in ["", "GiB", "-1GB", "2 bananas", "1e3MB"] {
            assert!(bytes(wrong).is_err_and(|told| told.contains("such as 500MB or 2GiB")), "{wrong}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn memory_is_passed_once_the_process_has_held_more() {
        let (small, large) = (with_memory(1000), with_memory(1 << 50));
        assert!(small.is_reached() && small.is_reached() && small.reached() == Limit::Memory);
        assert!(!large.is_reached() && large.reached() == Limit::Time);
        // A step may end before anybody looks again.
        let unseen = with_memory(1000);
        assert!(unseen.room(1.0) < 1.0 && unseen.reached() == Limit::Memory);
        assert!(small.room(1.0) < 1.0 && large.room(1.0) > 1000.0);
    }

    #[cfg(unix)]
    #[test]
    fn the_tighter_limit_tells_how_much_finer_a_step_can_be() {
        let hour = Some(Duration::from_secs(3600));
        let both = |bytes| Limits::new(Instant::now(), hour, Some(ByteSize(bytes))).unwrap();
        assert!(both(1000).room(1.0) < 1.0);
        let of_time = both(1 << 50).room(100.0);
        assert!((30.0..36.0).contains(&of_time), "{of_time}");
        assert_eq!(Limits::default().room(1.0), f64::INFINITY);
    }

    #[test]
    fn time_is_left_for_writing() {
        let begin = Instant::now();
        let left = |s| last_moment(begin, Duration::from_secs(s)).map(|until| until - begin);
        assert_eq!(left(60), Some(Duration::from_millis(59_300)));
        assert_eq!(last_moment(begin, Duration::MAX), None);
    }
}

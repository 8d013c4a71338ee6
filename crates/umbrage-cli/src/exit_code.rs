//! What the process tells its caller.

/// The exit codes of `umbrage`. Wrong usage exits with 2, from the parser of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ExitCode {
    /// All was done.
    Success,
    /// Input that cannot be read or baked, output that cannot be written.
    Failed,
    /// A bake is not as good as was asked.
    NotGoodEnough,
    /// Ctrl-C; 128 + the number of the signal, as shells have it.
    Interrupted,
}

impl From<ExitCode> for i32 {
    fn from(code: ExitCode) -> Self {
        match code {
            ExitCode::Success => 0,
            ExitCode::Failed => 1,
            ExitCode::NotGoodEnough => 3,
            ExitCode::Interrupted => 130,
        }
    }
}

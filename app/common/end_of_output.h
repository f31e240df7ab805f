#pragma once

namespace tandem {

/// Returns the exit code once all output is written. A script must not take part of a result for
/// the whole.
int EndOfOutput(int exit_code);

}  // namespace tandem

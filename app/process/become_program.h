#pragma once

#include <string>
#include <vector>

namespace tandem {

/// Becomes a program of ours, which lies beside this one, with these arguments. Returns only if the
/// program cannot be started, after a line that says why: the exit code to end with.
int BecomeProgram(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace tandem

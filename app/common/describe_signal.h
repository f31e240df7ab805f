#pragma once

#include <string>

namespace tandem {

/// Returns how a program ended by a signal, as a person would say it: "was killed, by somebody or
/// because memory ran out", "crashed (signal 11)".
std::string DescribeSignal(int signal);

}  // namespace tandem

#pragma once

#include <filesystem>
#include <string>

#include "collab/lab/lab_case.h"

namespace tandem {

/// Reads a case of the lab (docs/stability.md): a JSON object in which every key has a default and
/// an unknown one is a fault. Errors name the file, the place in it and what was expected there.
///
/// Hands turn as their travel says once the case is fitted to a body: see FittedTo().
Result<LabCase> LoadCase(const std::filesystem::path& file);
/// The same of a text; `name` stands for the file in what is said of it, and hand files and traces
/// are those in `folder`.
Result<LabCase> ParseCase(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder = {});

}  // namespace tandem

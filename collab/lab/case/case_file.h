#pragma once

#include <filesystem>
#include <string>

#include "collab/lab/case/lab_case.h"

namespace tandem {

/// Reads a case of the lab (docs/stability.md): a JSON object in which every key has a default and
/// an unknown key is a fault. Errors name the file, the place in it and what was expected there.
///
/// The hands get their rotational impedance only from FittedTo(), which knows the body.
Result<LabCase> LoadCase(const std::filesystem::path& file);
/// Reads a case from a text. `name` stands for the file in errors, and `folder` holds its hand
/// files and traces.
Result<LabCase> ParseCase(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder = {});

}  // namespace tandem

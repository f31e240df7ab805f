#pragma once

#include <filesystem>
#include <string>

#include "app/study/study.h"
#include "engine/base/result.h"

namespace tandem {

/// Reads a study (docs/studies.md). Unknown keys and references to names that do not exist are
/// faults. Names of scenes and hand files that end in `.json` and lie beside the study's file
/// become absolute paths. Errors name the file, the place in it and what was expected there.
Result<Study> LoadStudy(const std::filesystem::path& file);
/// Reads a study from a text. Errors name it `name`.
Result<Study> ParseStudy(const std::string& text, const std::string& name);

}  // namespace tandem

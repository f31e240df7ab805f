#pragma once

#include <filesystem>
#include <string>

#include "app/study/study.h"
#include "engine/base/result.h"

namespace tandem {

/// Reads a study (docs/studies.md): an unknown key is a fault, as is a name that nothing has.
/// Scenes and hand files that end in `.json` and lie beside the file come back with its folder.
/// Errors name the file, the place in it and what was expected there.
Result<Study> LoadStudy(const std::filesystem::path& file);
/// The same of a text; `name` stands for the file in what is said of it.
Result<Study> ParseStudy(const std::string& text, const std::string& name);

}  // namespace tandem

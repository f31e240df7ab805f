#include "scenes/generators/generator_command.h"

#include <cstdio>
#include <string>
#include <system_error>

namespace tandem {

std::optional<std::filesystem::path> FolderToFill(int argc, const char* const* argv,
                                                  const char* program, const char* what,
                                                  int& exit_code) {
  const std::string word = argc == 2 ? argv[1] : "";
  if (word == "--help" || word == "-h") {
    std::printf("%s FOLDER: %s\n", program, what);
    exit_code = 0;
    return std::nullopt;
  }
  exit_code = 2;
  if (argc != 2 || word.empty() || word.front() == '-') {
    std::fprintf(stderr, "%s: give one folder and no options: %s FOLDER\n", program, program);
    return std::nullopt;
  }
  std::error_code failed;
  if (!std::filesystem::is_directory(word, failed)) {
    std::fprintf(stderr, "%s: there is no such folder: make it first\n", program);
    return std::nullopt;
  }
  return word;
}

}  // namespace tandem

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

namespace tandem {
namespace {

// Names, paths and lines of strangers reach a terminal through Say(), PrintLine(), PrintText() and
// SayAs() (app/common/console.h), which leave no control character in them. A call past these could
// forget that. The files named here write texts of their own, or a text that they have cleaned.
TEST(Writers, ProgramsWriteToTheTerminalByTheCleaningFunctions) {
  constexpr std::array<std::string_view, 7> kCalls{
      "std::printf(", "std::puts(",   "std::fputs(",        "std::cout",
      "std::cerr",    "std::perror(", "std::fprintf(stderr"};
  const std::vector<std::string_view> own{
      "app/bench/",                    // figures
      "app/common/progress_bar.cpp",   // a bar, drawn over itself
      "app/cli/voxelize_command.cpp",  // a share in percent
      "app/device/",                   // words of drivers, cleaned
      "app/invite/given_line.cpp",     // a question
      "app/peer/scene_consent.cpp",    // a question, cleaned
  };
  std::vector<std::string> wrong;
  std::size_t files = 0;
  for (const std::filesystem::path& file : testing::TreeFiles()) {
    const std::string path = file.string();
    if (!path.starts_with("app/") || (file.extension() != ".cpp" && file.extension() != ".h")) {
      continue;
    }
    ++files;
    const auto is_own = [&path](std::string_view one) {
      return path.starts_with(one);
    };
    if (std::ranges::any_of(own, is_own)) continue;
    const std::string text = testing::TreeText(file);
    for (const std::string_view call : kCalls) {
      for (std::size_t at = text.find(call); at != std::string::npos;
           at = text.find(call, at + 1)) {
        // snprintf writes no terminal
        if (at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) != 0)) continue;
        wrong.push_back(path + ": " + text.substr(at, 40));
      }
    }
  }
  EXPECT_GT(files, 200U);
  EXPECT_THAT(wrong, ::testing::IsEmpty());
}

}  // namespace
}  // namespace tandem

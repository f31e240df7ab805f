#include "tests/architecture/include_directions.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/tree_files.h"

namespace tandem::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;

struct SourceFile {
  std::string path;  // from the top of the tree
  std::string text;
};

std::vector<SourceFile> ReadTree() {
  const std::filesystem::path top = TANDEM_SOURCE_DIR;
  std::vector<SourceFile> files;
  for (const char* part : {"engine", "collab", "app", "scenes"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(top / part)) {
      const std::string path = entry.path().lexically_relative(top).generic_string();
      const std::string extension = entry.path().extension().string();
      const bool source = extension == ".h" || extension == ".cpp" || extension == ".c";
      // The build files of engine/ and app/ only list their folders.
      const bool build_file = entry.path().filename() == "CMakeLists.txt" &&
                              path != "engine/CMakeLists.txt" && path != "app/CMakeLists.txt";
      if (!source && !build_file) continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      files.push_back({path, text.str()});
    }
  }
  return files;
}

TEST(IncludeDirections, EveryFileObeysTheArrows) {
  const std::vector<SourceFile> files = ReadTree();
  ASSERT_GT(files.size(), 30U);
  LibraryFolders libraries;
  for (const SourceFile& file : files) FindLibraries(file.path, file.text, libraries);
  ASSERT_GT(libraries.size(), 8U);
  std::vector<std::string> violations;
  for (const SourceFile& file : files) {
    for (std::string& violation : ArrowViolations(file.path, file.text, libraries)) {
      violations.push_back(std::move(violation));
    }
  }
  EXPECT_THAT(violations, IsEmpty());
}

TEST(IncludeDirections, OnlyOneFileIncludesAssimp) {
  std::vector<std::string> including;
  for (const SourceFile& file : ReadTree()) {
    if (IncludesAssimp(file.text)) including.push_back(file.path);
  }
  EXPECT_THAT(including, SizeIs(Le(1)));
}

// Dead reckoning is for the picture (docs/decisions/0023-apart.md: in contact it draws energy in):
// what is measured and what moves are never predicted.
TEST(IncludeDirections, OnlyThePictureIsPredicted) {
  std::vector<std::string> including;
  for (const SourceFile& file : ReadTree()) {
    if (file.text.find("dead_reckoning.h\"") != std::string::npos) including.push_back(file.path);
  }
  EXPECT_THAT(including,
              ::testing::UnorderedElementsAre("app/view/model/scene/dead_reckoning.cpp",
                                              "app/view/model/scene/picture_composer.h"));
  including.clear();
  for (const SourceFile& file : ReadTree()) {
    if (file.text.find("picture_composer.h\"") == std::string::npos) continue;
    EXPECT_THAT(file.path, ::testing::StartsWith("app/view/"));
    including.push_back(file.path);
  }
  EXPECT_THAT(including, ::testing::Contains("app/view/ui/main_window.h"));
}

/// A line of a file that breaks an arrow, or does not.
struct InjectedLine {
  const char* path;
  const char* line;
  const char* found;  // null: allowed
};

void Judge(const std::vector<InjectedLine>& lines, const LibraryFolders& libraries = {}) {
  for (const InjectedLine& injected : lines) {
    const std::string text = std::string("#pragma once\n") + injected.line + "\n";
    const std::vector<std::string> violations = ArrowViolations(injected.path, text, libraries);
    if (injected.found == nullptr) {
      EXPECT_THAT(violations, IsEmpty());
    } else {
      EXPECT_THAT(violations, ElementsAre(AllOf(HasSubstr(std::string(injected.path) + ":2: "),
                                                HasSubstr(injected.found))));
    }
  }
}

TEST(IncludeDirections, FindsAnInjectedIncludeAgainstAnArrow) {
  Judge({{"engine/voxel/a.h", "#include \"engine/geometry/b.h\"", nullptr},
         {"engine/haptics/a.h", "#include \"engine/base/b.h\"", nullptr},
         {"engine/geometry/a.h", "#include \"engine/voxel/b.h\"", "includes engine/voxel/b.h"},
         {"engine/base/a.h", "#  include \"engine/realtime/b.h\"", "includes engine/realtime"},
         {"engine/contact/a.h", "#include \"engine/dynamics/b.h\"", "engine/dynamics"},
         {"engine/world/a.cpp", "#include \"collab/session/messages.h\"",
          "collab/session/messages.h"},
         {"collab/session.h", "#include \"engine/world/world.h\"", nullptr},
         {"collab/session.h", "#include \"collab/dds/transport/dds_transport.h\"", "collab/dds"},
         {"collab/dds/a.cpp", "#include \"collab/session/transport.h\"", nullptr},
         {"collab/simulated/a.cpp", "#include \"app/cli/b.h\"", "app/cli/b.h"},
         {"app/cli/a.cpp", "#include \"app/view/b.h\"", "app/view/b.h"},
         {"engine/voxel/a.cpp", "#include \"b.h\"", "the top of the tree"}});
}

TEST(IncludeDirections, FindsAnInjectedLibraryOutOfItsPlace) {
  Judge({{"collab/dds/a.cpp", "#include <dds/dds.h>", nullptr},
         {"collab/session.cpp", "#include \"dds/dds.h\"", "includes DDS"},
         {"app/cli/a.cpp", "#include <dds/dds.h>", "includes DDS"},
         {"engine/voxel/a.cpp", "#include <assimp/scene.h>", "includes assimp"},
         {"app/view/a.cpp", "#include <QWidget>", nullptr},
         {"app/cli/a.cpp", "#include <QtCore/QString>", "includes Qt"}});
}

TEST(IncludeDirections, FindsAnInjectedClock) {
  Judge({{"engine/world/a.cpp", "auto t = std::chrono::steady_clock::now();", "reads a clock"},
         {"collab/session.cpp", "clock_gettime(CLOCK_MONOTONIC, &t);", "reads a clock"},
         {"collab/session.cpp", "Tick(MonotonicNowNs());", "reads a clock"},
         {"collab/session.cpp", "std::this_thread::sleep_for(1ms);", "sleeps"},
         {"collab/session.cpp", "// unlike MonotonicNowNs()", nullptr},
         {"engine/realtime/a.cpp", "clock_gettime(CLOCK_MONOTONIC, &t);", nullptr},
         {"collab/dds/a.cpp", "Heard(MonotonicNowNs());", nullptr}});
}

TEST(IncludeDirections, FindsAnInjectedLinkAgainstAnArrow) {
  LibraryFolders libraries;
  FindLibraries("engine/geometry/CMakeLists.txt", "add_library(tandem_geometry a.cpp)", libraries);
  FindLibraries("engine/voxel/CMakeLists.txt", "add_library(tandem_voxel\n  a.cpp)", libraries);
  FindLibraries("collab/dds/CMakeLists.txt", "add_library( tandem_dds a.cpp)", libraries);
  Judge({{"engine/voxel/CMakeLists.txt",
          "target_link_libraries(tandem_voxel PUBLIC tandem_geometry)", nullptr},
         {"engine/geometry/CMakeLists.txt", "  PUBLIC tandem_voxel)", "links to tandem_voxel"},
         {"collab/CMakeLists.txt", "target_link_libraries(tandem_collab PRIVATE tandem_dds)",
          "links to tandem_dds of collab/dds"}},
        libraries);
}

TEST(IncludeDirections, ArrowsLeadOnlyToFoldersThatExist) {
  const std::filesystem::path top = TANDEM_SOURCE_DIR;
  std::vector<std::string> missing;
  for (const std::string& folder : FoldersOfTheArrows()) {
    if (!std::filesystem::is_directory(top / folder)) missing.push_back(folder);
  }
  EXPECT_THAT(missing, IsEmpty());
}

// More than that nobody reads through: a room for each purpose (docs/architecture.md).
TEST(IncludeDirections, FoldersHaveAtMost25CodeFiles) {
  std::map<std::string, std::size_t> counts;
  for (const std::filesystem::path& file : TreeFiles()) {
    const std::string type = file.extension();
    if (type == ".cpp" || type == ".h") ++counts[file.parent_path().generic_string()];
  }
  ASSERT_GT(counts.size(), 60U);
  std::erase_if(counts, [](const auto& folder) {
    return folder.second <= 25;
  });
  EXPECT_THAT(counts, IsEmpty());
}

TEST(IncludeDirections, DetectsAnUnlistedFolder) {
  EXPECT_THAT(ArrowViolations("engine/magic/a.h", ""), SizeIs(1));
}

}  // namespace
}  // namespace tandem::testing

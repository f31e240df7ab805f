#include "tests/architecture/include_directions.h"

#include <algorithm>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

namespace tandem::testing {
namespace {

// Returns each folder with its own place in the order, and the folders that it may see beside
// itself. The longest name that a path begins with is the path's folder.
const std::map<std::string, std::set<std::string>>& Arrows() {
  static const auto* arrows = [] {
    auto* map = new std::map<std::string, std::set<std::string>>;
    const auto may_see = [map](const std::string& folder, const std::set<std::string>& others) {
      std::set<std::string>& seen = (*map)[folder];
      for (const std::string& other : others) {
        seen.insert(other);
        seen.insert((*map)[other].begin(), (*map)[other].end());
      }
    };
    may_see("engine/base", {});
    may_see("engine/base/files", {"engine/base"});
    may_see("engine/base/text", {"engine/base/files"});
    may_see("engine/realtime", {"engine/base", "engine/base/text"});
    may_see("engine/safety", {"engine/base"});
    may_see("engine/dynamics", {"engine/base"});
    may_see("engine/geometry/mesh", {"engine/base/files"});
    may_see("engine/geometry/formats", {"engine/geometry/mesh", "engine/base/text"});
    may_see("engine/geometry/import", {"engine/geometry/formats"});
    may_see("engine/geometry/exact", {"engine/geometry/mesh"});
    may_see("engine/geometry", {"engine/geometry/import", "engine/geometry/exact"});
    may_see("engine/voxel/map", {"engine/base/files"});
    may_see("engine/voxel/build", {"engine/voxel/map", "engine/geometry/exact"});
    may_see("engine/voxel/pages", {"engine/voxel/build"});
    may_see("engine/voxel/points", {"engine/voxel/build"});
    may_see("engine/voxel", {"engine/voxel/pages", "engine/voxel/points", "engine/geometry"});
    may_see("engine/field/query", {"engine/voxel/map"});
    may_see("engine/field/build", {"engine/field/query", "engine/voxel/build"});
    may_see("engine/field", {"engine/field/build", "engine/voxel"});
    may_see("engine/paging", {"engine/realtime", "engine/voxel"});
    may_see("engine/contact/schedule", {"engine/paging"});
    may_see("engine/contact/pair", {"engine/contact/schedule"});
    may_see("engine/contact/features", {"engine/contact/schedule", "engine/field/query"});
    may_see("engine/contact/field", {"engine/contact/pair", "engine/contact/features"});
    may_see("engine/contact/kept", {"engine/contact/field", "engine/field/build"});
    may_see("engine/contact", {"engine/contact/kept", "engine/field"});
    may_see("engine/scene", {"engine/dynamics", "engine/contact"});
    may_see("engine/world", {"engine/scene"});
    may_see("engine/proximity", {"engine/voxel"});
    may_see("engine/haptics", {"engine/world", "engine/safety"});
    may_see("collab/session", {"engine/haptics"});
    may_see("collab/receive", {"collab/session"});
    may_see("collab/ownership", {"collab/session"});
    may_see("collab/coupling", {"collab/receive"});
    may_see("collab/mirror", {"collab/coupling"});
    may_see("collab/separation", {"collab/ownership", "collab/coupling"});
    may_see("collab/peer", {"collab/mirror", "collab/separation"});
    may_see("collab", {"collab/peer"});
    may_see("collab/controller", {"collab"});
    may_see("collab/transfer", {"collab"});
    may_see("collab/trace", {"collab"});
    may_see("collab/dds/cyclone", {"collab/session"});
    may_see("collab/dds/networks", {"collab/dds/cyclone"});
    may_see("collab/dds/security", {"collab/dds/networks"});
    may_see("collab/dds/wire", {"collab/controller", "collab/transfer"});
    may_see("collab/dds/transport", {"collab/dds/security", "collab/dds/wire"});
    may_see("collab/dds/control", {"collab/dds/transport"});
    may_see("collab/dds/diagnostics", {"collab/dds/transport", "collab/trace"});
    may_see("collab/dds", {"collab/dds/control", "collab/dds/diagnostics"});
    may_see("collab/simulated/network", {"collab"});
    may_see("collab/simulated/checkers", {"collab/simulated/network"});
    may_see("collab/simulated", {"collab/simulated/checkers"});
    may_see("collab/simulated/hands/checkers", {"collab/simulated", "collab/controller"});
    may_see("collab/simulated/hands", {"collab/simulated/hands/checkers"});
    may_see("collab/recording", {"collab"});
    may_see("collab/lab/theory", {"engine/haptics"});
    may_see("collab/lab/case", {"collab/lab/theory", "collab/trace"});
    may_see("collab/lab/metrics", {"collab/lab/case"});
    may_see("collab/lab/run", {"collab/lab/metrics", "collab/simulated", "collab/recording"});
    may_see("collab/lab/sweep", {"collab/lab/run"});
    may_see("collab/lab", {"collab/lab/sweep"});
    may_see("scenes/generators", {"engine/haptics"});  // they write hand files too
    may_see("scenes/generators/large", {"scenes/generators"});
    may_see("scenes", {"scenes/generators/large"});
    may_see("app/common", {"engine/world"});  // shared by all programs
    may_see("app/device", {"app/common", "collab/recording"});
    may_see("app/invite", {"app/common", "collab"});
    may_see("app/connection", {"app/common", "app/invite", "collab/dds"});
    may_see("app/picture", {"engine/base/text"});
    may_see("app/process", {"app/connection"});
    may_see("app/judgement",
            {"app/common", "engine/proximity", "collab/controller", "collab/recording"});
    may_see("app/recording", {"app/connection", "collab/recording", "collab/trace"});
    may_see("app/capacity", {"app/judgement", "collab/simulated"});
    may_see("app/peer", {"app/process", "app/recording", "app/capacity"});
    may_see("app/join", {"app/peer", "app/invite"});
    may_see("app/doctor", {"app/process", "app/recording"});
    may_see("app/stability/report", {"app/common", "app/picture", "collab/lab"});
    may_see("app/stability/live", {"app/process", "collab/lab", "scenes"});
    may_see("app/stability/cli",
            {"app/stability/report", "app/stability/live", "app/judgement", "app/recording"});
    may_see("app/stability", {"app/stability/cli"});
    may_see("app/study", {"app/stability/report", "scenes"});
    may_see("app/study/run", {"app/study", "app/stability/live", "app/capacity", "app/recording"});
    may_see("app/bench/reference", {"engine/contact"});
    may_see("app/bench/measure", {"app/process", "app/capacity", "app/picture"});
    may_see("app/bench/fidelity", {"app/bench/measure", "scenes"});
    may_see("app/bench", {"app/bench/fidelity", "app/bench/reference"});
    may_see("app/bench/comparison", {"app/bench"});
    may_see("app/cli", {"app/join", "app/doctor", "app/stability/cli", "app/study/run", "app/bench",
                        "collab/simulated/hands"});
    may_see("app/view/model/words", {});
    may_see("app/view/model/scene", {"app/connection", "app/view/model/words"});
    may_see("app/view/model/session", {"app/view/model/scene"});
    may_see("app/view/model/proximity", {"app/view/model/scene", "engine/proximity"});
    may_see("app/view/model/hand", {"app/view/model/scene"});
    may_see("app/view/render", {"app/view/model/proximity"});
    may_see("app/view/ui/dialogs", {"app/view/model/hand"});
    may_see("app/view/ui/overlays", {"app/view/model/hand", "app/view/model/proximity"});
    may_see("app/view/ui", {"app/view/ui/dialogs", "app/view/ui/overlays", "app/view/model/session",
                            "app/view/render"});
    may_see("app/view", {"app/view/ui", "app/picture"});
    return map;
  }();
  return *arrows;
}

bool IsIn(const std::string& path, const std::string& folder) {
  return path.rfind(folder + "/", 0) == 0;
}

std::optional<std::string> FolderOf(const std::string& path) {
  std::optional<std::string> longest;
  for (const auto& [folder, seen] : Arrows()) {
    if (IsIn(path, folder) && (!longest || folder.size() > longest->size())) longest = folder;
  }
  return longest;
}

// Something that only the named places may do.
struct Reserved {
  std::regex pattern;
  std::string what;
  std::vector<std::string> places;
};

const std::vector<Reserved>& ReservedWords() {
  static const auto* reserved = new std::vector<Reserved>{
      {std::regex(R"(#\s*include\s*[<"](dds/|ddsc/|tandem(_control)?\.h))"),
       "includes DDS",
       {"collab/dds"}},
      {std::regex(R"(#\s*include\s*<assimp/)"), "includes assimp", {"engine/geometry"}},
      {std::regex(R"(#\s*include\s*<Q(t|[A-Z]))"), "includes Qt", {"app/view"}},
      {std::regex(R"(#\s*include\s*<openssl/)"),
       "includes OpenSSL",
       {"app/device/drivers", "app/invite", "engine/base/files"}},
      {std::regex(R"(#\s*include\s*<CLI/)"), "includes the command line's library", {"app"}},
      {std::regex(
           R"(\b(clock_gettime|gettimeofday|(steady|system|high_resolution)_clock|MonotonicNowNs)\b)"),
       "reads a clock",
       {"engine/realtime", "collab/dds", "app"}},
      {std::regex(R"(\b(sleep_for|sleep_until|nanosleep|clock_nanosleep|usleep)\b)"),
       "sleeps",
       {"engine/realtime", "collab/dds", "app"}},
  };
  return *reserved;
}

class Reader {
 public:
  Reader(std::string path, std::string folder)
      : path_(std::move(path)), folder_(std::move(folder)) {}

  void ReadSource(const std::string& line, int number) {
    static const std::regex include(R"re(^\s*#\s*include\s*(<|")([^>"]+))re");
    const std::string code = line.substr(0, line.find("//"));
    std::smatch match;
    if (std::regex_search(code, match, include)) CheckInclude(match[1], match[2], number);
    for (const Reserved& reserved : ReservedWords()) {
      const bool here = std::any_of(reserved.places.begin(), reserved.places.end(),
                                    [this](const std::string& place) {
                                      return IsIn(path_, place);
                                    });
      if (!here && std::regex_search(code, reserved.pattern)) Report(number, reserved.what);
    }
  }

  void ReadBuildFile(const std::string& line, int number, const LibraryFolders& libraries) {
    static const std::regex name(R"(\btandem_\w+)");
    const std::string code = line.substr(0, line.find('#'));
    for (std::sregex_iterator it(code.begin(), code.end(), name), end; it != end; ++it) {
      const auto library = libraries.find(it->str());
      if (library != libraries.end() && !MaySee(library->second)) {
        Report(number, "links to " + it->str() + " of " + library->second);
      }
    }
  }

  std::vector<std::string> Take() { return std::move(violations_); }

 private:
  bool MaySee(const std::string& other) const {
    return other == folder_ || Arrows().at(folder_).contains(other);
  }

  void CheckInclude(const std::string& quote, const std::string& header, int number) {
    if (const std::optional<std::string> seen = FolderOf(header)) {
      if (!MaySee(*seen)) Report(number, "includes " + header);
    } else if (quote == "\"" && header.find('/') == std::string::npos &&
               !IsIn(path_, "collab/dds") && !IsIn(path_, "app/view")) {  // idlc's and moc's output
      Report(number,
             "includes " + header + " by a name that does not start at the top of the tree");
    }
  }

  void Report(int number, const std::string& what) {
    violations_.push_back(path_ + ":" + std::to_string(number) + ": " + folder_ + " " + what);
  }

  std::string path_;
  std::string folder_;
  std::vector<std::string> violations_;
};

}  // namespace

void FindLibraries(const std::string& path, const std::string& text, LibraryFolders& folders) {
  static const std::regex added(R"(\badd_library\(\s*(tandem_\w+))");
  const std::optional<std::string> folder = FolderOf(path);
  if (!folder) return;
  for (std::sregex_iterator it(text.begin(), text.end(), added), end; it != end; ++it) {
    folders[(*it)[1]] = *folder;
  }
}

std::vector<std::string> FoldersOfTheArrows() {
  std::vector<std::string> folders;
  for (const auto& [folder, seen] : Arrows()) folders.push_back(folder);
  return folders;
}

std::vector<std::string> ArrowViolations(const std::string& path, const std::string& text,
                                         const LibraryFolders& libraries) {
  const std::optional<std::string> folder = FolderOf(path);
  if (!folder) return {path + ":1: stands in a folder that no arrow leads to"};
  Reader reader(path, *folder);
  const bool build_file = path.find("CMakeLists.txt") != std::string::npos;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (build_file) {
      reader.ReadBuildFile(line, number, libraries);
    } else {
      reader.ReadSource(line, number);
    }
  }
  return reader.Take();
}

bool IncludesAssimp(const std::string& text) {
  return std::regex_search(text, std::regex(R"(#\s*include\s*<assimp/)"));
}

}  // namespace tandem::testing

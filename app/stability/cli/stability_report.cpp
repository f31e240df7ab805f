#include "app/stability/cli/stability_report.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/picture/picture_file.h"
#include "app/picture/svg.h"
#include "app/process/child_processes.h"
#include "app/stability/cli/report_series.h"
#include "app/stability/cli/stability_command.h"
#include "app/stability/report/data_files.h"
#include "app/stability/report/html_report.h"
#include "app/stability/report/maps.h"
#include "app/stability/report/margin_picture.h"
#include "app/stability/report/report_data.h"
#include "app/stability/report/seed_spread.h"
#include "engine/base/files/whole_file.h"

namespace tandem {

namespace {

constexpr std::size_t kMostMaps = 12;  // maps of a sweep
constexpr std::chrono::milliseconds kPaintingTakes{120'000};

/// Writes a report's files, and keeps the first error.
class Folder {
 public:
  explicit Folder(std::filesystem::path path) : path_(std::move(path)) {}

  std::optional<Error> Make(const std::filesystem::path& inside = {}) const {
    std::error_code failed;
    std::filesystem::create_directories(path_ / inside, failed);
    if (failed) return Error{(path_ / inside).string() + ": " + failed.message()};
    return std::nullopt;
  }
  void Write(const std::string& name, const std::string& content) {
    const std::optional<Error> failed = WriteWholeFile(path_ / name, content);
    if (failed && !fault_) fault_ = failed;
  }
  const std::filesystem::path& path() const { return path_; }
  const std::optional<Error>& fault() const { return fault_; }

 private:
  std::filesystem::path path_;
  std::optional<Error> fault_;
};

void AddPictures(LabScenes& scenes, ReportSweep& sweep) {
  std::vector<StabilityMap> maps =
      MapsOf(sweep.results, [&scenes](const LabCase& test) -> std::optional<Inertia> {
        const LabScene* const scene = scenes.SceneFor(test);
        if (scene == nullptr) return std::nullopt;
        return scene->inertia();
      });
  sweep.maps_left_out = maps.size() - std::min(maps.size(), kMostMaps);
  maps.resize(std::min(maps.size(), kMostMaps));
  for (StabilityMap& map : maps) {
    map.name.insert(0, sweep.name + "-");
    sweep.maps.push_back(PictureOf(map));
  }
  sweep.others.push_back(MarginPictureOf(sweep.results, sweep.name + "-margin"));
}

/// Paints the pictures as PNG, by the viewer's program.
void Paint(const Folder& folder, const std::vector<Picture>& pictures) {
  const std::filesystem::path program = ProgramFolder() / "tandem-view";
  if (!std::filesystem::exists(program)) {
    Say("tandem-view is not beside this program, so pictures are SVG only");
    return;
  }
  const TemporaryFolder between;
  const std::filesystem::path file = between.path() / "pictures.json";
  std::ofstream(file, std::ios::binary) << JsonOf(pictures);
  Result<ChildProcess> painter =
      ChildProcess::Start({program.string(), "--paint", file.string(), "--into",
                           (folder.path() / "pictures").string()});
  const std::optional<int> ended = painter ? painter->Wait(kPaintingTakes) : std::nullopt;
  if (ended != kExitOk) Say("tandem-view painted no pictures, so pictures are SVG only");
}

}  // namespace

int MakeReport(const ReportRequest& request) {
  ReportData data;
  data.command = request.command;
  data.version = TANDEM_VERSION;
  for (const std::filesystem::path& file : request.files) {
    if (const auto fault = AddFile(file, data)) return Fail(kExitFile, fault->what);
  }
  Folder folder(request.folder);
  for (const char* name : {"pictures", "cases"}) {
    if (const auto fault = folder.Make(name)) return Fail(kExitFile, fault->what);
  }
  LabScenes scenes;
  for (ReportSweep& sweep : data.sweeps) AddPictures(scenes, sweep);
  for (const ReportSweep& sweep : data.sweeps) {
    if (auto spread = SeedSpreadOf(sweep.results)) data.tables.push_back(*std::move(spread));
  }
  if (const auto fault = AddSeries(request.series, folder.path(), scenes, data)) {
    return Fail(kExitFile, fault->what);
  }
  std::vector<Picture> pictures;
  for (const ReportSweep& sweep : data.sweeps) {
    pictures.insert(pictures.end(), sweep.maps.begin(), sweep.maps.end());
    pictures.insert(pictures.end(), sweep.others.begin(), sweep.others.end());
    folder.Write(sweep.name + "-cells.csv", CsvOf(sweep.results));
    for (const auto& [number, record] : sweep.results.records) {
      folder.Write(CaseFileOf(sweep.name, record), record.cell.case_json + "\n");
    }
  }
  pictures.insert(pictures.end(), data.pictures.begin(), data.pictures.end());
  for (const ReportSeries& one : data.series) pictures.push_back(one.picture);
  for (const Picture& picture : pictures) {
    folder.Write("pictures/" + picture.name + ".svg", SvgOf(picture, SvgPlace::kFile));
  }
  for (std::size_t i = 0; i < data.tables.size(); ++i) {
    folder.Write("table-" + std::to_string(i + 1) + ".csv", CsvOf(data.tables[i]));
  }
  folder.Write("report.json", JsonOf(data));
  folder.Write("report.html", HtmlOf(data));
  if (folder.fault()) return Fail(kExitFile, folder.fault()->what);
  if (!pictures.empty()) Paint(folder, pictures);
  Say("wrote " + (request.folder / "report.html").string());
  return kExitOk;
}

void AddStabilityReport(CLI::App& stability, int& exit_code) {
  auto request = std::make_shared<ReportRequest>();
  CLI::App* command = stability.add_subcommand(
      "report", "Write a page with maps, time series and tables of what was measured");
  command
      ->add_option(
          "results", request->files,
          "folders or .jsonl files of sweeps, and JSON files that boundary, live and press print")
      ->required()
      ->check(CLI::ExistingPath);
  command->add_option("--out", request->folder, "folder for report.html and its data")->required();
  command
      ->add_option("--series", request->series,
                   "number of cells to run again for their time series; 0: none")
      ->check(WholeNumberFrom(0, 100))
      ->capture_default_str();
  command->callback([request, &exit_code] {
    request->command = "tandem stability report";
    for (const std::filesystem::path& file : request->files) {
      request->command += " " + file.string();
    }
    request->command += " --out " + request->folder.string();
    exit_code = MakeReport(*request);
  });
}

}  // namespace tandem

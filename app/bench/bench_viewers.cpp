#include "app/bench/bench_viewers.h"

#include <algorithm>
#include <csignal>
#include <fstream>

#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"

namespace tandem {

Result<ViewerProcesses> ViewerProcesses::Launch(const std::string& session, std::size_t count) {
  ViewerProcesses audience;
  if (count == 0) return audience;
  Result<bool> started = audience.Start({"relay"}, session);
  for (std::size_t v = 0; v < count && started; ++v) {
    started =
        audience.Start({"watch", "--from-relay", "--report", audience.Report(v).string()}, session);
  }
  if (!started) return started.error();
  return audience;
}

Result<bool> ViewerProcesses::Start(std::vector<std::string> command, const std::string& session) {
  command.insert(command.begin(), (ProgramFolder() / "tandem").string());
  command.insert(command.end(), {"--interface", "lo", "--session", session});
  // in use, viewers run elsewhere; here they at least use none of the peers' cores
  const HalfOfTheCores apart(HalfOfTheCores::Half::kSecond);
  Result<ChildProcess> process = ChildProcess::Start(command);
  if (!process) return process.error();
  processes_.push_back(std::move(*process));
  return true;
}

Result<std::uint64_t> ViewerProcesses::End() {
  constexpr std::chrono::seconds kPatience{30};
  std::uint64_t least = ~std::uint64_t{0};
  for (ChildProcess& process : processes_) process.Signal(SIGTERM);
  for (std::size_t i = 0; i < processes_.size(); ++i) {
    if (processes_[i].Wait(kPatience).value_or(-1) != kExitOk) {
      return Error{i == 0 ? "the relay failed" : "a viewer failed"};
    }
    if (i == 0) continue;
    std::ifstream stream(Report(i - 1));
    const nlohmann::json report = nlohmann::json::parse(stream, nullptr, false);
    if (report.is_discarded()) return Error{"a viewer left no report"};
    least = std::min(least, report.at("samples").get<std::uint64_t>());
  }
  return processes_.empty() ? 0 : least;
}

std::filesystem::path ViewerProcesses::Report(std::size_t viewer) const {
  return folder_->path() / (std::to_string(viewer) + ".json");
}

}  // namespace tandem

#include "collab/controller/controller.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "collab/controller/plain.h"
#include "collab/dds/control/control_domain.h"
#include "collab/dds/control/controller_link.h"

namespace tandem {

namespace {

constexpr std::chrono::milliseconds kKeysStep{10};  // between two searches for keys

/// The keys that a controller of that name has made for its hosts, and a line that identifies them.
struct HostKeys {
  std::filesystem::path folder;  // empty: it has made none
  std::string which;

  friend bool operator==(const HostKeys&, const HostKeys&) = default;
};

HostKeys FindHostKeys(const std::filesystem::path& folder) {
  std::ifstream member(folder / "member.txt");  // written last
  HostKeys keys{.folder = folder, .which = {}};
  if (!std::getline(member, keys.which)) return {};
  return keys;
}

}  // namespace

Result<Controller> Controller::Attach(const std::string& name, const Options& options) {
  std::filesystem::path folder = options.keys;
  if (folder.empty()) {
    const Result<std::filesystem::path> own = ControlFolder();
    if (!own) return own.error();
    folder = *own / (name + ".keys") / "host";
  }
  const std::int64_t until_ns =
      MonotonicNow_ns() + static_cast<std::int64_t>(1e9 * options.timeout_s);
  for (;;) {
    const HostKeys keys = FindHostKeys(folder);
    // without keys any user of the machine may speak under that name
    if (options.secured && keys.folder.empty()) {
      if (MonotonicNow_ns() > until_ns) {
        return Error{"no controller '" + name + "' with keys on this machine: 'tandem peer " +
                     "--control " + name + " --secure KEYS …' starts one"};
      }
      std::this_thread::sleep_for(kKeysStep);
      continue;
    }
    Result<ControlDomain> domain = EnterControlDomain(name, options.domain, keys.folder);
    if (!domain) return domain.error();
    auto link = std::make_unique<Link>(name, options, *std::move(domain));
    if (!link->Open()) return Error{"the command interface cannot be opened on this machine"};
    // a controller that is only starting has its keys later
    do {
      if (link->Meet()) {
        link->Introduce(until_ns);
        return Controller(std::move(link));
      }
      if (std::optional<Error> fault = link->VersionFault()) return *fault;
      if (MonotonicNow_ns() > until_ns) {
        return Error{"no controller '" + name + "' on this machine: 'tandem peer --control " +
                     name + " …' starts one"};
      }
    } while (FindHostKeys(folder) == keys);
  }
}

Controller::Controller(std::unique_ptr<Link> link) : link_(std::move(link)) {}
Controller::Controller(Controller&&) noexcept = default;
Controller& Controller::operator=(Controller&&) noexcept = default;
Controller::~Controller() = default;

bool Controller::attached() const {
  return link_->attached();
}

void Controller::Send(const ControlRequest& request, OnAnswer on_answer) {
  link_->Send(request, std::move(on_answer));
}

Answer Controller::Ask(const ControlRequest& request, double timeout_s) {
  // the callback keeps it alive: an answer may come after the time is up
  const auto answered = std::make_shared<std::optional<Answer>>();
  link_->Send(request, [answered](const Answer& answer) {
    *answered = answer;
  });
  const std::int64_t until_ns = MonotonicNow_ns() + static_cast<std::int64_t>(1e9 * timeout_s);
  while (!*answered && MonotonicNow_ns() < until_ns) Wait(std::chrono::milliseconds(20));
  return answered->value_or(Answer{false, "no answer in time"});
}

void Controller::SetGoal(const PlainPose& X_WG) {
  link_->SetGoal(HostGoal::Kind::kPose, AsPose(X_WG), Vec3::Zero(), Vec3::Zero());
}

void Controller::SetRate(const std::array<double, 3>& v_W, const std::array<double, 3>& w_W) {
  link_->SetGoal(HostGoal::Kind::kRate, Pose(), AsVec3(v_W), AsVec3(w_W));
}

void Controller::SetPush(const std::array<double, 3>& force_N,
                         const std::array<double, 3>& torque_Nm) {
  link_->SetGoal(HostGoal::Kind::kPush, Pose(), AsVec3(force_N), AsVec3(torque_Nm));
}

void Controller::OnSnapshot(std::function<void(const ControllerSnapshot&)> callback) {
  link_->OnSnapshot(std::move(callback));
}

const ControllerSnapshot& Controller::snapshot() const {
  return link_->snapshot();
}

bool Controller::Poll() {
  return link_->Poll();
}

bool Controller::Wait(std::chrono::milliseconds at_most) {
  if (link_->Poll()) return true;
  link_->WaitForSomething(at_most);
  return link_->Poll();
}

}  // namespace tandem

#include "collab/controller/controller.h"

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "collab/controller/plain.h"
#include "collab/dds/control/control_folder.h"
#include "collab/dds/control/controller_link.h"

namespace tandem {

Result<Controller> Controller::Attach(const std::string& name, const Options& options) {
  const Result<std::filesystem::path> folder = ControlFolder();
  if (!folder) return folder.error();
  const std::int64_t until_ns =
      MonotonicNowNs() + static_cast<std::int64_t>(1e9 * options.timeout_s);
  auto link = std::make_unique<Link>(name, options, *folder);
  do {
    if (link->Meet()) {
      link->Introduce(until_ns);
      return Controller(std::move(link));
    }
    if (std::optional<Error> fault = link->VersionFault()) return *fault;
  } while (MonotonicNowNs() < until_ns);
  const std::string why = link->WhyNotConnected();
  return Error{(why.empty() ? "the controller '" + name + "' does not answer" : why) +
               ": 'tandem peer --control " + name + " …' starts one"};
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
  const std::int64_t until_ns = MonotonicNowNs() + static_cast<std::int64_t>(1e9 * timeout_s);
  while (!*answered && MonotonicNowNs() < until_ns) Wait(std::chrono::milliseconds(20));
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

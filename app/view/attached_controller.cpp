#include "app/common/stop_signal.h"
#include "app/view/controller_process.h"
#include "collab/controller/controller.h"

namespace tandem {

namespace {

constexpr double kQuitSeconds = 1;
constexpr double kHastyQuitSeconds = 0.1;  // while a signal ends this program
constexpr double kAttachSeconds = 0.5;     // for each of many tries

class AttachedController : public ControllerLink {
 public:
  explicit AttachedController(Controller controller) : controller_(std::move(controller)) {}

  bool attached() const override { return controller_.attached(); }
  void Send(const ControlRequest& request, OnAnswer on_answer) override {
    controller_.Send(request, std::move(on_answer));
  }
  void SetGoal(const PlainPose& X_WG) override { controller_.SetGoal(X_WG); }
  const ControllerSnapshot& snapshot() const override { return controller_.snapshot(); }
  void Quit() override {
    const bool hasty = StopRequestedWithin(std::chrono::nanoseconds(0));
    controller_.Ask(QuitRequest{}, hasty ? kHastyQuitSeconds : kQuitSeconds);
  }
  bool Poll() override { return controller_.Poll(); }

 private:
  Controller controller_;
};

}  // namespace

Result<std::unique_ptr<ControllerLink>> AttachController(const std::string& name) {
  Controller::Options options;
  options.host = "tandem-view";
  options.timeout_s = kAttachSeconds;
  Result<Controller> controller = Controller::Attach(name, options);
  if (!controller) return controller.error();
  return std::unique_ptr<ControllerLink>(
      std::make_unique<AttachedController>(*std::move(controller)));
}

}  // namespace tandem

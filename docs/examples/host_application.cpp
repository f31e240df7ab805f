// host_application CONTROLLER BODY: takes a body in the controller's hand, lifts it by 20 mm, says
// what it meets, lets go. Start a controller first: tandem peer --session S --scene SCENE --control
// CONTROLLER
#include <chrono>
#include <cstdio>

#include <tandem/collab/controller/controller.h>

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: host_application CONTROLLER BODY\n"), 2;
  tandem::Controller::Options options;
  options.host = "host_application";
  tandem::Result<tandem::Controller> attached = tandem::Controller::Attach(argv[1], options);
  if (!attached) return std::fprintf(stderr, "%s\n", attached.error().what.c_str()), 5;
  tandem::Controller& controller = *attached;

  const tandem::Answer grabbed = controller.Ask(tandem::GrabRequest{argv[2], {}});
  if (!grabbed.ok) return std::fprintf(stderr, "%s\n", grabbed.reason.c_str()), 1;
  while (controller.snapshot().hand.body < 0) controller.Wait(std::chrono::milliseconds(100));
  tandem::PlainPose goal = controller.snapshot().hand.X_WG;  // the grasp frame, where it is now
  const double start = goal.p_W[2];

  int contacts = 0;
  controller.OnSnapshot([&](const tandem::ControllerSnapshot& snapshot) {
    if (snapshot.contact_points > contacts) contacts = snapshot.contact_points;
  });
  for (int step = 1; step <= 100; ++step) {  // 20 mm in a second, then half a second of rest
    goal.p_W[2] = start + 0.02 * step / 100;
    controller.SetGoal(goal);
    for (auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(10);
         std::chrono::steady_clock::now() < until;) {
      controller.Wait(std::chrono::milliseconds(2));
    }
  }
  for (int turn = 0; turn < 30; ++turn) controller.Wait(std::chrono::milliseconds(17));
  const tandem::SnapshotHand hand = controller.snapshot().hand;
  std::printf("lifted_mm %.2f  hand_N %.2f  most_contacts %d\n", 1e3 * (hand.X_WG.p_W[2] - start),
              hand.force_N[2], contacts);
  controller.Ask(tandem::ReleaseRequest{});
}

// host_for_tests CONTROLLER BODY METRES FILE attaches, says what it found in FILE, takes the body,
// pulls it that far along x, and goes on until it is killed.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "collab/controller/controller.h"

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  const auto begin = std::chrono::steady_clock::now();
  tandem::Controller::Options options;
  options.host = "host_for_tests";
  options.timeout_s = 60;
  tandem::Result<tandem::Controller> host = tandem::Controller::Attach(argv[1], options);
  if (!host) {
    std::fprintf(stderr, "%s\n", host.error().what.c_str());
    return 5;
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  tandem::Answer grabbed = host->Ask(tandem::GrabRequest{argv[2], {}});
  // on a loaded machine the controller may still be at its scene
  for (int i = 0; i < 600 && grabbed.reason == "the scene is being loaded"; ++i) {
    host->Wait(std::chrono::milliseconds(50));
    grabbed = host->Ask(tandem::GrabRequest{argv[2], {}});
  }
  if (!grabbed.ok) {
    std::fprintf(stderr, "%s\n", grabbed.reason.c_str());
    return 1;
  }
  const std::size_t bodies = host->snapshot().bodies.size();
  while (host->snapshot().hand.body < 0) host->Wait(std::chrono::milliseconds(100));
  tandem::PlainPose goal = host->snapshot().hand.X_WG;
  const double start = goal.p_W[0];
  const double pull = std::atof(argv[3]);
  for (int step = 1; step <= 50; ++step) {
    goal.p_W[0] = start + pull * step / 50;
    host->SetGoal(goal);
    host->Wait(std::chrono::milliseconds(10));
  }
  // a program that waits for the file finds it whole
  const std::string unfinished = std::string(argv[4]) + ".unfinished";
  std::ofstream(unfinished) << took.count() << ' ' << bodies << ' ' << host->snapshot().peers.size()
                            << std::endl;
  std::filesystem::rename(unfinished, argv[4]);
  for (;;) host->Wait(std::chrono::milliseconds(100));
}

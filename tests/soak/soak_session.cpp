#include "tests/soak/soak_session.h"

#include <algorithm>
#include <csignal>
#include <random>
#include <sstream>
#include <thread>
#include <utility>

#include <gtest/gtest.h>
#include <sys/mount.h>

#include "engine/base/check.h"
#include "scenes/generators/hand_file.h"

namespace tandem::testing {

namespace {

constexpr std::chrono::milliseconds kTick{50};
constexpr double kAskEvery = 0.25;      // s, between orders `peers`
constexpr double kDiskPatience = 60;    // s, until a peer has started again and its disk is full
constexpr double kGoodbyePatience = 5;  // s
constexpr double kSoundDelayMs = 1000;  // delay of a partner whose answers come again
constexpr const char* kAttackerId = "999999";

/// Presses the peg onto the slot's floor, along it, and up against the tooth, again and again. The
/// slot leaves 7 mm on each side (scenes/generators/peg_in_slot.cpp); 18 mm press by several
/// newtons.
HandScript PressingHand(std::size_t place, double seconds) {
  constexpr double kLegSeconds = 4;
  const double scale = 1 + 0.05 * static_cast<double>(place);
  const std::vector<Vec3> round{
      {0, 0, -0.018}, {0.012, 0, -0.018}, {0.012, 0, 0.018}, {0, 0, 0.018}};
  HandScript script;
  script.impedance.damping = 12;
  script.waypoints.push_back({});
  for (double t = kLegSeconds; t < seconds + kLegSeconds; t += kLegSeconds) {
    const std::size_t leg = (script.waypoints.size() - 1) % round.size();
    script.waypoints.push_back({t, scale * round[leg], Quat::Identity()});
  }
  return script;
}

}  // namespace

SoakSession::SmallDisk::SmallDisk(std::filesystem::path folder, int kilobytes)
    : folder_(std::move(folder)) {
  std::filesystem::create_directory(folder_);
  const std::string options = "size=" + std::to_string(kilobytes) + "k";
  TANDEM_CHECK(mount("tmpfs", folder_.c_str(), "tmpfs", MS_NOSUID | MS_NODEV, options.c_str()) ==
               0);
}

SoakSession::SmallDisk::~SmallDisk() {
  umount2(folder_.c_str(), MNT_DETACH);
}

SoakSession::SoakSession(double longest_s)
    : longest_s_(longest_s),
      session_("soak-" + std::to_string(std::random_device{}())),
      files_{.folder = folder_.path(), .temporary = folder_.path() / "temporary"} {
  std::filesystem::create_directory(files_.temporary);
  auto hub = TapHub::Open(SoakPlaces::kPrograms + 1, [](std::size_t, std::size_t) {
    return LinkConditions{.delay_ms = kDelayMs};
  });
  TANDEM_CHECK(hub.has_value());
  hub_ = *std::move(hub);
}

SoakSession::~SoakSession() = default;

double SoakSession::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - made_).count();
}

void SoakSession::Begin() {
  for (std::size_t place = 0; place < SoakPlaces::kPrograms; ++place) Start(place);
}

void SoakSession::Start(std::size_t place, const std::vector<std::string>& more) {
  programs_[place] = std::make_unique<SoakProgram>(place, ++lives_begun_[place], files_, seconds());
  SoakProgram& program = *programs_[place];
  std::vector<std::string> command = program.Environment();
  const std::vector<std::string> own =
      place < SoakPlaces::kPeers ? PeerCommandLine(program, place) : ViewerCommandLine(program);
  command.insert(command.end(), own.begin(), own.end());
  command.insert(command.end(), more.begin(), more.end());
  program.Start(hub_->At(place, std::move(command)));
}

std::vector<std::string> SoakSession::PeerCommandLine(const SoakProgram& program,
                                                      std::size_t place) const {
  const std::string hand =
      folder_.Write(program.name() + ".json", HandFile(PressingHand(place, longest_s_ - seconds())))
          .string();
  return {TANDEM_PROGRAM,
          "peer",
          "--session",
          session_,
          "--scene",
          (std::filesystem::path(TANDEM_SCENES) / "peg_in_slot.json").string(),
          "--interface",
          TapHub::kInterface,
          "--name",
          program.name(),
          "--hold",
          "peg",
          "--hand",
          hand,
          "--wait-for",
          std::to_string(SoakPlaces::kPeers - 1),
          "--capacity",
          "20000",
          "--brief",
          "--report",
          program.report().string()};
}

std::vector<std::string> SoakSession::ViewerCommandLine(const SoakProgram& program) const {
  return {TANDEM_PROGRAM,     "watch",  "--session",    session_,   "--interface",
          TapHub::kInterface, "--name", program.name(), "--report", program.report().string()};
}

void SoakSession::Tick() {
  std::this_thread::sleep_for(kTick);
  for (std::size_t place = 0; place < programs_.size(); ++place) {
    if (!programs_[place] || programs_[place]->Look(seconds())) continue;
    ADD_FAILURE() << programs_[place]->name() << " has ended by itself after " << seconds()
                  << " s:\n"
                  << programs_[place]->OutputOf();
    Bury(place);
  }
}

void SoakSession::Bury(std::size_t place) {
  lives_.push_back(programs_[place]->Life(seconds()));
  programs_[place].reset();
}

void SoakSession::Watch(double for_s) {
  const double until_s = seconds() + for_s;
  while (seconds() < until_s) Tick();
}

bool SoakSession::AwaitSaid(std::size_t place, const std::string& words, double within_s) {
  const double until_s = seconds() + within_s;
  while (programs_[place] && programs_[place]->OutputOf().find(words) == std::string::npos) {
    if (seconds() > until_s) return false;
    Tick();
  }
  return programs_[place] != nullptr;
}

bool SoakSession::Together() {
  for (std::size_t place = 0; place < programs_.size(); ++place) {
    if (!programs_[place]) return false;
    for (std::size_t other = 0; other < SoakPlaces::kPeers; ++other) {
      if (other == place) continue;
      if (!programs_[other]) return false;
      ProgramLog& log = programs_[place]->log();
      const std::string& name = programs_[other]->name();
      if (place >= SoakPlaces::kPeers) {
        if (!log.seen().contains(name)) return false;
        continue;
      }
      const auto row = log.rows().find(name);
      if (row == log.rows().end() || !row->second.coupled) return false;
      if (row->second.delay_ms < 0 || row->second.delay_ms > kSoundDelayMs) return false;
    }
  }
  return true;
}

std::optional<double> SoakSession::AwaitTogether(double within_s) {
  const double began_s = seconds();
  double asked_s = began_s - kAskEvery;
  for (const auto& program : programs_) {
    if (program) program->log().Forget();
  }
  while (!Together()) {
    const double now_s = seconds();
    if (now_s - began_s > within_s) return std::nullopt;
    if (now_s - asked_s >= kAskEvery) {
      asked_s = now_s;
      for (std::size_t place = 0; place < SoakPlaces::kPeers; ++place) {
        if (programs_[place]) programs_[place]->Order("peers");
      }
    }
    Tick();
  }
  return seconds() - began_s;
}

void SoakSession::Strike(const SoakFault& fault) {
  using Kind = SoakFault::Kind;
  if (fault.kind == Kind::kFlood) return Flood(fault);
  if (fault.kind == Kind::kFullDisk) return FillDisk(fault);
  std::unique_ptr<SoakProgram>& struck = programs_[fault.place];
  if (!struck) return;
  switch (fault.kind) {
    case Kind::kKill:
      struck->Kill();
      Bury(fault.place);
      Watch(fault.lasts_s);
      return Start(fault.place);
    case Kind::kStop:
      struck->StopFor(true, seconds());
      Watch(fault.lasts_s);
      return struck->StopFor(false, seconds());
    case Kind::kCut:
      Cut(fault, true);
      Watch(fault.lasts_s);
      return Cut(fault, false);
    case Kind::kClockStep:
      struck->StepClock(fault.step_s);
      return Watch(fault.lasts_s);
    default:
      break;
  }
}

void SoakSession::Cut(const SoakFault& fault, bool cut) {
  const LinkConditions conditions{.delay_ms = kDelayMs, .cut = cut};
  for (std::size_t other = 0; other < SoakPlaces::kPrograms; ++other) {
    if (other == fault.place) continue;
    if (fault.way != SoakFault::Way::kIn) hub_->Switch(fault.place, other, conditions);
    if (fault.way != SoakFault::Way::kOut) hub_->Switch(other, fault.place, conditions);
  }
}

void SoakSession::FillDisk(const SoakFault& fault) {
  if (programs_[fault.place]) EndOne(fault.place, SoakPlaces::kPeers);
  const std::string name = "disk-" + std::to_string(disks_.size());
  disks_.push_back(std::make_unique<SmallDisk>(folder_.path() / name, fault.disk_kb));
  Start(fault.place, {"--record", (disks_.back()->folder() / "recording").string()});
  const bool reported =
      AwaitSaid(fault.place, "cannot be written: No space left on device", kDiskPatience);
  EXPECT_TRUE(reported) << "nobody is told that a disk is full:\n" << LastWords();
  if (reported) programs_[fault.place]->DiskIsFull();
}

void SoakSession::Flood(const SoakFault& fault) {
  const std::filesystem::path output = folder_.path() / ("flood-" + std::to_string(++floods_));
  Program attacker(
      hub_->At(SoakPlaces::kAttacker, {TANDEM_ATTACKER, session_, "-", kAttackerId, fault.flood,
                                       std::to_string(fault.lasts_s), "0", TapHub::kInterface}),
      output);
  EXPECT_TRUE(attacker.Says("joined")) << attacker.output();
  attacker.process().Signal(SIGUSR1);
  while (!attacker.process().Poll()) Tick();
  EXPECT_NE(attacker.output().find("sent "), std::string::npos) << attacker.output();
}

void SoakSession::EndOne(std::size_t place, std::optional<std::size_t> witness) {
  if (!programs_[place]) return;
  programs_[place]->End();
  const std::string words = "tandem: " + programs_[place]->name() + " left";
  const std::size_t life = lives_.size();
  Bury(place);
  if (witness) lives_[life].said_goodbye = AwaitSaid(*witness, words, kGoodbyePatience);
}

void SoakSession::End() {
  constexpr std::size_t kFirstViewer = SoakPlaces::kPeers;
  EndOne(kFirstViewer + 1, 0);
  for (std::size_t place = kFirstViewer; place-- > 0;) EndOne(place, kFirstViewer);
  EndOne(kFirstViewer, std::nullopt);
}

std::vector<std::string> SoakSession::LeftFiles() const {
  std::vector<std::string> left;
  for (const auto& one : std::filesystem::directory_iterator(files_.temporary)) {
    left.push_back(one.path().string());
  }
  return left;
}

std::vector<std::string> SoakSession::LeftProcesses() const {
  std::vector<std::string> left;
  for (const auto& one : std::filesystem::directory_iterator("/proc")) {
    // unreadable for processes that have just ended
    const std::string environment = TextOf(one.path() / "environ");
    if (environment.find(files_.temporary.string()) != std::string::npos) {
      left.push_back(TextOf(one.path() / "cmdline"));
    }
  }
  return left;
}

std::string SoakSession::LastWords() const {
  std::ostringstream text;
  for (const auto& program : programs_) {
    if (!program) continue;
    text << program->name() << " hears";
    for (const auto& [name, row] : program->log().rows()) {
      text << " " << name << (row.coupled ? " (coupled)" : "");
    }
    for (const std::string& name : program->log().seen()) text << " " << name;
    text << ", and said:\n";
    for (const std::string& line : program->log().newest()) text << "  " << line << "\n";
  }
  return text.str();
}

}  // namespace tandem::testing

#include "tests/soak/soak_program.h"

#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/check.h"

namespace tandem::testing {

namespace {

constexpr double kCountEvery = 1;  // s

std::size_t OpenFilesOf(pid_t process) {
  std::error_code gone;
  const std::filesystem::directory_iterator files("/proc/" + std::to_string(process) + "/fd", gone);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

void WriteStep(const std::filesystem::path& file, std::int64_t step_ns) {
  const int clock = open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  TANDEM_CHECK(clock >= 0 && pwrite(clock, &step_ns, sizeof step_ns, 0) == sizeof step_ns);
  close(clock);
}

}  // namespace

SoakProgram::SoakProgram(std::size_t place, int life, const Files& files, double now_s)
    : files_(files),
      life_{.place = place,
            .name = std::string(SoakPlaces::NameOf(place)) + "-" + std::to_string(life),
            .began_s = now_s},
      log_(FileOf("said")) {
  life_.report = FileOf("report");
  WriteStep(FileOf("clock"), 0);
  const std::string pipe = FileOf("orders");
  TANDEM_CHECK(mkfifo(pipe.c_str(), 0600) == 0);
  // for reading too, so that neither end waits for the other
  orders_ = open(pipe.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  TANDEM_CHECK(orders_ >= 0);
}

SoakProgram::~SoakProgram() {
  if (program_ && stopped()) program_->process().Signal(SIGCONT);
  close(orders_);
}

std::filesystem::path SoakProgram::FileOf(const char* ending) const {
  return files_.folder / (life_.name + "." + ending);
}

std::vector<std::string> SoakProgram::Environment() const {
  std::vector<std::string> words{"/usr/bin/env", "TMPDIR=" + files_.temporary.string()};
#ifdef TANDEM_STEPPED_CLOCK
  words.emplace_back("LD_PRELOAD=" TANDEM_STEPPED_CLOCK);
  words.push_back("STEPPED_CLOCK=" + FileOf("clock").string());
#endif
  return words;
}

void SoakProgram::Start(const std::vector<std::string>& command) {
  program_.emplace(command, FileOf("said"), FileOf("orders"));
}

bool SoakProgram::Look(double now_s) {
  log_.Read(now_s);
  if (program_->process().Poll()) return false;
  if (now_s - counted_s_ < kCountEvery) return true;
  counted_s_ = now_s;
  life_.footprints.push_back({.at_s = now_s,
                              .memory = program_->Memory(),
                              .files = OpenFilesOf(program_->process().pid())});
  return true;
}

void SoakProgram::Order(const std::string& line) {
  if (stopped()) return;
  const std::string text = line + "\n";
  EXPECT_EQ(write(orders_, text.data(), text.size()), static_cast<ssize_t>(text.size()))
      << name() << " reads no orders";
}

void SoakProgram::StopFor(bool stopped, double now_s) {
  program_->process().Signal(stopped ? SIGSTOP : SIGCONT);
  if (stopped) {
    stopped_since_s_ = now_s;
    return;
  }
  life_.stopped_s += now_s - stopped_since_s_.value_or(now_s);
  stopped_since_s_.reset();
}

void SoakProgram::StepClock(double seconds) {
  step_s_ += seconds;
  WriteStep(FileOf("clock"), static_cast<std::int64_t>(1e9 * step_s_));
}

void SoakProgram::Kill() {
  life_.killed = true;
  program_->process().Signal(SIGKILL);
  EXPECT_EQ(program_->Wait(), 128 + SIGKILL);
}

void SoakProgram::End() {
  const auto began = std::chrono::steady_clock::now();
  program_->process().Signal(SIGTERM);
  life_.exit_code = program_->Wait();
  life_.took_to_end_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

SoakLife SoakProgram::Life(double now_s) {
  log_.Read(now_s);
  SoakLife life = life_;
  life.ended_s = now_s;
  life.most_lines_per_s = static_cast<double>(log_.most_lines()) / ProgramLog::kWindow;
  life.lines = log_.lines();
  life.losses = log_.losses();
  life.not_finite = log_.not_finite();
  return life;
}

}  // namespace tandem::testing

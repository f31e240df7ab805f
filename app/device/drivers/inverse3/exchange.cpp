#include "app/device/drivers/inverse3/exchange.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "app/device/drivers/driver_support.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/realtime_setup.h"

namespace tandem::driver::inverse3 {
namespace {

constexpr std::int64_t kLimitNs = 5'000'000'000;  // for an answer
constexpr std::int64_t kByeNs = 100'000'000;
constexpr std::int64_t kForeverNs = 1'000'000'000'000'000;
constexpr std::int64_t kFirstWaitNs = 500'000'000;
constexpr std::int64_t kLongestWaitNs = 10'000'000'000;
constexpr std::int64_t kSliceNs = 20'000'000;
constexpr std::int64_t kNoteNs = 1'000'000'000;  // time for which an event counts
constexpr int kPriority = 39;                    // below the device's loop
constexpr int kMostUnsound = 20;                 // messages in a row
constexpr int kMostAtOnce = 32;                  // further messages that are read at once
constexpr int kUnanswered = 500;
constexpr double kNoticeable = 0.3;  // N
constexpr double kFollows = 0.1;     // share of the force asked for
constexpr double kTurnSeconds = 0.005;

}  // namespace

Exchange::Exchange(const Place& place, Choice choice, const TandemDeviceHost& host)
    : place_(place), choice_(std::move(choice)), host_(&host), socket_(ending_), events_(ending_) {
  newest_.Write(reading_);
}

void Exchange::Start() {
  talker_ = std::thread([this] {
    EnterRealtime(kPriority);
    try {
      Talk();
    } catch (const std::exception& thrown) {
      Publish(TANDEM_BROKEN);
      trouble_.Say(thrown.what());
    }
  });
  if (place_.events_port == 0) return;
  listener_ = std::thread([this] {
    try {
      Listen();
    } catch (const std::exception&) {
      // without memory for events, which states report in part too
    }
  });
}

void Exchange::End() {
  ending_.store(true);
  if (talker_.joinable()) talker_.join();
  if (listener_.joinable()) listener_.join();
}

void Exchange::Wait(std::int64_t ns) const {
  const std::int64_t until_ns = MonotonicNowNs() + ns;
  while (!ending_.load() && MonotonicNowNs() < until_ns) {
    MachineClock().SleepUntil(std::min(until_ns, MonotonicNowNs() + kSliceNs));
  }
}

void Exchange::Talk() {
  const std::string where = "127.0.0.1:" + std::to_string(place_.port);
  std::int64_t wait_ns = kFirstWaitNs;
  while (!ending_.load()) {
    std::string fault;
    if (socket_.Connect(place_.port, kLimitNs)) {
      if (TalkWhileConnected(fault)) wait_ns = kFirstWaitNs;
      if (ending_.load()) break;
    }
    if (fault.empty()) {
      fault = "the Inverse Service on " + where + " does not answer (" + socket_.fault() +
              "): start it, 'systemctl start haply-inverse-service'";
    }
    TellUnplugged(fault);
    Wait(wait_ns);
    wait_ns = std::min(2 * wait_ns, kLongestWaitNs);
  }
}

bool Exchange::TalkWhileConnected(std::string& fault) {
  std::string text, why, line;
  const auto period_ns = static_cast<std::int64_t>(1e9 / place_.rate_hz);
  bool received = false;
  bool first = true;
  int unsound = 0;
  unanswered_ = 0;
  ignored_ = false;
  reported_ = {};
  if (!socket_.Receive(text, kLimitNs)) return false;  // the first message, unasked
  for (std::int64_t due_ns = MonotonicNowNs(); !ending_.load();) {
    const Vec3 force = ForceNow();
    WriteCommand(choice_, force, std::exchange(first, false), text);
    if (!socket_.Send(text, kLimitNs) || !socket_.Receive(text, kLimitNs)) return received;
    for (int i = 0; i < kMostAtOnce && socket_.pending(); ++i) {
      if (!socket_.Receive(text, kLimitNs)) return received;
    }
    const std::int64_t now_ns = MonotonicNowNs();
    const Quat before = reported_.orientation;
    if (ReadState(text, choice_, reported_, why)) {
      received = true;
      unsound = 0;
      TurnFrom(before, ToSeconds(now_ns - reading_.time_ns));
      CheckForce(force);
      ++reading_.number;
      reading_.time_ns = now_ns;
      const std::int32_t condition = ConditionOf(line);
      Publish(condition);
      trouble_.Say(condition == TANDEM_OK ? std::string() : line);
    } else if (++unsound > kMostUnsound) {
      fault = "the Inverse Service's messages cannot be read (" + why +
              "): this driver works with its version 3.5: update the service";
      socket_.Close(kByeNs);
      return false;
    }
    due_ns += period_ns;
    if (due_ns < MonotonicNowNs()) due_ns = MonotonicNowNs();  // late: does not catch up
    MachineClock().SleepUntil(due_ns);
  }
  WriteCommand(choice_, Vec3::Zero(), false, text);
  socket_.Close(kByeNs, text);
  return received;
}

Vec3 Exchange::ForceNow() {
  TandemDeviceForce force{};
  force.struct_size = sizeof force;
  host_->take(host_->context, &force);
  const Vec3 f(force.force);
  const bool allowed = reading_.condition == TANDEM_OK && !stopped_.load() && f.allFinite();
  return allowed ? f : Vec3::Zero();
}

std::int32_t Exchange::ConditionOf(std::string& line) {
  Note note;
  if (note_.Read(note) && MonotonicNowNs() < note.until_ns) {
    line = note.line;
    return note.condition;
  }
  if (!reported_.arm) {
    line = "the Inverse3 '" + choice_.arm + "' is not connected: plug in its USB cable";
    return TANDEM_UNPLUGGED;
  }
  if (!reported_.powered) {
    line = "the Inverse3 has no power: plug in its power supply";
    return TANDEM_UNPLUGGED;
  }
  if (!reported_.calibrated) {
    line =
        "the Inverse3 is not calibrated: lay its arm into the rest position, as in Haply's guide";
    return TANDEM_UNCALIBRATED;
  }
  if (!reported_.ready) {
    line = "the Inverse3 is not ready: wait; if that does not help, look into Haply Hub";
    return TANDEM_UNPLUGGED;
  }
  if (choice_.grip && !reported_.grip) {
    line = "the VerseGrip '" + choice_.grip->id + "' does not answer: press one of its buttons";
    return TANDEM_UNPLUGGED;
  }
  if (ignored_) {
    const bool newer = choice_.form == ForceForm::kVector;
    line = std::string("the Inverse Service ignores forces written as ") +
           (newer ? "'vector': try the option force=values, or update the service"
                  : "'values': try the option force=vector");
    return TANDEM_FAILED;
  }
  return TANDEM_OK;
}

void Exchange::CheckForce(const Vec3& requested) {
  if (!reported_.force || requested.norm() < kNoticeable) return;
  unanswered_ = reported_.force->norm() < kFollows * requested.norm() ? unanswered_ + 1 : 0;
  ignored_ = ignored_ || unanswered_ >= kUnanswered;
}

void Exchange::TurnFrom(const Quat& before, double seconds) {
  if (reading_.condition != TANDEM_OK || seconds <= 0 || seconds > 10 * kTurnSeconds) {
    turning_ = Vec3::Zero();
    return;
  }
  const Vec3 now = RotationVector(reported_.orientation * before.conjugate()) / seconds;
  turning_ += seconds / (seconds + kTurnSeconds) * (now - turning_);
}

void Exchange::Publish(std::int32_t condition) {
  reading_.condition = condition;
  const bool moves = condition == TANDEM_OK;
  reading_.buttons = moves ? reported_.buttons : 0;
  for (int i = 0; i < 3; ++i) {
    reading_.position[i] = reported_.position[i];
    reading_.velocity[i] = moves ? reported_.velocity[i] : 0;
    reading_.angular_velocity[i] = moves ? turning_[i] : 0;
  }
  for (int i = 0; i < 4; ++i) reading_.orientation[i] = reported_.orientation.coeffs()[i];
  newest_.Write(reading_);
}

void Exchange::TellUnplugged(const std::string& line) {
  Publish(TANDEM_UNPLUGGED);
  trouble_.Say(line);
}

void Exchange::Listen() {
  std::string text;
  std::int64_t wait_ns = kFirstWaitNs;
  while (!ending_.load()) {
    if (events_.Connect(place_.events_port, kLimitNs)) {
      wait_ns = kFirstWaitNs;
      // events are rare, so silence is no fault
      while (events_.Receive(text, kForeverNs)) Take(ReadEvent(text, choice_.arm));
    }
    Wait(wait_ns);
    wait_ns = std::min(2 * wait_ns, kLongestWaitNs);
  }
}

void Exchange::Take(const Event& event) {
  Note note;
  std::string line;
  switch (event.kind) {
    case Event::Kind::kNone:
      return;
    case Event::Kind::kConnected:
      note_.Write(note);
      return;
    case Event::Kind::kDisconnected:
      note.condition = TANDEM_UNPLUGGED;
      line = "the Inverse3 is not connected: plug in its USB cable";
      break;
    case Event::Kind::kBusy:
      note.condition = TANDEM_UNPLUGGED;
      line = "another program uses the Inverse3: end that one";
      break;
    case Event::Kind::kSafety:
      note.condition = TANDEM_UNPLUGGED;
      line = "the Inverse3 has stopped its motors for safety: move it slowly";
      break;
    case Event::Kind::kCalibration:
      note.condition = TANDEM_UNCALIBRATED;
      line = "the Inverse3 could not be calibrated: lay its arm into the rest position";
      break;
  }
  if (!event.words.empty()) line += " (" + event.words + ")";
  note.until_ns = MonotonicNowNs() + kNoteNs;
  Put(note.line, line);
  note_.Write(note);
}

}  // namespace tandem::driver::inverse3

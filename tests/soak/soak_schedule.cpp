#include "tests/soak/soak_schedule.h"

#include <array>
#include <utility>

namespace tandem::testing {

namespace {

constexpr std::array<const char*, SoakPlaces::kPrograms> kNamesOfPlaces{"anna", "ben", "cleo",
                                                                        "vera", "will"};
constexpr std::array<std::size_t, 3> kMortal{1, 2, SoakPlaces::kPeers + 1};
constexpr std::array<std::size_t, 2> kRecording{1, 2};
constexpr std::array<double, 8> kSteps{-86400, -3600, -30, -1, 1, 30, 3600, 86400};  // s
constexpr std::array<const char*, 2> kFloods{"lookers", "views"};
constexpr std::array<const char*, 3> kWays{"out", "in", "both"};

template <typename T, std::size_t n>
T OneOf(const std::array<T, n>& all, RandomSource& rng) {
  return all[static_cast<std::size_t>(rng.Whole(0, static_cast<int>(n) - 1))];
}

std::size_t AnyPlace(RandomSource& rng) {
  return static_cast<std::size_t>(rng.Whole(0, static_cast<int>(SoakPlaces::kPrograms) - 1));
}

}  // namespace

const char* SoakPlaces::NameOf(std::size_t place) {
  return place < kPrograms ? kNamesOfPlaces[place] : "attacker";
}

const char* NameOf(SoakFault::Kind kind) {
  switch (kind) {
    case SoakFault::Kind::kKill:
      return "kill";
    case SoakFault::Kind::kStop:
      return "stop";
    case SoakFault::Kind::kCut:
      return "cut";
    case SoakFault::Kind::kClockStep:
      return "clock_step";
    case SoakFault::Kind::kFullDisk:
      return "full_disk";
    case SoakFault::Kind::kFlood:
      return "flood";
    case SoakFault::Kind::kCount:
      break;
  }
  return "";
}

nlohmann::ordered_json AsJson(const SoakFault& fault) {
  nlohmann::ordered_json json{{"kind", NameOf(fault.kind)},
                              {"place", SoakPlaces::NameOf(fault.place)},
                              {"lasts_s", fault.lasts_s}};
  if (fault.kind == SoakFault::Kind::kCut) json["way"] = kWays[static_cast<std::size_t>(fault.way)];
  if (fault.kind == SoakFault::Kind::kClockStep) json["step_s"] = fault.step_s;
  if (fault.kind == SoakFault::Kind::kFullDisk) json["disk_kb"] = fault.disk_kb;
  if (fault.kind == SoakFault::Kind::kFlood) json["flood"] = fault.flood;
  return json;
}

std::vector<SoakFault::Kind> KindsIn(const std::string& words) {
  std::vector<SoakFault::Kind> kinds;
  for (std::size_t i = 0; i < SoakFault::kKinds; ++i) {
    const auto kind = static_cast<SoakFault::Kind>(i);
    if (words.empty() || words.find(NameOf(kind)) != std::string::npos) kinds.push_back(kind);
  }
  return kinds;
}

SoakFault SoakSchedule::Next() {
  if (round_.empty()) {
    for (const SoakFault::Kind kind : kinds_) {
      const int place = rng_.Whole(0, static_cast<int>(round_.size()));
      round_.insert(round_.begin() + place, kind);
    }
  }
  SoakFault fault{.kind = round_.back(), .after_s = rng_.Uniform(0.5, 2)};
  round_.pop_back();
  switch (fault.kind) {
    case SoakFault::Kind::kKill:
      fault.place = OneOf(kMortal, rng_);
      fault.lasts_s = rng_.Uniform(0.1, 2);
      break;
    case SoakFault::Kind::kStop:
      fault.place = AnyPlace(rng_);
      fault.lasts_s = rng_.Uniform(0.2, 5);
      break;
    case SoakFault::Kind::kCut:
      fault.place = AnyPlace(rng_);
      fault.lasts_s = rng_.Uniform(0.2, 5);
      fault.way = static_cast<SoakFault::Way>(rng_.Whole(0, 2));
      break;
    case SoakFault::Kind::kClockStep:
      fault.place = AnyPlace(rng_);
      fault.lasts_s = rng_.Uniform(1, 3);
      fault.step_s = OneOf(kSteps, rng_);
      break;
    case SoakFault::Kind::kFullDisk:
      fault.place = OneOf(kRecording, rng_);
      fault.disk_kb = rng_.Whole(512, 2048);
      break;
    case SoakFault::Kind::kFlood:
    case SoakFault::Kind::kCount:
      fault.place = SoakPlaces::kAttacker;
      fault.lasts_s = rng_.Uniform(1, 4);
      fault.flood = OneOf(kFloods, rng_);
      break;
  }
  return fault;
}

}  // namespace tandem::testing

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "collab/coupling_law.h"
#include "collab/coupling_limits.h"
#include "collab/planted_faults.h"

namespace tandem {

namespace {

constexpr double kLeastDrag = 1.0;  // N s/m, as soon as anything pulls

double LinksOf(const LawInputs& inputs) {
  return static_cast<double>(std::max<std::size_t>(inputs.users, 2) - 1);
}

/// A law with the limits that it was made for.
class LimitedLaw : public CouplingLaw {
 public:
  explicit LimitedLaw(const CouplingLimits& limits) : limits_(limits) {}

 protected:
  const CouplingLimits limits_;
};

/// A share of what passivity wants, k te, between the least drag and the budget; none where nothing
/// pulls.
double DragWithinBudget(double share, const LawInputs& inputs, double stiffness_sum,
                        double budget) {
  if (stiffness_sum <= 0) return 0;
  return std::clamp(share * stiffness_sum * inputs.te_s, std::min(kLeastDrag, budget), budget);
}

class PlusDamping : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  const char* name() const noexcept override { return "p+d"; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    const double B = limits_.damping_budget;
    const double k = std::min(limits_.stiffness, B / inputs.te_s + B * B / (3.0 * inputs.mass_max));
    return {limits_.margin * k / LinksOf(inputs), 0.0};
  }
  double GroundDamping(const LawInputs& inputs, double stiffness_sum) const noexcept override {
    return DragWithinBudget(1.0, inputs, stiffness_sum, limits_.damping_budget);
  }
};

class PlusTwoDampings : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  const char* name() const noexcept override { return "p+dd"; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    const double B = limits_.damping_budget;
    const double k =
        std::min(limits_.stiffness,
                 1.5 * limits_.margin * (B / inputs.te_s + B * B / (3.0 * inputs.mass_max)));
    return {k / LinksOf(inputs), std::min(B, 0.5 * k * inputs.te_s) / LinksOf(inputs)};
  }
  double GroundDamping(const LawInputs& inputs, double stiffness_sum) const noexcept override {
    return DragWithinBudget(0.35, inputs, stiffness_sum, limits_.damping_budget);
  }
};

class Linear : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  const char* name() const noexcept override { return "linear"; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    constexpr double kLongestDelay = 1.0;  // s
    const double tau = 0.5 * inputs.peak_loop_age_s;
    const double share = std::max(0.02, 1.0 - tau / kLongestDelay);
    return {limits_.linear_stiffness * share / LinksOf(inputs), 0.0};
  }
  double GroundDamping(const LawInputs&, double stiffness_sum) const noexcept override {
    return stiffness_sum > 0 ? limits_.damping_budget : 0.0;
  }
};

class PdOpt : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  const char* name() const noexcept override { return "pdopt"; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    const double k = limits_.margin *
                     std::min(limits_.stiffness, 1.5 * limits_.damping_budget / inputs.te_s) /
                     LinksOf(inputs);
    return {k, 0.5 * k * inputs.te_s};
  }
  double GroundDamping(const LawInputs& inputs, double stiffness_sum) const noexcept override {
    if (stiffness_sum <= 0) return 0;
    return std::max(kLeastDrag, 0.2 * stiffness_sum * inputs.te_s);
  }
};

class Constant : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  const char* name() const noexcept override { return "constant"; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    return {limits_.constant_stiffness / LinksOf(inputs),
            limits_.constant_link_damping / LinksOf(inputs)};
  }
  double GroundDamping(const LawInputs&, double stiffness_sum) const noexcept override {
    return stiffness_sum > 0 ? limits_.constant_damping : 0.0;
  }
};

/// Another law, so many times as stiff; for the lab.
class Scaled : public CouplingLaw {
 public:
  Scaled(std::shared_ptr<const CouplingLaw> law, double ratio)
      : law_(std::move(law)), ratio_(ratio) {}
  const char* name() const noexcept override { return law_->name(); }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    LinkLaw link = law_->Link(inputs);
    link.stiffness *= ratio_;
    return link;
  }
  double GroundDamping(const LawInputs& inputs, double stiffness_sum) const noexcept override {
    return law_->GroundDamping(inputs, stiffness_sum / ratio_);
  }

 private:
  std::shared_ptr<const CouplingLaw> law_;
  double ratio_;
};

template <class Law>
std::shared_ptr<const CouplingLaw> Make(const CouplingLimits& limits) {
  return std::make_shared<const Law>(limits);
}

}  // namespace

double DesignDelay(double peak_loop_age_s) noexcept {
  if (Planted(Fault::kHalfTheDelay)) return 0.25 * (1.1 * peak_loop_age_s + 0.005);
  return 0.5 * (1.1 * peak_loop_age_s + 0.005);
}

LawInputs LawInputsAt(double peak_loop_age_s, std::size_t users, double mass_max) noexcept {
  return {.te_s = DesignDelay(peak_loop_age_s),
          .peak_loop_age_s = peak_loop_age_s,
          .users = users,
          .mass_max = mass_max};
}

namespace {

Result<std::shared_ptr<const CouplingLaw>> MakeScaled(std::string_view name, CouplingLimits limits,
                                                      bool lab) {
  const double ratio = std::exchange(limits.ratio, 1.0);
  if (!lab) return Error{"a ratio of the law's stiffness can shake: it is for the lab, with --lab"};
  if (!(ratio > 0)) return Error{"a ratio of the law's stiffness is above 0"};
  Result<std::shared_ptr<const CouplingLaw>> law = MakeLaw(name, limits, lab);
  if (!law) return law;
  return std::shared_ptr<const CouplingLaw>(std::make_shared<Scaled>(*law, ratio));
}

}  // namespace

Result<std::shared_ptr<const CouplingLaw>> MakeLaw(std::string_view name,
                                                   const CouplingLimits& limits, bool lab) {
  if (limits.ratio != 1) return MakeScaled(name, limits, lab);
  if (name == "p+d") return Make<PlusDamping>(limits);
  if (name == "p+dd") return Make<PlusTwoDampings>(limits);
  if (name == "linear") return Make<Linear>(limits);
  if (name == "pdopt") return Make<PdOpt>(limits);
  if (name != "constant") {
    return Error{"no coupling law is called '" + std::string(name) +
                 "': there are p+dd, p+d, linear and pdopt"};
  }
  if (!lab) {
    return Error{
        "the law 'constant' knows of no delay and can shake: it is for the lab, with --lab"};
  }
  return Make<Constant>(limits);
}

std::shared_ptr<const CouplingLaw> DefaultLaw() {
  return Make<PlusTwoDampings>({});
}

std::span<const std::string_view> LimitsUsedBy(std::string_view law) noexcept {
  static constexpr std::array<std::string_view, 4> kPassive{"damping_budget", "stiffness", "margin",
                                                            "ratio"};
  static constexpr std::array<std::string_view, 3> kLinear{"linear_stiffness", "damping_budget",
                                                           "ratio"};
  static constexpr std::array<std::string_view, 4> kConstant{
      "constant_stiffness", "constant_damping", "constant_link_damping", "ratio"};
  if (law == "p+d" || law == "p+dd" || law == "pdopt") return kPassive;
  if (law == "linear") return kLinear;
  if (law == "constant") return kConstant;
  return {};
}

std::string WhyUnused(std::string_view limit, std::string_view law) {
  const std::span<const std::string_view> used = LimitsUsedBy(law);
  if (used.empty() || std::ranges::find(used, limit) != used.end()) return {};
  std::string why = "the law '" + std::string(law) + "' does not use it: it uses ";
  for (std::size_t i = 0; i < used.size(); ++i) {
    why.append(i == 0 ? "" : (i + 1 < used.size() ? ", " : " and ")).append(used[i]);
  }
  return why;
}

}  // namespace tandem

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "collab/coupling/coupling_law.h"
#include "collab/coupling/coupling_limits.h"

namespace tandem {

namespace {

constexpr double kLeastDrag = 1.0;  // N s/m; as soon as a link pulls

double LinksOf(const LawInputs& inputs) {
  return static_cast<double>(std::max<std::size_t>(inputs.users, 2) - 1);
}

/// A law with its limits.
class LimitedLaw : public CouplingLaw {
 public:
  explicit LimitedLaw(const CouplingLimits& limits) : limits_(limits) {}

 protected:
  const CouplingLimits limits_;
};

/// Returns a share of k te, the drag that passivity requires, between the least drag and the
/// budget; 0 where no link pulls.
double DragWithinBudget(double share, const LawInputs& inputs, double stiffness_sum,
                        double budget) {
  if (stiffness_sum <= 0) return 0;
  return std::clamp(share * stiffness_sum * inputs.te_s, std::min(kLeastDrag, budget), budget);
}

class PlusDamping : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  static constexpr const char* kName = "p+d";
  const char* name() const noexcept override { return kName; }
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
  static constexpr const char* kName = "p+dd";
  /// Limit of k te, in budgets: the largest drag is then .238 k te, and .164 k te are passive with
  /// any mass, hand and grasp.
  static constexpr double kMostBudgets = 4.2;
  const char* name() const noexcept override { return kName; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    const double B = limits_.damping_budget;
    const double k =
        std::min({limits_.stiffness, kMostBudgets * B / inputs.te_s,
                  1.5 * limits_.margin * (B / inputs.te_s + B * B / (3.0 * inputs.mass_max))});
    return {k / LinksOf(inputs), 0.5 * k * inputs.te_s / LinksOf(inputs)};
  }
  double GroundDamping(const LawInputs& inputs, double stiffness_sum) const noexcept override {
    return DragWithinBudget(0.35, inputs, stiffness_sum, limits_.damping_budget);
  }
};

class Linear : public LimitedLaw {
 public:
  using LimitedLaw::LimitedLaw;
  static constexpr const char* kName = "linear";
  const char* name() const noexcept override { return kName; }
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
  static constexpr const char* kName = "pdopt";
  const char* name() const noexcept override { return kName; }
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
  static constexpr const char* kName = "constant";
  const char* name() const noexcept override { return kName; }
  LinkLaw Link(const LawInputs& inputs) const noexcept override {
    return {limits_.constant_stiffness / LinksOf(inputs),
            limits_.constant_link_damping / LinksOf(inputs)};
  }
  double GroundDamping(const LawInputs&, double stiffness_sum) const noexcept override {
    return stiffness_sum > 0 ? limits_.constant_damping : 0.0;
  }
};

/// Another law with its stiffness times `ratio`; for the lab.
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

constexpr std::array<std::string_view, 4> kPassiveLimits{"damping_budget", "stiffness", "margin",
                                                         "ratio"};
constexpr std::array<std::string_view, 3> kLinearLimits{"linear_stiffness", "damping_budget",
                                                        "ratio"};
constexpr std::array<std::string_view, 4> kConstantLimits{"constant_stiffness", "constant_damping",
                                                          "constant_link_damping", "ratio"};

/// A law under its name: its factory, and the names of the limits that it uses.
struct LawRow {
  std::string_view name;
  std::shared_ptr<const CouplingLaw> (*make)(const CouplingLimits&);
  std::span<const std::string_view> limits;
  bool for_lab = false;
};

constexpr std::array kLaws{LawRow{PlusTwoDampings::kName, Make<PlusTwoDampings>, kPassiveLimits},
                           LawRow{PlusDamping::kName, Make<PlusDamping>, kPassiveLimits},
                           LawRow{Linear::kName, Make<Linear>, kLinearLimits},
                           LawRow{PdOpt::kName, Make<PdOpt>, kPassiveLimits},
                           LawRow{Constant::kName, Make<Constant>, kConstantLimits, true}};

const LawRow* RowOf(std::string_view name) {
  const auto* const row = std::ranges::find(kLaws, name, &LawRow::name);
  return row == kLaws.end() ? nullptr : row;
}

std::vector<std::string_view> NamesOf(bool lab) {
  std::vector<std::string_view> names;
  for (const LawRow& row : kLaws) {
    if (lab || !row.for_lab) names.push_back(row.name);
  }
  return names;
}

/// Returns "a, b and c".
std::string Listed(std::span<const std::string_view> names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text.append(i == 0 ? "" : (i + 1 < names.size() ? ", " : " and ")).append(names[i]);
  }
  return text;
}

}  // namespace

double DesignDelay(double peak_loop_age_s) noexcept {
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
  const LawRow* const row = RowOf(name);
  if (row == nullptr) {
    return Error{"no coupling law is called '" + std::string(name) + "': there are " +
                 Listed(NamesOf(lab))};
  }
  if (row->for_lab && !lab) {
    return Error{"the law '" + std::string(name) +
                 "' knows of no delay and can shake: it is for the lab, with --lab"};
  }
  return row->make(limits);
}

std::vector<std::string> LawNames(bool lab) {
  const std::vector<std::string_view> names = NamesOf(lab);
  return {names.begin(), names.end()};
}

std::shared_ptr<const CouplingLaw> DefaultLaw() {
  return Make<PlusTwoDampings>({});
}

std::span<const std::string_view> LimitsUsedBy(std::string_view law) noexcept {
  const LawRow* const row = RowOf(law);
  return row == nullptr ? std::span<const std::string_view>{} : row->limits;
}

std::string WhyUnused(std::string_view limit, std::string_view law) {
  const std::span<const std::string_view> used = LimitsUsedBy(law);
  if (used.empty() || std::ranges::find(used, limit) != used.end()) return {};
  return "the law '" + std::string(law) + "' does not use it: it uses " + Listed(used);
}

}  // namespace tandem

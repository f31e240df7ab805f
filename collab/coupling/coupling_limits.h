#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "collab/coupling/coupling_law.h"

namespace tandem {

/// A limit of the laws under its name, as command lines and recordings give it.
struct LimitName {
  std::string_view name;
  double CouplingLimits::*value;
};

inline constexpr std::array kLimitNames{
    LimitName{"damping_budget", &CouplingLimits::damping_budget},
    LimitName{"stiffness", &CouplingLimits::stiffness},
    LimitName{"margin", &CouplingLimits::margin},
    LimitName{"linear_stiffness", &CouplingLimits::linear_stiffness},
    LimitName{"constant_stiffness", &CouplingLimits::constant_stiffness},
    LimitName{"constant_damping", &CouplingLimits::constant_damping},
    LimitName{"constant_link_damping", &CouplingLimits::constant_link_damping},
    LimitName{"ratio", &CouplingLimits::ratio}};
static_assert(sizeof(CouplingLimits) == kLimitNames.size() * sizeof(double));  // none is left out

/// Returns the names of the limits that the law uses, `ratio` among them; none if no law has that
/// name.
std::span<const std::string_view> LimitsUsedBy(std::string_view law) noexcept;

/// Returns why the law cannot be given that limit, and lists the limits that it uses; empty if it
/// uses the limit.
std::string WhyUnused(std::string_view limit, std::string_view law);

}  // namespace tandem

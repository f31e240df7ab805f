#pragma once

#include <array>
#include <string_view>

#include "collab/coupling_law.h"

namespace tandem {

/// A limit of the laws by its name, as command lines and recordings give it.
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

}  // namespace tandem

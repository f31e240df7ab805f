#pragma once

#include <array>
#include <cstdint>

namespace tandem {

using ProgramId = std::array<std::uint8_t, 12>;  // prefix of a participant's GUID

}  // namespace tandem

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collab/lab/lab_case.h"
#include "collab/lab/lab_scene.h"

namespace tandem {

/// These functions write what a `tandem peer` reads to be a user of a case of the lab. Users are
/// counted from 0.

/// Its name in the session: user-0, user-1, ...
std::string NameOfUser(std::size_t user);

/// The user's hand, as a hand file. Error: it cannot be written.
std::optional<Error> WriteCaseHand(const LabCase& test, std::size_t user,
                                   const std::filesystem::path& file);
/// Writes what a user hears of each of the others, as a network plan that begins with the hand.
std::optional<Error> WriteCasePlan(const LabCase& test, std::size_t user,
                                   const std::filesystem::path& file);
/// The options for the case's law, its gains and the rate of states. `test`: fitted to the scene's
/// body.
std::vector<std::string> LawWords(const LabCase& test);

}  // namespace tandem

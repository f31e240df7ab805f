#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collab/lab/case/lab_case.h"
#include "collab/lab/case/lab_scene.h"

namespace tandem {

/// These functions make the name, files and options of a `tandem peer` that acts as a user of a lab
/// case. Users are counted from 0.

/// Returns the user's name in the session: user-0, user-1, ...
std::string NameOfUser(std::size_t user);

/// Writes the user's hand as a hand file. Error: it cannot be written.
std::optional<Error> WriteCaseHand(const LabCase& test, std::size_t user,
                                   const std::filesystem::path& file);
/// Writes what a user hears of each of the others, as a network plan that begins with the hand.
std::optional<Error> WriteCasePlan(const LabCase& test, std::size_t user,
                                   const std::filesystem::path& file);
/// Returns the options for the case's law, its gains and the rate of states. `test`: a case fitted
/// to the scene's body.
/// body.
std::vector<std::string> LawArguments(const LabCase& test);

}  // namespace tandem

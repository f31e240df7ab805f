#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tandem {

/// Checks of options. Each refuses a value in one line that says what is wanted and what came:
/// "--seconds: a number from 0 to 600 is wanted, not 'nan'". A number must be written in decimal.
CLI::Validator NumberFrom(double least, double most);
/// Accepts numbers above `least`, up to `most`.
CLI::Validator NumberAbove(double least, double most);
CLI::Validator WholeNumberFrom(std::int64_t least, std::int64_t most);
/// Accepts a number of bytes, or a number with a unit (8GiB, 500MB; units of 1024), and replaces it
/// by the number of bytes. The range is 1 byte to 1024 TiB.
CLI::Validator SizeInBytes();
CLI::Validator OneOf(std::vector<std::string> words);
/// Accepts names of files with one of these endings, such as ".csv", in small or capital letters,
/// and names without an ending.
CLI::Validator FileEndingIn(std::vector<std::string> endings);
/// Returns the ending of a file's name in small letters: ".csv".
std::string EndingOf(const std::string& file);

/// Refuses "" for each option that takes a text, in this command and all subcommands. An unset
/// variable of a script leaves "", which is neither a file nor a name.
void RefuseEmptyTexts(CLI::App& app);

/// Explains in one line why a command line is invalid, and names the --help to read. The line has a
/// bounded length and no control characters, whatever was typed.
std::string Explain(const CLI::App& app, const CLI::ParseError& error);

/// Parses the command line, which also runs its command. Returns nothing on success. Otherwise it
/// has printed help on stdout or one line on stderr, and returns the exit code to end with.
std::optional<int> ParseOrExplain(CLI::App& app, int argc, const char* const* argv);

constexpr double kLongestRun = 604'800;  // s, a week
constexpr double kLeastVoxel = 1e-6;     // m
constexpr double kLargestVoxel = 10;
constexpr double kLeastScale = 1e-9;
constexpr double kLargestScale = 1e9;
constexpr int kMostThreads = 256;
constexpr std::int64_t kLargestSeed = 1'000'000'000'000'000;

}  // namespace tandem

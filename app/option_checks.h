#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tandem {

/// Checks of options: each says in one line what is wanted and what came, as "--seconds: a number
/// from 0 to 600 is wanted, not 'nan'". No other number gets through, and none that is not written
/// as a decimal one.
CLI::Validator NumberFrom(double least, double most);
/// `least` itself is refused.
CLI::Validator NumberAbove(double least, double most);
CLI::Validator WholeNumberFrom(std::int64_t least, std::int64_t most);
/// A number of bytes, or with a unit (8GiB, 500MB; units of 1024); gives it as bytes. At least one
/// and at most 1024 TiB.
CLI::Validator SizeInBytes();
CLI::Validator OneOf(std::vector<std::string> words);

/// Refuses "" wherever a text is asked for, here and in all subcommands: what a script's unset
/// variable leaves is no file and no name.
void RefuseEmptyTexts(CLI::App& app);

/// What is wrong with a command line, in one line, with where to read on: without control
/// characters and of bounded length whatever was typed.
std::string Explain(const CLI::App& app, const CLI::ParseError& error);

/// Parses, and so runs what was asked for. Nothing: all is well; else the exit code to end with,
/// after help on stdout or one line on stderr.
std::optional<int> ParseOrExplain(CLI::App& app, int argc, const char* const* argv);

constexpr double kLongestRun = 604'800;  // s: a week
constexpr double kLeastVoxel = 1e-6;     // m
constexpr double kLargestVoxel = 10;
constexpr double kLeastScale = 1e-9;
constexpr double kLargestScale = 1e9;
constexpr int kMostThreads = 256;
constexpr std::int64_t kLargestSeed = 1'000'000'000'000'000;

}  // namespace tandem

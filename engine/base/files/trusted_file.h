#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

/// Returns in words why a file that this program would run may be another user's; empty: it is as
/// trustworthy as its user. The file and its folder, behind all links, belong to the user or to
/// root, and nobody else may write to them. A group may, if it is the user's own first group.
inline std::string WhyNotTrusted(const std::filesystem::path& file) {
  std::error_code failed;
  const std::filesystem::path target = std::filesystem::canonical(file, failed);
  if (failed) return file.string() + ": " + failed.message();
  for (const std::filesystem::path& one : {target, target.parent_path()}) {
    struct stat facts {};
    if (stat(one.c_str(), &facts) != 0) return one.string() + ": cannot be looked at";
    if (facts.st_uid != geteuid() && facts.st_uid != 0) {
      return one.string() +
             ": belongs to another user, whose code would run as you: make a copy of your own";
    }
    const bool group_writes = (facts.st_mode & S_IWGRP) != 0 && facts.st_gid != getegid();
    if (group_writes || (facts.st_mode & S_IWOTH) != 0) {
      return one.string() +
             ": other users can write to it, and their code would run as you: chmod go-w '" +
             one.string() + "'";
    }
  }
  return {};
}

}  // namespace tandem

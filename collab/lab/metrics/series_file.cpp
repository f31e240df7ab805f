#include "collab/lab/metrics/series_file.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace tandem {

namespace {

double FarthestApart(std::span<const UserFrame> users) {
  double apart = 0;
  for (const UserFrame& one : users) {
    for (const UserFrame& other : users) {
      if (!one.present || !other.present) continue;
      apart = std::max(apart, (one.state.X_WB.p - other.state.X_WB.p).norm());
    }
  }
  return apart;
}

}  // namespace

Result<SeriesFile> SeriesFile::Create(const std::filesystem::path& file, std::size_t users,
                                      int every_frames) {
  SeriesFile series;
  series.file_ = file;
  series.every_frames_ = every_frames;
  series.out_.open(file, std::ios::binary);
  if (!series.out_) return Error{file.string() + ": cannot be written"};
  series.out_ << "t_s,apart_mm";
  for (std::size_t user = 1; user <= users; ++user) {
    for (const char* column : {"x@_mm", "y@_mm", "z@_mm", "v@_mm_s", "w@_rad_s", "force@_N",
                               "link@_N", "stiffness@_N_m", "loop@_ms", "drag@_Ns_m", "trapped@"}) {
      std::string name = column;
      name.replace(name.find('@'), 1, std::to_string(user));
      series.out_ << ',' << name;
    }
  }
  series.out_ << '\n';
  return series;
}

void SeriesFile::Add(double t_s, std::span<const UserFrame> users) {
  if (frame_++ % every_frames_ != 0) return;
  std::array<char, 400> text{};
  const auto put = [&](const char* format, auto... values) {
    std::snprintf(text.data(), text.size(), format, values...);
    out_ << text.data();
  };
  put("%.3f,%.6g", t_s, 1e3 * FarthestApart(users));
  for (const UserFrame& user : users) {
    if (!user.present) {
      out_ << ",,,,,,,,,,,";
      continue;
    }
    Vec3 links = Vec3::Zero();
    double stiffness = 0;
    double loop_age_s = 0;
    for (std::size_t i = 0; i < user.link_count; ++i) {
      links += user.links_B_W[i].f;
      stiffness += user.links[i].stiffness / static_cast<double>(user.link_count);
      loop_age_s = std::max(loop_age_s, user.links[i].loop_age_s);
    }
    const Vec3 p_mm = 1e3 * user.state.X_WB.p;
    put(",%.6g,%.6g,%.6g,%.6g,%.6g", p_mm.x(), p_mm.y(), p_mm.z(), 1e3 * user.state.V_WB.v.norm(),
        user.state.V_WB.w.norm());
    put(",%.6g,%.6g,%.6g,%.6g,%.6g,%d", user.felt_W.f.norm(), links.norm(), stiffness,
        1e3 * loop_age_s, user.ground_damping, user.trapped ? 1 : 0);
  }
  out_ << '\n';
}

std::optional<Error> SeriesFile::Close() {
  out_.close();
  if (!out_) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file_, ignored)) std::filesystem::remove(file_, ignored);
    return Error{file_.string() + ": could not be written to its end, and is removed"};
  }
  return std::nullopt;
}

}  // namespace tandem

#include "collab/recording/poses_export.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "engine/base/text/csv_text.h"
#include "engine/base/units.h"

namespace tandem {

Result<std::unique_ptr<PosesExport>> PosesExport::Create(const std::filesystem::path& file,
                                                         const WorldModel& model) {
  for (const BodyModel& body : model.bodies) {
    if (body.name.find_first_of(",\"\r\n") != std::string::npos) {
      return Error{"body '" + body.name +
                   "': a name with a comma, a quotation mark or a line break has no place in " +
                   file.string()};
    }
  }
  Result<WholeFile> made = WholeFile::Create(file);
  if (!made) return made.error();
  made->Write("t_s,moving,tx,ty,tz,ax,ay,az,angle_deg\n");
  return std::unique_ptr<PosesExport>(new PosesExport(*std::move(made), model));
}

PosesExport::PosesExport(WholeFile file, const WorldModel& model)
    : file_(std::move(file)), model_(&model) {}

void PosesExport::Add(const RecordedFrame& frame, const PeerNode& node) {
  if (frames_ == 0) first_ns_ = frame.now_ns;
  if (frames_++ % kEveryFrames != 0) return;
  const double t_s = ToSeconds(frame.now_ns - first_ns_);
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    const BodyModel& body = model_->bodies[b];
    const Pose X_WM = node.world().state(b).X_WB * body.X_MB.Inverse();
    const Vec3 turn = RotationVector(X_WM.q);
    const double angle = turn.norm();
    const Vec3 axis = angle > 0 ? Vec3(turn / angle) : Vec3(Vec3::UnitZ());
    std::array<char, 256> row{};
    std::snprintf(row.data(), row.size(), ",%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n",
                  X_WM.p.x(), X_WM.p.y(), X_WM.p.z(), axis.x(), axis.y(), axis.z(),
                  angle * 180 / M_PI);
    std::array<char, 32> time{};
    std::snprintf(time.data(), time.size(), "%.3f,", t_s);
    file_.Write(time.data() + CsvText(body.name) + row.data());
    ++rows_;
  }
}

Result<std::uint64_t> PosesExport::Close() {
  if (const std::optional<Error> failed = file_.Commit()) return *failed;
  return rows_;
}

}  // namespace tandem

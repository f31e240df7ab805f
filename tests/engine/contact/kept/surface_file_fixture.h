#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/contact/kept/surface_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace tandem::testing {

/// Makes surfaces, saves them, and reads files of them.
class SurfaceFile : public ::testing::Test {
 public:
  static constexpr double kVoxel = 0.001;

 protected:
  using Bytes = std::vector<std::byte>;
  static inline const SurfaceOptions kOptions{.voxel_size = kVoxel};

  BodySurface Made(const TriangleMesh& mesh_W, const Pose& X_WB = {}) const {
    Result<BodySurface> made = BuildSurface(mesh_W, X_WB, kOptions);
    EXPECT_TRUE(made);
    return std::move(*made);
  }
  std::filesystem::path Saved(const TriangleMesh& mesh_W) const {
    EXPECT_FALSE(SaveSurface(Made(mesh_W), mesh_W, kOptions, file_));
    return file_;
  }
  Bytes SavedBytes(const TriangleMesh& mesh_W) const {
    std::ifstream in(Saved(mesh_W), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
  }
  Result<BodySurface> Mapped(const Bytes& bytes) const {
    std::ofstream(file_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return MapSurface(file_, box_, Pose{}, kOptions);
  }
  /// Returns the refusal's line without the file's name; empty if the file is taken.
  std::string FaultOf(const Bytes& bytes) const {
    const Result<BodySurface> surface = Mapped(bytes);
    if (surface) return {};
    const std::string& line = surface.error().what;
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(line.find(file_.string() + ": "), 0U) << line;
    return line.substr(file_.string().size() + 2);
  }

  /// Returns the bytes with the checksum of what they are now.
  static Bytes Signed(Bytes bytes) {
    BlockFileHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    header.checksum = BlockFileChecksum(bytes);
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
  }

  template <typename T>
  static void Set(Bytes& bytes, std::size_t at, T value) {
    std::memcpy(&bytes[at], &value, sizeof value);
  }

  template <typename T>
  static T Get(const Bytes& bytes, std::size_t at) {
    T value;
    std::memcpy(&value, &bytes[at], sizeof value);
    return value;
  }

  /// Calls all that reads a surface, at places in and round it, and returns what they told, bit by
  /// bit.
  static std::vector<double> Readings(const BodySurface& surface, const TriangleMesh& mesh_W,
                                      int places = 4000) {
    std::mt19937_64 random(5);
    const DistanceField& field = surface.field;
    const Bounds box = BoundsOf(mesh_W);
    std::vector<double> reported;
    FieldPushes pushes;
    FieldGradient gradient;
    FieldReadings readings;
    std::array<std::array<float, kBlockPlaces>, 3> lanes;
    std::array<float, kBlockPlaces> values;
    std::array<float, kBlockPlaces> over;
    std::array<std::int32_t, kBlockPlaces> kinds;
    for (int i = 0; i < places; ++i) {
      Vec3 place_V;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        place_V[axis] = (Uniform(random, box.min[axis] - 4 * kVoxel, box.max[axis] + 4 * kVoxel) -
                         field.p_WVo()[axis]) /
                        kVoxel;
        lanes[static_cast<std::size_t>(axis)].fill(static_cast<float>(place_V[axis]));
      }
      field.WithGradients({&place_V, 1}, &gradient);
      reported.insert(reported.end(),
                      {gradient.reading.value, gradient.gradient.x(), gradient.gradient.y(),
                       gradient.gradient.z(), field.At(place_V).value});
      field.Values({}, {lanes[0].data(), lanes[1].data(), lanes[2].data()}, kBlockPlaces,
                   values.data(), kinds.data(), over.data());
      reported.insert(reported.end(), {values[0], static_cast<double>(kinds[0]), over[0]});
      const PlacedBlock block{.places_F = {lanes[0].data(), lanes[1].data(), lanes[2].data()}};
      field.ReadBlocks({1, 0, 0, 0, 1, 0, 0, 0, 1}, 0.6F, {&block, 1}, values.data(), &readings);
      reported.insert(reported.end(),
                      {values[0], readings.least, static_cast<double>(readings.within)});
      field.Pushes({&place_V, 1}, 0.6, pushes);
      for (const FieldPush& push : pushes.PushesAt(0)) {
        reported.insert(reported.end(), {push.distance, push.away_V.x(), push.share});
      }
      reported.push_back(surface.features.EdgesBeyond(place_V));
      surface.features.VisitEdgesIn(place_V - Vec3::Constant(1), place_V + Vec3::Constant(1),
                                    [&reported](const BodyFeatures::Edge& edge) {
                                      reported.push_back(edge.middle.x());
                                    });
    }
    for (std::size_t b = 0; b < surface.features.blocks().size(); ++b) {
      for (std::size_t lane = 0; lane < BodyFeatures::kLanes; ++lane) {
        reported.push_back(surface.features.place(b, lane).y());
        reported.push_back(surface.features.point(b, lane).inward.z());
      }
    }
    return reported;
  }

  ScratchFolder folder_;
  std::filesystem::path file_ = folder_.path() / "body.surface";
  TriangleMesh box_ = Box(kVoxel * Vec3(6, 4, 3));
};

}  // namespace tandem::testing

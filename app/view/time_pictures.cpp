#include "app/view/time_pictures.h"

#include <QElapsedTimer>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QOpenGLFramebufferObject>
#include <QOpenGLFunctions>
#include <algorithm>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/view/model/scene/drawn_scene.h"
#include "app/view/program_lines.h"
#include "app/view/render/gl_check.h"
#include "app/view/render/renderer.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

constexpr QSize kPixels(1024, 768);
constexpr std::size_t kPartTriangles = 300'000;
constexpr int kFixedEyeFrames = 20;   // frames of a round
constexpr int kMovingEyeFrames = 10;  // frames of a round
constexpr double kStepOfBody = 1e-3;  // m a frame

std::size_t StaticTriangles(const DrawnScene& scene) {
  std::size_t count = 0;
  for (const DrawnBody& body : scene.bodies) {
    if (body.look.fixed) count += body.mesh.triangles.size() / 3;
  }
  return count;
}

/// Counts the triangles of moving bodies as they are drawn in one colour.
std::size_t MovingTriangles(const DrawnScene& scene) {
  std::size_t count = 0;
  for (const DrawnBody& body : scene.bodies) {
    const ShadedMesh& mesh = body.mesh;
    const bool cut = !mesh.uncut_triangles.empty();
    if (!body.look.fixed) count += (cut ? mesh.uncut_triangles : mesh.triangles).size() / 3;
  }
  return count;
}

/// Keeps `share` of the primitives, spread evenly. A primitive has `corners` indices.
std::vector<std::uint32_t> Thinned(const std::vector<std::uint32_t>& indices, std::size_t corners,
                                   double share) {
  std::vector<std::uint32_t> kept;
  double due = 0;
  for (std::size_t first = 0; first < indices.size(); first += corners) {
    due += share;
    if (due < 1) continue;
    due -= 1;
    const auto begin = indices.begin() + static_cast<std::ptrdiff_t>(first);
    kept.insert(kept.end(), begin, begin + static_cast<std::ptrdiff_t>(corners));
  }
  return kept;
}

DrawnScene PartOf(const DrawnScene& scene) {
  const double share =
      static_cast<double>(kPartTriangles) / static_cast<double>(StaticTriangles(scene));
  DrawnScene part = scene;
  for (DrawnBody& body : part.bodies) {
    if (!body.look.fixed) continue;
    body.mesh.triangles = Thinned(body.mesh.triangles, 3, share);
    body.mesh.edges = Thinned(body.mesh.edges, 2, share);
  }
  return part;
}

ordered_json Spread(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {
      {"median", values[values.size() / 2]}, {"least", values.front()}, {"most", values.back()}};
}

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// A scene at a number of samples a pixel, with its measured times.
class Subject {
 public:
  Subject(const DrawnScene& scene, int samples) : scene_(scene), samples_(samples) {
    QOpenGLFramebufferObjectFormat format;
    format.setSamples(samples);
    format.setAttachment(QOpenGLFramebufferObject::CombinedDepthStencil);
    target_ = std::make_unique<QOpenGLFramebufferObject>(kPixels, format);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      list_.solids.push_back({i, {}, scene.bodies[i].look.colour, 1});
    }
    camera_.SetViewport(kPixels.width(), kPixels.height());
    camera_.LookFrom(StandardView::kIso);
    camera_.Fit(scene.BoundsOfAll());
  }

  std::optional<Error> Prepare() {
    if (auto error = renderer_.Initialize()) return error;
    renderer_.Upload(scene_.bodies);
    FrameMs();  // allocates the picture's buffers
    return std::nullopt;
  }

  void RunRound() {
    camera_.Orbit(1, 0);
    full_redraw_ms_.push_back(FrameMs());
    std::vector<double> fixed;
    for (int frame = 0; frame < kFixedEyeFrames; ++frame) {
      MoveBodies();
      fixed.push_back(FrameMs());
    }
    fixed_eye_ms_.push_back(MedianOf(fixed));
    ratios_.push_back(full_redraw_ms_.back() / fixed_eye_ms_.back());
    std::vector<double> moving;
    for (int frame = 0; frame < kMovingEyeFrames; ++frame) {
      camera_.Orbit(1, 0);
      MoveBodies();
      moving.push_back(FrameMs(kStaticPictureMs));
    }
    moving_eye_ms_.push_back(MedianOf(moving));
    double frames = 0;
    for (whole_ = false; !whole_; ++frames) FrameMs(kStaticPictureMs);
    frames_at_rest_.push_back(frames);
  }

  double fixed_eye_ms() const { return MedianOf(fixed_eye_ms_); }
  ordered_json AsJson() const {
    return {{"static_triangles", StaticTriangles(scene_)},
            {"moving_triangles", MovingTriangles(scene_)},
            {"samples", std::max(samples_, 1)},
            {"full_redraw_ms", Spread(full_redraw_ms_)},
            {"fixed_eye_ms", Spread(fixed_eye_ms_)},
            {"ratio", Spread(ratios_)},
            {"moving_eye_ms", Spread(moving_eye_ms_)},
            {"frames_until_whole", Spread(frames_at_rest_)}};
  }

 private:
  /// Draws a frame and waits for its end. `static_ms`: time for the static picture; none: all of
  /// it.
  double FrameMs(std::optional<int> static_ms = std::nullopt) {
    QElapsedTimer clock;
    clock.start();
    Renderer::MayGoOn may_go_on;
    if (static_ms) {
      may_go_on = [&] {
        return clock.elapsed() < *static_ms;
      };
    }
    target_->bind();
    whole_ = renderer_.Draw(camera_, list_, kPixels, may_go_on);
    QOpenGLContext::currentContext()->functions()->glFinish();
    return 1e-6 * static_cast<double>(clock.nsecsElapsed());
  }
  void MoveBodies() {
    const double way = (++moves_ % 2) != 0 ? 1 : -1;
    for (BodyInstance& solid : list_.solids) {
      if (!scene_.bodies[solid.body].look.fixed) solid.X_W.p.x() += way * kStepOfBody;
    }
  }

  const DrawnScene& scene_;
  int samples_;
  std::unique_ptr<QOpenGLFramebufferObject> target_;
  Renderer renderer_;
  CameraModel camera_;
  DrawList list_;
  int moves_ = 0;
  bool whole_ = false;
  std::vector<double> full_redraw_ms_, fixed_eye_ms_, ratios_, moving_eye_ms_, frames_at_rest_;
};

/// Times a scene, whole and in part. Needs a current context.
Result<ordered_json> Time(const DrawnScene& scene, int rounds) {
  std::vector<DrawnScene> scenes{scene};
  if (StaticTriangles(scene) > kPartTriangles) scenes.push_back(PartOf(scene));
  std::vector<std::unique_ptr<Subject>> subjects;
  for (const int samples : {0, 4}) {
    for (const DrawnScene& one : scenes) {
      subjects.push_back(std::make_unique<Subject>(one, samples));
      if (auto error = subjects.back()->Prepare()) return *error;
    }
  }
  for (int round = 0; round < rounds; ++round) {
    // rounds in turn, since the machine's load changes: all subjects meet it alike
    for (const auto& subject : subjects) subject->RunRound();
  }
  ordered_json pictures = ordered_json::array();
  for (const auto& subject : subjects) pictures.push_back(subject->AsJson());
  ordered_json json{{"scene", scene.name},
                    {"pixels", {kPixels.width(), kPixels.height()}},
                    {"rounds", rounds},
                    {"pictures", pictures}};
  if (scenes.size() > 1) {
    json["fixed_eye_whole_to_part"] = subjects[0]->fixed_eye_ms() / subjects[1]->fixed_eye_ms();
  }
  return json;
}

}  // namespace

int TimePictures(const std::filesystem::path& scene, int rounds,
                 const std::filesystem::path& file) {
  const Result<GlInfo> gl = CheckGl();
  if (!gl) return FailFromView(kExitDisplay, gl.error().what);
  const Result<DrawnScene> drawn =
      LoadDrawnScene(scene, [](std::size_t, std::size_t, const std::string&) {
        return true;
      });
  if (!drawn) return FailFromView(kExitFile, drawn.error().what);
  QOpenGLContext context;
  context.setFormat(RendererFormat());
  QOffscreenSurface surface;
  surface.setFormat(RendererFormat());
  surface.create();
  if (!context.create() || !context.makeCurrent(&surface)) {
    return FailFromView(kExitDisplay, "no OpenGL context could be made");
  }
  Result<ordered_json> times = Time(*drawn, rounds);
  if (!times) return FailFromView(kExitDisplay, times.error().what);
  (*times)["renderer"] = gl->renderer;
  if (const auto fault = WriteWholeFile(file, JsonText(*times, 2) + "\n")) {
    return FailFromView(kExitFile, fault->what);
  }
  return kExitOk;
}

}  // namespace tandem

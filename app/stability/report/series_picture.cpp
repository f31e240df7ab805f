#include <algorithm>
#include <array>
#include <cmath>

#include "app/picture/chart.h"
#include "app/stability/report/series.h"

namespace tandem {

namespace {

constexpr double kSeriesWidth = 940;
constexpr double kLeft = 84;
constexpr double kPlotWidth = 640;
constexpr double kTop = 66;
constexpr double kGap = 14;
constexpr double kBelow = 54;
constexpr std::size_t kBins = 320;

// one for each user, distinguishable without telling red from green: after Okabe and Ito, light
// colours last
constexpr std::array<Rgb, 8> kUsers{{{0, 114, 178},
                                     {213, 94, 0},
                                     {0, 158, 115},
                                     {204, 121, 167},
                                     {230, 159, 0},
                                     {86, 180, 233},
                                     {0, 0, 0},
                                     {130, 130, 130}}};

struct Curve {
  std::vector<PicturePoint> points;
  Stroke stroke;
  std::string name;
};

struct Panel {
  std::string label;
  double height = 100;
  std::vector<Curve> curves;
};

std::string ColumnOf(const char* before, std::size_t user, const char* after) {
  return before + std::to_string(user + 1) + after;
}

class Panels {
 public:
  explicit Panels(const Series& series) : series_(series) {
    while (users_ < kUsers.size() && series.Column(ColumnOf("v", users_, "_mm_s")) != nullptr) {
      ++users_;
    }
  }

  std::size_t users() const { return users_; }
  void Begin(const char* label, double height) { panels_.push_back({label, height, {}}); }
  void Add(const std::string& column, const Stroke& stroke, const std::string& name) {
    const std::vector<double>* const t = series_.Column("t_s");
    const std::vector<double>* const y = series_.Column(column);
    if (t == nullptr || y == nullptr) return;
    panels_.back().curves.push_back({Thinned(*t, *y, kBins), stroke, name});
  }
  void AddUsers(const char* before, const char* after, const std::vector<double>& dashes,
                const std::string& name) {
    for (std::size_t user = 0; user < users_; ++user) {
      Add(ColumnOf(before, user, after), {kUsers[user], 1.4, dashes},
          "user " + std::to_string(user + 1) + name);
    }
  }
  const std::vector<Panel>& all() const { return panels_; }

 private:
  const Series& series_;
  std::size_t users_ = 0;
  std::vector<Panel> panels_;
};

double GreatestOf(const Panel& panel) {
  double greatest = 0;
  for (const Curve& curve : panel.curves) {
    for (const PicturePoint& point : curve.points) {
      if (std::isfinite(point.y)) greatest = std::max(greatest, point.y);
    }
  }
  return greatest > 0 ? 1.08 * greatest : 1.0;
}

// returns a size at which a long title ends within the picture
double TitleSize(const std::string& title) {
  constexpr double kBoldWidth = 0.6;  // mean width of a letter, share of its height
  return std::min(14.0,
                  (kSeriesWidth - kLeft) / (kBoldWidth * static_cast<double>(title.size() + 1)));
}

double LongestOf(const Series& series) {
  const std::vector<double>* const t = series.Column("t_s");
  return t == nullptr || t->empty() || !(t->back() > 0) ? 1.0 : t->back();
}

}  // namespace

Picture PictureOf(const Series& series, const std::string& name, const std::string& title,
                  const std::string& note) {
  Panels panels(series);
  panels.Begin("apart, mm", 120);
  panels.Add("apart_mm", {kBlack, 1.4, {}}, "farthest two");
  panels.Begin("speed, mm/s", 120);
  panels.AddUsers("v", "_mm_s", {}, "");
  panels.Begin("force, N", 120);
  panels.AddUsers("link", "_N", {4, 3}, ", links");
  panels.AddUsers("force", "_N", {}, ", hand");
  panels.Begin("stiffness, N/m", 84);
  panels.AddUsers("stiffness", "_N_m", {}, ", a link");
  panels.Begin("loop age, ms", 84);
  panels.AddUsers("loop", "_ms", {}, ", oldest");

  Picture picture{name, title + ". " + note, kSeriesWidth, 0, {}};
  picture.shapes.emplace_back(
      LabelShape{{kLeft, 26}, title, TitleSize(title), TextAnchor::kStart, kBlack, true, false});
  picture.shapes.emplace_back(
      LabelShape{{kLeft, 47}, note, 12, TextAnchor::kStart, {80, 80, 80}, false, false});
  const double longest = LongestOf(series);
  double top = kTop;
  for (const Panel& panel : panels.all()) {
    const bool last = &panel == &panels.all().back();
    Chart chart(picture, {kLeft, top, kPlotWidth, panel.height},
                {"time from when all loops are closed, s", 0, longest, false},
                {panel.label, 0, GreatestOf(panel), false});
    chart.DrawGrid();
    for (const Curve& curve : panel.curves) chart.DrawCurve(curve.points, curve.stroke);
    chart.DrawAxes(last);
    // as many names as fit
    PicturePoint at{kLeft + kPlotWidth + 16, top + 13};
    for (const Curve& curve : panel.curves) {
      if (at.y > top + panel.height) break;
      DrawLegendLine(picture, at, curve.stroke, curve.name);
      at.y += 18;
    }
    top += panel.height + kGap;
  }
  picture.height = top - kGap + kBelow;
  return picture;
}

}  // namespace tandem

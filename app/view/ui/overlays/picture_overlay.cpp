#include "app/view/ui/overlays/picture_overlay.h"

#include <algorithm>
#include <array>
#include <vector>

#include "app/view/model/scene/label_layout.h"

namespace tandem {

namespace {

constexpr double kAxisLength = 34;  // px

struct PlacedLabel {
  const InstanceLabel* label = nullptr;
  QPointF anchor;  // pixel at the body
  LabelPlace place;
};

QColor ToQColor(const Colour& colour, float alpha = 1.0F) {
  return QColor::fromRgbF(colour[0], colour[1], colour[2], alpha);
}

/// Returns the topmost y of the body's box on the screen, at the x of its centre. Names hang above
/// it.
std::optional<QPointF> TopOf(const CameraModel& camera, const Bounds& bounds_W, const Pose& X_W) {
  const auto middle = camera.Project(X_W * bounds_W.centre());
  if (!middle) return std::nullopt;
  QPointF top(middle->x(), middle->y());
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) != 0 ? bounds_W.max.x() : bounds_W.min.x(),
                 (corner & 2) != 0 ? bounds_W.max.y() : bounds_W.min.y(),
                 (corner & 4) != 0 ? bounds_W.max.z() : bounds_W.min.z());
    if (const auto px = camera.Project(X_W * p)) top.setY(std::min(top.y(), px->y()));
  }
  return top;
}

std::vector<PlacedLabel> Placed(const QFontMetricsF& metrics, const QSize& size,
                                const CameraModel& camera, const DrawnScene& scene,
                                const DrawList& list) {
  std::vector<const InstanceLabel*> labels;
  std::vector<LabelRequest> wishes;
  for (const InstanceLabel& label : list.labels) {
    if (label.body >= scene.bodies.size()) continue;
    const Bounds& bounds_W = scene.bodies[label.body].bounds_W;
    if (bounds_W.empty()) continue;
    const auto top = TopOf(camera, bounds_W, label.X_W);
    if (!top) continue;
    const auto middle = camera.Project(label.X_W * bounds_W.centre());
    const QString text = QString::fromStdString(label.text);
    labels.push_back(&label);
    wishes.push_back({QPointF(middle->x(), middle->y()), top->y(),
                      QSizeF(metrics.horizontalAdvance(text) + 34, metrics.height() + 8)});
  }
  const std::vector<LabelPlace> places = PlaceLabels(wishes, size);
  std::vector<PlacedLabel> placed;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    placed.push_back({labels[i], wishes[i].anchor, places[i]});
  }
  return placed;
}

void PaintLine(QPainter& painter, const PlacedLabel& placed) {
  const QColor colour = ToQColor(placed.label->colour, placed.label->opacity);
  painter.setPen(QPen(colour, 1.5));
  painter.drawLine(placed.place.foot, placed.anchor);
  painter.setBrush(colour);
  painter.drawEllipse(placed.anchor, 3.0, 3.0);
}

void PaintBox(QPainter& painter, const PlacedLabel& placed) {
  const InstanceLabel& label = *placed.label;
  const QRectF& box = placed.place.box;
  painter.setOpacity(static_cast<double>(label.opacity));
  const QColor colour = ToQColor(label.colour);
  painter.setPen(QPen(colour, 1.5));
  painter.setBrush(QColor(255, 255, 255, 235));
  painter.drawRoundedRect(box, 5, 5);
  painter.setBrush(colour);
  painter.setPen(Qt::NoPen);
  painter.drawEllipse(QPointF(box.left() + 14, box.center().y()), 5, 5);
  painter.setPen(QColor(30, 34, 40));
  painter.drawText(box.adjusted(25, 0, -6, 0), Qt::AlignVCenter | Qt::AlignLeft,
                   QString::fromStdString(label.text));
  painter.setOpacity(1.0);
}

void PaintAxes(QPainter& painter, const QSize& size, const CameraModel& camera) {
  const Mat3 R_CW = camera.R_WC().transpose();
  const QPointF origin(52, size.height() - 52);
  struct Axis {
    const char* name;
    QColor colour;
    Vec3 along_C;
  };
  std::array<Axis, 3> axes{{{"X", QColor(200, 45, 45), R_CW.col(0)},
                            {"Y", QColor(35, 140, 50), R_CW.col(1)},
                            {"Z", QColor(40, 85, 200), R_CW.col(2)}}};
  std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) {
    return a.along_C.z() < b.along_C.z();
  });
  for (const Axis& axis : axes) {
    const QPointF along(axis.along_C.x(), -axis.along_C.y());
    painter.setPen(QPen(axis.colour, 2.5, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(origin, origin + kAxisLength * along);
    const QPointF tip = origin + (kAxisLength + 10) * along;
    painter.drawText(QRectF(tip.x() - 8, tip.y() - 9, 16, 18), Qt::AlignCenter, axis.name);
  }
}

void PaintWarning(QPainter& painter, const QSize& size, const QString& warning) {
  const QRectF room(12, 12, size.width() - 24, size.height() / 2.0);
  const QRectF text = painter.boundingRect(room.adjusted(12, 8, -12, -8),
                                           Qt::AlignHCenter | Qt::TextWordWrap, warning);
  painter.setPen(QPen(QColor(180, 120, 0), 1));
  painter.setBrush(QColor(255, 244, 214, 240));
  painter.drawRoundedRect(text.adjusted(-12, -8, 12, 8), 5, 5);
  painter.setPen(QColor(90, 55, 0));
  painter.drawText(text, Qt::AlignHCenter | Qt::TextWordWrap, warning);
}

}  // namespace

void PaintOverlay(QPainter& painter, const QSize& size, const CameraModel& camera,
                  const DrawnScene& scene, const DrawList& list, const QString& warning) {
  painter.setRenderHint(QPainter::Antialiasing);
  PaintAxes(painter, size, camera);
  const QFontMetricsF metrics(painter.font());
  const std::vector<PlacedLabel> labels = Placed(metrics, size, camera, scene, list);
  for (const PlacedLabel& label : labels) PaintLine(painter, label);
  for (const PlacedLabel& label : labels) PaintBox(painter, label);
  if (!warning.isEmpty()) PaintWarning(painter, size, warning);
}

}  // namespace tandem

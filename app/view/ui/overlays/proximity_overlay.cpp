#include "app/view/ui/overlays/proximity_overlay.h"

#include <QLinearGradient>
#include <algorithm>

namespace tandem {

namespace {

const QColor kInk(30, 34, 40);
const QColor kPaper(255, 255, 255, 235);
constexpr QSizeF kScale(150, 10);  // px
constexpr int kScaleStops = 8;

void PaintBox(QPainter& painter, QPointF middle, const QSize& size, const QString& text) {
  const QFontMetricsF metrics(painter.font());
  QRectF box(0, 0, metrics.horizontalAdvance(text) + 16, metrics.height() + 8);
  box.moveCenter(middle);
  box.moveLeft(std::clamp(box.left(), 8.0, std::max(8.0, size.width() - box.width() - 8)));
  box.moveTop(std::clamp(box.top(), 8.0, std::max(8.0, size.height() - box.height() - 8)));
  painter.setPen(QPen(kInk, 1));
  painter.setBrush(kPaper);
  painter.drawRoundedRect(box, 5, 5);
  painter.drawText(box, Qt::AlignCenter, text);
}

void PaintLeastDistance(QPainter& painter, const QSize& size, const CameraModel& camera,
                        const SceneNearness& nearest, const ContactYield& yield,
                        const QString& what) {
  const auto from = camera.Project(nearest.p_WPart);
  const auto to = camera.Project(nearest.p_WOther);
  if (!from || !to) return;
  const QPointF a(from->x(), from->y());
  const QPointF b(to->x(), to->y());
  painter.setPen(QPen(kPaper, 5, Qt::SolidLine, Qt::RoundCap));
  painter.drawLine(a, b);
  painter.setPen(QPen(kInk, 2, Qt::SolidLine, Qt::RoundCap));
  painter.drawLine(a, b);
  painter.setPen(QPen(kPaper, 1.5));
  painter.setBrush(kInk);
  for (const QPointF& end : {a, b}) painter.drawEllipse(end, 4.0, 4.0);
  // to the lower right of the line, where no peer's name hangs
  const QPointF below((a.x() + b.x()) / 2 + 100, std::max(a.y(), b.y()) + 30);
  painter.setPen(QPen(kInk, 1, Qt::DotLine));
  painter.drawLine((a + b) / 2, below);
  PaintBox(painter, below, size, what + QString::fromStdString(DistanceText(nearest, yield)));
}

/// Explains the colours: moving bodies by distance, and the near voxels.
void PaintLegend(QPainter& painter, const QSize& size, const ProximityPicture& picture) {
  const QFontMetricsF metrics(painter.font());
  const double height = metrics.height();
  const QString near =
      QStringLiteral("fixed voxels within %1 mm")
          .arg(1e3 * ProximityComposer::kShadowVoxels * static_cast<double>(picture.voxel_size), 0,
               'g', 3);
  const double square = kScale.height();
  const double width = std::max(kScale.width(), metrics.horizontalAdvance(near) + square + 8);
  const QRectF bar(size.width() - width - 24, size.height() - kScale.height() - 2 * height - 26,
                   width, kScale.height());
  painter.setPen(Qt::NoPen);
  painter.setBrush(kPaper);
  painter.drawRoundedRect(bar.adjusted(-10, -8, 10, 2 * height + 14), 5, 5);
  QLinearGradient colours(bar.topLeft(), bar.topRight());
  for (int i = 0; i <= kScaleStops; ++i) {
    const double share = static_cast<double>(i) / kScaleStops;
    const std::array<float, 3> c = ProximityColour(share, 1);
    colours.setColorAt(share, QColor::fromRgbF(c[0], c[1], c[2]));
  }
  painter.setBrush(colours);
  painter.drawRect(bar);
  painter.setPen(kInk);
  const QRectF words(bar.left(), bar.bottom() + 2, bar.width(), height);
  painter.drawText(words, Qt::AlignLeft, QStringLiteral("0"));
  painter.drawText(words, Qt::AlignRight, QStringLiteral("\u2265 %1 mm").arg(1e3 * picture.range));
  const QRectF voxels = words.translated(0, height + 4);
  painter.setPen(Qt::NoPen);
  painter.setBrush(QColor::fromRgbF(kNearVoxelColour[0], kNearVoxelColour[1], kNearVoxelColour[2]));
  painter.drawRect(QRectF(voxels.left(), voxels.center().y() - square / 2, square, square));
  painter.setPen(kInk);
  painter.drawText(voxels.adjusted(square + 8, 0, 0, 0), Qt::AlignLeft, near);
}

}  // namespace

void PaintProximity(QPainter& painter, const QSize& size, const CameraModel& camera,
                    const ProximityPicture& picture) {
  painter.setRenderHint(QPainter::Antialiasing);
  const bool two = picture.of_held.other != SceneNearness::kNone;
  if (picture.nearest.other != SceneNearness::kNone) {
    const QString names = QString::fromStdString(picture.part + " \u2013 " + picture.other + ": ");
    PaintLeastDistance(painter, size, camera, picture.nearest, picture.yield,
                       two ? names : QString());
  }
  if (two) {
    PaintLeastDistance(painter, size, camera, picture.of_held, picture.held_yield,
                       QStringLiteral("in hand: "));
  }
  PaintLegend(painter, size, picture);
}

}  // namespace tandem

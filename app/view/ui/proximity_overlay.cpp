#include "app/view/ui/proximity_overlay.h"

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
                        const SceneNearness& nearest) {
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
  // beside the line's lower right, where names of peers never hang
  const QPointF below((a.x() + b.x()) / 2 + 100, std::max(a.y(), b.y()) + 30);
  painter.setPen(QPen(kInk, 1, Qt::DotLine));
  painter.drawLine((a + b) / 2, below);
  PaintBox(painter, below, size, QString::fromStdString(DistanceText(nearest)));
}

void PaintScale(QPainter& painter, const QSize& size, double range) {
  const QFontMetricsF metrics(painter.font());
  const double height = metrics.height();
  const QRectF bar(size.width() - kScale.width() - 24,
                   size.height() - kScale.height() - height - 20, kScale.width(), kScale.height());
  painter.setPen(Qt::NoPen);
  painter.setBrush(kPaper);
  painter.drawRoundedRect(bar.adjusted(-10, -8, 10, height + 8), 5, 5);
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
  painter.drawText(words, Qt::AlignRight, QStringLiteral("\u2265 %1 mm").arg(1e3 * range));
}

}  // namespace

void PaintProximity(QPainter& painter, const QSize& size, const CameraModel& camera,
                    const ProximityPicture& picture) {
  painter.setRenderHint(QPainter::Antialiasing);
  if (picture.nearest.other != SceneNearness::kNone) {
    PaintLeastDistance(painter, size, camera, picture.nearest);
  }
  PaintScale(painter, size, picture.range);
}

}  // namespace tandem

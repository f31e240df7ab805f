#include "app/view/paint_pictures.h"

#include <QFont>
#include <QGuiApplication>
#include <QImage>
#include <QPainter>
#include <cmath>

#include "app/common/exit_codes.h"
#include "app/picture/picture_file.h"
#include "app/view/program_lines.h"

namespace tandem {

namespace {

constexpr double kScale = 2;  // factor on a picture's size, which makes text sharp

QColor ColourOf(const Rgb& colour) {
  return {colour.r, colour.g, colour.b};
}

QPen PenOf(const Stroke& stroke) {
  QPen pen(ColourOf(stroke.colour), stroke.width);
  pen.setJoinStyle(Qt::RoundJoin);
  pen.setCapStyle(Qt::FlatCap);
  if (!stroke.dashes.empty() && stroke.width > 0) {
    QList<qreal> dashes;  // in multiples of the line's width
    for (const double dash : stroke.dashes) dashes.push_back(dash / stroke.width);
    if (dashes.size() % 2 != 0) dashes += dashes;  // as SVG repeats them
    pen.setDashPattern(dashes);
  }
  return pen;
}

QPointF PointOf(const PicturePoint& point) {
  return {point.x, point.y};
}

class ShapePainter {
 public:
  explicit ShapePainter(QPainter& painter) : painter_(painter) {}

  void operator()(const RectangleShape& shape) const {
    painter_.setPen(shape.edge ? PenOf(*shape.edge) : QPen(Qt::NoPen));
    painter_.setBrush(shape.fill ? QBrush(ColourOf(*shape.fill)) : QBrush(Qt::NoBrush));
    painter_.drawRect(QRectF(shape.box.x, shape.box.y, shape.box.width, shape.box.height));
  }

  void operator()(const PolylineShape& shape) const {
    QPolygonF points;
    for (const PicturePoint& point : shape.points) points.push_back(PointOf(point));
    painter_.setPen(PenOf(shape.stroke));
    painter_.drawPolyline(points);
  }

  void operator()(const MarkerShape& shape) const {
    const double half = 0.5 * shape.size;
    const QPointF at = PointOf(shape.at);
    painter_.setPen(PenOf({shape.colour, 1.5, {}}));
    painter_.setBrush(Qt::NoBrush);
    switch (shape.kind) {
      case MarkerKind::kCross:
        painter_.drawLine(at + QPointF(-half, -half), at + QPointF(half, half));
        painter_.drawLine(at + QPointF(-half, half), at + QPointF(half, -half));
        return;
      case MarkerKind::kRing:
        painter_.drawEllipse(at, half - 0.75, half - 0.75);
        return;
      case MarkerKind::kDot:
        painter_.setPen(Qt::NoPen);
        painter_.setBrush(ColourOf(shape.colour));
        painter_.drawEllipse(at, half, half);
        return;
    }
  }

  void operator()(const LabelShape& shape) const {
    QFont font(QStringLiteral("DejaVu Sans"));
    font.setStyleHint(QFont::SansSerif);
    font.setPixelSize(static_cast<int>(std::lround(shape.size)));
    font.setBold(shape.bold);
    painter_.save();
    painter_.setFont(font);
    painter_.setPen(ColourOf(shape.colour));
    painter_.translate(PointOf(shape.at));
    if (shape.upwards) painter_.rotate(-90);
    const QString text = QString::fromStdString(shape.text);
    const double length = QFontMetricsF(font).horizontalAdvance(text);
    double from = 0;
    if (shape.anchor == TextAnchor::kMiddle) from = -0.5 * length;
    if (shape.anchor == TextAnchor::kEnd) from = -length;
    painter_.drawText(QPointF(from, 0), text);
    painter_.restore();
  }

 private:
  QPainter& painter_;
};

bool Paint(const Picture& picture, const std::filesystem::path& file) {
  QImage image(static_cast<int>(std::ceil(kScale * picture.width)),
               static_cast<int>(std::ceil(kScale * picture.height)), QImage::Format_RGB32);
  if (image.isNull()) return false;
  image.fill(Qt::white);
  {
    QPainter painter(&image);
    painter.setRenderHints(QPainter::Antialiasing | QPainter::TextAntialiasing);
    painter.scale(kScale, kScale);
    const ShapePainter one(painter);
    for (const PictureShape& shape : picture.shapes) std::visit(one, shape);
  }
  return image.save(QString::fromStdString(file.string()), "PNG");
}

}  // namespace

int PaintPictures(const std::filesystem::path& pictures, const std::filesystem::path& folder) {
  const Result<std::vector<Picture>> all = ReadPictures(pictures);
  if (!all) return FailFromView(kExitFile, all.error().what);
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) return FailFromView(kExitFile, folder.string() + ": " + failed.message());
  qputenv("QT_QPA_PLATFORM", "offscreen");
  char name[] = "tandem-view";
  char* argv[] = {name, nullptr};
  int argc = 1;  // Qt gets none of the arguments
  const QGuiApplication fonts(argc, argv);
  for (const Picture& picture : *all) {
    const std::filesystem::path file = folder / (picture.name + ".png");
    if (!Paint(picture, file))
      return FailFromView(kExitFile, file.string() + ": cannot be written");
  }
  return kExitOk;
}

}  // namespace tandem

#include "app/view/ui/overlays/hand_overlay.h"

#include <QObject>
#include <QPainterPath>
#include <array>
#include <cmath>

namespace tandem {

namespace {

constexpr double kLeastTether = 3;         // px; a shorter tether is drawn as a dot
constexpr double kLeastForceShown = 0.05;  // N
const std::array<QColor, 3> kAxisColours{QColor(200, 45, 45), QColor(35, 140, 50),
                                         QColor(40, 85, 200)};

QPointF Point(const Vec2& px) {
  return {px.x(), px.y()};
}

QColor ColourOfForce(double force_N) {
  const Colour c = ForceColour(force_N);
  return QColor::fromRgbF(c[0], c[1], c[2]);
}

void PaintContacts(QPainter& painter, const CameraModel& camera, const HandPicture& hand) {
  for (const ContactMark& mark : hand.contacts) {
    const auto at = camera.Project(mark.p_W);
    if (!at) continue;
    const QColor colour = ColourOfForce(mark.force_N);
    const double length_px = 10 + 6 * std::min(mark.force_N, kTetherFullForce);
    const auto tip =
        camera.Project(mark.p_W + length_px * camera.MetresPerPixelAt(mark.p_W) * mark.n_W);
    if (tip) {
      painter.setPen(QPen(colour, 2));
      painter.drawLine(Point(*at), Point(*tip));
    }
    painter.setPen(QPen(Qt::white, 1));
    painter.setBrush(colour);
    painter.drawEllipse(Point(*at), 4, 4);
  }
}

void PaintTether(QPainter& painter, const CameraModel& camera, const Tether& tether, bool figures) {
  const auto from = camera.Project(tether.from_W);
  const auto to = camera.Project(tether.to_W);
  if (!from || !to) return;
  const QColor colour = ColourOfForce(tether.force_N);
  const double length = (*to - *from).norm();
  if (length >= kLeastTether) {
    painter.setPen(QPen(QColor(255, 255, 255, 200), 6, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(Point(*from), Point(*to));
    painter.setPen(QPen(colour, 3, Qt::SolidLine, Qt::RoundCap));
    painter.drawLine(Point(*from), Point(*to));
    painter.setBrush(Qt::white);
    painter.setPen(QPen(colour, 2));
    painter.drawEllipse(Point(*to), 5, 5);
  }
  painter.setPen(QPen(Qt::white, 1));
  painter.setBrush(colour);
  painter.drawEllipse(Point(*from), 4, 4);
  if (!figures || tether.force_N < kLeastForceShown) return;
  const QString text = QObject::tr("%1 N").arg(tether.force_N, 0, 'f', 1);
  const QFontMetricsF metrics(painter.font());
  QRectF box(to->x() + 10, to->y() + 8, metrics.horizontalAdvance(text) + 12, metrics.height() + 4);
  painter.setPen(QPen(colour, 1));
  painter.setBrush(QColor(255, 255, 255, 235));
  painter.drawRoundedRect(box, 4, 4);
  painter.setPen(QColor(30, 34, 40));
  painter.drawText(box, Qt::AlignCenter, text);
}

void PaintLockedLine(QPainter& painter, const CameraModel& camera, const Vec3& p_W,
                     const Vec3& axis_W) {
  // longer than the picture in both directions
  const double half = 2000 * camera.MetresPerPixelAt(p_W);
  const double before_eye = 0.9 * (camera.eye_W() - p_W).dot(camera.R_WC().col(2));
  const double towards = axis_W.dot(camera.R_WC().col(2));
  const auto end = [&](double sign) {
    double length = half;
    if (sign * towards > 0) length = std::min(length, before_eye / (sign * towards));
    return camera.Project(p_W + sign * length * axis_W);
  };
  const auto a = end(1);
  const auto b = end(-1);
  if (!a || !b) return;
  painter.setPen(QPen(QColor(60, 66, 74), 1.5, Qt::DashLine));
  painter.drawLine(Point(*a), Point(*b));
}

QPen PenOfHandle(const HandPicture& hand, TriadHandle::Kind kind, int axis) {
  const bool hot = hand.hot == TriadHandle{kind, axis};
  const QColor colour = hot ? QColor(250, 170, 20) : kAxisColours[static_cast<std::size_t>(axis)];
  return QPen(colour, hot ? 4.5 : 2.5, Qt::SolidLine, Qt::RoundCap);
}

void PaintArrow(QPainter& painter, const QPen& pen, const Vec2& from, const Vec2& to) {
  painter.setPen(pen);
  painter.drawLine(Point(from), Point(to));
  const Vec2 along = (to - from).normalized();
  const Vec2 across(-along.y(), along.x());
  QPolygonF head;
  head << Point(to + 10 * along) << Point(to + 5 * across) << Point(to - 5 * across);
  painter.setBrush(pen.color());
  painter.setPen(Qt::NoPen);
  painter.drawPolygon(head);
}

void PaintTriad(QPainter& painter, const CameraModel& camera, const HandPicture& hand) {
  const std::optional<TriadPicture> triad = DrawTriad(camera, *hand.X_WT);
  if (!triad) return;
  using Kind = TriadHandle::Kind;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    QPolygonF ring;
    for (const Vec2& p : triad->rings[i]) ring << Point(p);
    painter.setBrush(Qt::NoBrush);
    QPen pen = PenOfHandle(hand, Kind::kRing, axis);
    pen.setWidthF(0.7 * pen.widthF());
    painter.setPen(pen);
    painter.drawPolyline(ring);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (triad->square_usable[i]) {
      QPolygonF square;
      for (const Vec2& p : triad->squares[i]) square << Point(p);
      QColor fill = PenOfHandle(hand, Kind::kSquare, axis).color();
      painter.setPen(QPen(fill, 1));
      fill.setAlpha(110);
      painter.setBrush(fill);
      painter.drawPolygon(square);
    }
    const TriadPicture::Arrow& arrow = triad->arrows[i];
    if (arrow.usable) {
      PaintArrow(painter, PenOfHandle(hand, Kind::kArrow, axis), arrow.from, arrow.to);
    }
  }
}

}  // namespace

void PaintHand(QPainter& painter, const CameraModel& camera, const HandPicture& hand) {
  painter.setRenderHint(QPainter::Antialiasing);
  if (hand.locked_line_W) {
    PaintLockedLine(painter, camera, hand.locked_line_W->first, hand.locked_line_W->second);
  }
  PaintContacts(painter, camera, hand);
  if (hand.tether) PaintTether(painter, camera, *hand.tether, hand.figures);
  if (hand.X_WT) PaintTriad(painter, camera, hand);
}

}  // namespace tandem

#pragma once

#include <QPainter>
#include <QSize>

#include "app/view/model/scene/camera_model.h"
#include "app/view/model/scene/drawn_scene.h"
#include "app/view/model/scene/picture_composer.h"

namespace tandem {

/// Paints over the picture: peers' names beside their instances, each with a line to the body; a
/// warning across the top; the axes of W in the lower left corner.
void PaintOverlay(QPainter& painter, const QSize& size, const CameraModel& camera,
                  const DrawnScene& scene, const DrawList& list, const QString& warning);

}  // namespace tandem

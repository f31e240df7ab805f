#include "app/view/model/scene/label_layout.h"

#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

const QSizeF kPicture(900, 700);
const QSizeF kLabel(130, 26);

/// Returns points of a label's line, a pixel from one another.
std::vector<QPointF> PointsOf(const LabelPlace& place, const QPointF& anchor) {
  const QPointF way = anchor - place.foot;
  const int steps = 1 + static_cast<int>(std::hypot(way.x(), way.y()));
  std::vector<QPointF> points;
  for (int i = 0; i <= steps; ++i) points.push_back(place.foot + way * i / steps);
  return points;
}

void ExpectLegible(const std::vector<LabelRequest>& wishes, const std::vector<LabelPlace>& places) {
  ASSERT_EQ(places.size(), wishes.size());
  const QRectF picture(QPointF(0, 0), kPicture);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_TRUE(picture.contains(places[i].box)) << i;
    EXPECT_EQ(places[i].box.size(), wishes[i].size);
    for (const LabelRequest& wish : wishes) {
      EXPECT_FALSE(places[i].box.contains(wish.anchor)) << "a dot upon the text of " << i;
    }
    for (std::size_t j = 0; j < places.size(); ++j) {
      if (i == j) continue;
      EXPECT_FALSE(places[i].box.intersects(places[j].box)) << i << " over " << j;
      for (const QPointF& point : PointsOf(places[i], wishes[i].anchor)) {
        ASSERT_FALSE(places[j].box.contains(point)) << "the line of " << i << " through " << j;
      }
    }
  }
}

TEST(LabelLayout, SingleLabelIsAboveItsAnchor) {
  const std::vector<LabelRequest> wishes{{{400, 300}, 250, kLabel}};
  const std::vector<LabelPlace> places = PlaceLabels(wishes, kPicture);
  ExpectLegible(wishes, places);
  EXPECT_LT(places[0].box.bottom(), 250);
  EXPECT_EQ(places[0].box.center().x(), 400);
}

// A shared body has one instance at each holder, and these are nearly at one place.
TEST(LabelLayout, LeaderLinesCrossNoText) {
  for (const std::size_t count : {2U, 3U, 4U, 5U}) {
    std::vector<LabelRequest> wishes;
    for (std::size_t i = 0; i < count; ++i) {
      wishes.push_back({{400.0 + static_cast<double>(i), 300}, 250, kLabel});
    }
    ExpectLegible(wishes, PlaceLabels(wishes, kPicture));
  }
}

TEST(LabelLayout, LabelsAtTheRimCoverNoDot) {
  for (const QPointF at : {QPointF(400, 12), QPointF(10, 10), QPointF(890, 20), QPointF(895, 690),
                           QPointF(450, 695), QPointF(3, 350)}) {
    const std::vector<LabelRequest> wishes{{at, at.y() - 8, kLabel},
                                           {at + QPointF(2, 1), at.y() - 6, kLabel}};
    ExpectLegible(wishes, PlaceLabels(wishes, kPicture));
  }
}

TEST(LabelLayout, FourLabelsStayLegibleAnywhere) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(0, kPicture.width());
  std::uniform_real_distribution<double> y(0, kPicture.height());
  for (int i = 0; i < 500; ++i) {
    std::vector<LabelRequest> wishes;
    for (int k = 0; k < 4; ++k) {
      const QPointF anchor(x(random), y(random));
      wishes.push_back({anchor, anchor.y() - 40, kLabel});
    }
    ExpectLegible(wishes, PlaceLabels(wishes, kPicture));
    if (HasFatalFailure() || HasNonfatalFailure()) FAIL() << "picture " << i;
  }
}

TEST(LabelLayout, AllLabelsArePlacedInATinyPicture) {
  const std::vector<LabelRequest> wishes(20, {{20, 20}, 10, kLabel});
  EXPECT_EQ(PlaceLabels(wishes, QSizeF(100, 40)).size(), 20U);
}

}  // namespace
}  // namespace tandem

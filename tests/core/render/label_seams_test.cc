#include "core/render/seams/label_seams.h"

#include <gtest/gtest.h>

#include <vector>

namespace skyquilt::render {
namespace {

// A view of `side` x `side` cells from the grid's corner that sees them all, in one grey.
LowResView PlainView(int side, std::uint8_t grey, float score_m) {
  LowResView view;
  view.columns = view.rows = side;
  const auto cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  view.seen.assign(cells, Seen::kFully);
  view.rgb.assign(cells, {grey, grey, grey});
  view.score_m.assign(cells, score_m);
  return view;
}

SeamGrid GridOf(int side) {
  SeamGrid grid;
  grid.columns = grid.rows = side;
  return grid;
}

TEST(LabelSeams, CutsWhereNoCandidateHasANeighbour) {
  // The second photo may take one cell alone: nothing to weigh against its neighbours, which stay.
  std::vector<LowResView> views{PlainView(5, 100, 1.0f), PlainView(5, 100, 2.0f)};
  views[1].seen.assign(25, Seen::kNot);
  views[1].seen[12] = Seen::kFully;
  const SeamLabels labels = LabelSeams(views, GridOf(5), {true, 50.0, nullptr});
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 5; ++column) EXPECT_EQ(labels.At(column, row), 0);
  }
}

TEST(LabelSeams, TakesFlightsWithNothingToDecide) {
  EXPECT_EQ(LabelSeams({}, GridOf(3), {true, 50.0, nullptr}).At(1, 1), kNoPhoto);
  EXPECT_EQ(LabelSeams({LowResView{}}, GridOf(3), {true, 50.0, nullptr}).At(1, 1), kNoPhoto);
  EXPECT_EQ(LabelSeams({PlainView(1, 0, 0.0f)}, GridOf(1), {true, 50.0, nullptr}).At(0, 0), 0);
  // Two photos alike in everything: the first shows all.
  const std::vector<LowResView> same{PlainView(4, 80, 1.0f), PlainView(4, 80, 1.0f)};
  const SeamLabels labels = LabelSeams(same, GridOf(4), {true, 0.0, nullptr});
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) EXPECT_EQ(labels.At(column, row), 0);
  }
}

}  // namespace
}  // namespace skyquilt::render

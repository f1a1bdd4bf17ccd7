// FindLines: which photos were taken on one straight flight line. Gimbals and compasses err alike within a
// line. Pure; any thread.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace skyquilt::alignment {

// A line number per photo (0, 1, ...), photos in order of capture. A turn ends a line; so does a gap of
// several times the usual spacing.
std::vector<int> FindLines(const std::vector<Eigen::Vector2d>& east_north);

}  // namespace skyquilt::alignment

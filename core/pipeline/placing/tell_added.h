// What is said of a map that got photos: the figures of its alignment with the new ones among them, and what
// was remarked while these were posed and aligned, beside what stands there and not twice. Pure; any thread.
#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "core/alignment/scene/align_report.h"
#include "core/alignment/scene/aligned_flight.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::pipeline {

// The figures of the new photos beside those of the finished flight. One that it left out has some there,
// even as aligned, where its pose was one that no map is drawn with. `part`: of the alignment of the new
// photos and those around them. `added`: their names. `photos`: of the map, with the new ones.
void AddFigures(const alignment::AlignReport& part, const std::set<std::string>& added,
                const std::vector<alignment::AlignedPhoto>& photos, alignment::AlignReport& known);

// `now` takes the place of the same with other numbers, also within a sentence; whether it is said.
bool SayAnew(const flight::Remark& now, std::vector<flight::Remark>& warnings);

// `posed`: of all photos together as they were posed now. `is_placed`: something says, maybe since, where.
void TellPosed(const std::vector<flight::Remark>& posed, bool is_placed,
               std::vector<flight::Remark>& warnings);

// `aligned`: of the new photos and those around them. What is of the latter alone was said, and how the whole
// map hangs together is said by TellGroups.
void TellAligned(const std::vector<flight::Remark>& aligned, const std::set<std::string>& added,
                 std::vector<flight::Remark>& warnings);

// Of so many groups without ties between them.
void TellGroups(int groups, std::size_t photos, std::vector<flight::Remark>& warnings);

// Photos that came at several times are told of together.
void TellAdded(std::size_t photos, std::vector<flight::Remark>& warnings);

}  // namespace skyquilt::pipeline

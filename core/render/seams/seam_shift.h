// SeamShift: how far the two photos that meet at a seam show things apart, on the ground in metres, over the
// patches that were looked at; and what is said of a map of which only the seams of photos that were added
// are measured anew. A value; pure; any thread.
#pragma once

namespace skyquilt::render {

struct SeamShift {
  int patches = 0;   // looked at
  int reliable = 0;  // of those: alike once shifted
  double gsd_m = 0.0;
  double median_m = 0.0;
  double p90_m = 0.0;

  bool operator==(const SeamShift&) const = default;
};

// So many reliable patches tell of a map.
inline constexpr int kFewestSeams = 5;
inline bool TellOfMap(const SeamShift& seams) { return seams.reliable >= kFewestSeams; }

// Of a map that got photos: its seams as they were before, or those beside the new photos where they are
// enough and further apart.
inline SeamShift WorseOf(const SeamShift& before, const SeamShift& beside_new) {
  return TellOfMap(beside_new) && beside_new.median_m > before.median_m ? beside_new : before;
}

}  // namespace skyquilt::render

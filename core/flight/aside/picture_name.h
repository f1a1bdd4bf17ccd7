// What the names of pictures say of how they belong together: copies that programs and people name after
// their original, and the lenses of one camera. Pure; any thread.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace skyquilt::flight {

// How sure a mark at the end of a name is to be a copy's.
enum class CopyMark {
  kNone = 0,
  kNumber = 1,    // "-2", "~2", " 2": of exports, and of some cameras' series
  kBrackets = 2,  // "(1)": of copies into one folder, and of some phones' series
  kWord = 3,      // " copy", "_edited", "Copy of "
};

struct PictureName {
  std::string file;                 // lower case, with folders, without exiftool's "_original"
  std::string stem;                 // the same without folders and ending
  bool is_before_a_change = false;  // "DJI_0001.JPG_original"
};
PictureName PictureNameOf(std::string_view name);

// Without its last mark of a copy; nothing where it has none.
struct Unmarked {
  std::string stem;
  CopyMark mark = CopyMark::kNone;
};
std::optional<Unmarked> WithoutCopyMark(std::string_view stem);

// Without the word of a program that wrote positions into it ("dji_0001_geotag"); nothing where it has none.
std::optional<std::string_view> WithoutTagMark(std::string_view stem);

// "w" of "dji_0001_w", as cameras with several lenses end their names; empty for others.
std::string_view LensMark(std::string_view stem);

// Whether both are a word and a counter (and the mark of a lens), the word the same and the counters not: a
// camera's own names of two exposures.
bool AreOfOneCounter(std::string_view stem, std::string_view other);

}  // namespace skyquilt::flight

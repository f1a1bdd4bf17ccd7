// The sentences of remarks on the two ways to place a flight, by its records and by what the photos show
// alone, and on why the one or the other was taken; each is a part of a sentence. remark_sentences.cc joins
// them with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnAttempts = std::to_array<RemarkSentence>({
    {RemarkCode::kImagesAskedFor, "images_asked_for", "placing by what they show was asked for"},
    {RemarkCode::kRecordsUnplaced, "records_unplaced",
     "{photos} of {total} photos have no usable position or height"},
    {RemarkCode::kRecordsLost, "records_lost",
     "by their recorded poses {photos} of {total} photos do not fit to the others"},
    {RemarkCode::kRecordsDisagree, "records_disagree",
     "by their recorded poses the photos disagree by {apart_px:.1f} pixels"},
    {RemarkCode::kRecordsNoPoint, "records_no_point",
     "by their recorded poses no point found in several photos fits"},
    {RemarkCode::kRecordsFewPoints, "records_few_points",
     "by their recorded poses only {used} of {points} points found in several photos fit"},
    {RemarkCode::kRecordsElsewhere, "records_elsewhere",
     "by their recorded heights and angles {photos} of {total} photos do not lie where they were recorded"},
    {RemarkCode::kImagesTie, "images_tie",
     "what the photos show ties {photos} of them together, the recorded poses {by_records}"},
    {RemarkCode::kImagesDisagree, "images_disagree",
     "placed by what they show, the photos disagree by {apart_px:.1f} pixels, by the recorded poses by "
     "{by_records_px:.1f}"},
    {RemarkCode::kImagesOffPositions, "images_off_positions",
     "what the photos show contradicts {photos} of {total} recorded positions, the alignment by records {by_records} of "
     "{of_records}"},
    {RemarkCode::kImagesOffAngles, "images_off_angles",
     "what the photos show contradicts {photos} of {total} recorded camera angles, the alignment by records {by_records} "
     "of {of_records}"},
    {RemarkCode::kImagesFit, "images_fit",
     "{used} of {points} points found in several photos fit, by the recorded poses {by_records} of {of_records}"},
    {RemarkCode::kImagesAgree, "images_agree",
     "what the photos show agrees with {photos} of {total} recorded positions, the alignment by records with {by_records} "
     "of {of_records}"},
    {RemarkCode::kRecordsHold, "records_hold",
     "the recorded poses hold: {photos} of {total} photos are tied together from them"},
    {RemarkCode::kImagesNotTaken, "images_not_taken", "not taken: {why}"},
    {RemarkCode::kImagesPlaced, "images_placed",
     "{photos} of {total} photos placed by what they show{place}{height}"},
    {RemarkCode::kImagesOnPositions, "images_on_positions",
     "; {positions} of {total} recorded positions agree with it"},
    {RemarkCode::kImagesAgainstPositions, "images_against_positions",
     "; the recorded positions CONTRADICT it, by {apart_m:.0f} m in the median, which is {times:.0f} times what they "
     "claim: the map lies where most of them have it"},
    {RemarkCode::kImagesOnControl, "images_on_control", "; surveyed points say where on Earth"},
    {RemarkCode::kImagesOnHeights, "images_on_heights", "; recorded heights say how large"},
    {RemarkCode::kImagesAboutPositions, "images_about_positions",
     "; the recorded positions say about where it lies, but nothing says how large it is, nor where north is: add the "
     "flight log, surveyed points (gcp_list.txt) or positions (geo.txt)"},
    {RemarkCode::kImagesNowhere, "images_nowhere", "; nothing says where on Earth, nor how large"},
    {RemarkCode::kFlownAt, "flown_at", "; flown {height_m:.0f} m above the ground"},
    {RemarkCode::kFlownAtOtherThan, "flown_at_other_than",
     "; flown {height_m:.0f} m above the ground ({expected_m:.0f} m were expected)"},
});

}  // namespace skyquilt::flight

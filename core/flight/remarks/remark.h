// Remark: one thing that whoever asked for a map is to know, as a code with numbers and names. Whoever
// decides looks at the code. The English sentence is made by InWords (remark_words.h) alone, from
// sentences_on_*.h; those of the page stand in web/src/languages/*/remarks.js, and
// tests/web/languages/remarks.test.js holds all of them to this list. A value's name ends with its unit
// (`apart_m`), or with `_words` where it is English that no code stands for. Values; any thread.
#pragma once

#include <concepts>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace skyquilt::flight {

enum class RemarkCode : std::uint16_t {
  kText,       // a sentence without a code, as a reader of files has it
  kSentences,  // one after the other
  kOfPhoto,
  kOfPhotos,
  kMoreOfPhotos,
  // Files.
  kOfFile,
  kSameFile,
  kFileNotRead,
  kFilesUnknown,
  kFilesUnknownAndMore,
  kElevationModels,
  kElevationModelGiven,
  kElevationModelNotRead,
  kFilm,
  kNoBandsForList,
  // What photos lack.
  kPhotosWithoutPosition,
  kPhotosTimedByName,
  kPhotosWithoutTime,
  kPhotosOfUnknownZone,
  // What was corrected or doubted on reading a photo.
  kResaved,
  kTurnedByExif,
  kXmpDamaged,
  kPositionUnread,
  kPositionZero,
  kPositionNotOnEarth,
  kPositionNotValid,
  kHemispheresUnsaid,
  kPositionsApart,
  kAltitudeImpossible,
  kAltitudeOfTakeoff,
  kAltitudeRepeatsHeight,
  kAltitudesApart,
  kClocksDisagree,
  kAnglesImpossible,
  kAnglesZero,
  kHeadingAlone,
  kGyroNotUsed,
  kGyroAtImpossibleTime,
  kGyroDamaged,
  kGyroTooShort,
  kGyroImpossibleRates,
  kGyroBackwards,
  kGyroWithGaps,
  kFisheyeAsPlain,
  kFisheyeFitted,
  kSizeNotAsRecorded,
  kSensorOfWrongUnit,
  kSensorAsKnown,
  kSensorByEquivalent,
  kSensorImpossible,
  kNoFocalLength,
  // Pictures of other cameras.
  kOtherCameraAside,
  kThermalAside,
  kVisibleAside,
  // Lists of positions and of surveyed points: as what one is read.
  kReadingSystem,
  kReadingDegreesEastFirst,
  kReadingDegreesNorthFirst,
  kReadingDegreesAsNamed,
  kReadingDegreesAgainstNames,
  kReadingUtm,
  kReadingNorthFirst,
  kReadingWestPositive,
  kReadingSouthPositive,
  // What it is compared with.
  kOwnLists,
  kOwnPhotos,
  kOwnRecords,
  // What became of it.
  kListNamesNoPhoto,
  kListRowsOfSeveralPhotos,
  kListAnglesContradict,
  kListReadInUnnamedZone,
  kListReadOtherwise,
  kListReadOtherwiseOutsideSystem,
  kListReadOtherwiseNowhere,
  kListOrderAssumed,
  kListOutsideArea,
  kListFarFromOthers,
  kPointsWithoutSystem,
  kPointsWithoutSystemApart,
  kListWithoutSystem,
  kListWithoutSystemApart,
  kListNowhere,
  kListOutsideSystem,
  kListFarFromPhotos,
  kListFarFromLists,
  kListOfOtherShape,
  kListOfOtherShapeThanLists,
  // Logs.
  kLogEmpty,
  kLogAddsNothing,
  kLogWithoutUtc,
  kLogOfOtherSeconds,
  kLogOfOtherTime,
  kLogUnusable,
  kAnglesReadOtherwise,
  // What was skipped, cut or assumed on reading a log or list.
  kMoreOfFile,
  kRowsUnread,
  kRowsWithoutTime,
  kRowsWithoutImage,
  kRowsBeyond,
  kRowsNowhere,
  kLineIsNone,
  kLineIsNoneButThis,
  kCellUnread,
  kCellsUnread,
  kMoreCellsUnread,
  kDatesOfNoZone,
  kAnglesWithoutHeader,
  kAnglesElsewhere,
  kHeightsNotSurveyed,
  kSightingsBeyond,
  kPointOutsideSystem,
  kTimesTakenAsLocal,
  kTimesTakenAsUtc,
  kPointsSkipped,
  kPointsSkippedAndUnread,
  kPointsBeyond,
  kPlacesBeyond,
  kTimesAndPlacesUnequal,
  kDamagedAtByte,
  kNoDate,
  kChecksumsWrong,
  kClockIsLocal,
  kFilmShorter,
  kBytesDamaged,
  kCutInMessage,
  kCutInPacket,
  kEventsWithoutTime,
  kPositionsOfAutopilot,
  kOneImuOf,
  kOneVehicleOf,
  kImuClipped,
  kImuTooSlow,
  kClockOfGroundStation,
  kFormatMalformed,
  kUlogTooNew,
  kTopicWithoutFormat,
  kRecorderDroppedOut,
  kMessagesUnknown,
  kSubscriptionsBeyond,
  kClockJumpedBack,
  kImuAveraged,
  kSeriesThinned,
  kSamplesOfOneTime,
  kSamplesWithoutNumbers,
  kPositionsWithoutFix,
  kStampsStray,
  kEventsBeyond,
  // Where the flight was, and how high.
  kReckonedFromOrigin,
  kReckonedFromNowhere,
  kNotGeoreferenced,
  kNoAngles,
  kAnglesAssumed,
  kAnglesFound,
  kNoHeights,
  kHeightBySpacing,
  kOnTheGround,
  kHeightBySpacingOnTheGround,
  kHeightFound,
  kAssumedByPoses,
  kElevationModelBesideTakeoff,
  kElevationModelTooSmall,
  // Alignment.
  kNoTies,
  kGroups,
  kGroupsOfFeatures,
  kControlContradicts,
  kPointsDropped,
  kPositionsContradict,
  kPlacedByImages,
  kHeightsTilted,
  kPositionsOfBefore,
  kPositionsOfAfter,
  kClockBehind,
  kClockAhead,
  kSecondsApart,
  kPhotosApart,
  kRollingShutterFound,
  kMountTurned,
  kMountTurnedAgainstCourse,
  kPhotosStoredTurned,
  kPhotosStoredTurnedAgainstCourse,
  kFoundTurned,
  kFoundTurnedAgainstCourse,
  kYawCorrected,
  kCourseYawCorrected,
  kPositionCorrected,
  kPositionElsewhere,
  kPlacedWithoutRecord,
  // Why a photo is not aligned, or how it was.
  kByPoseAlone,
  kByPoseUnreadable,
  kByPoseFewPoints,
  kByPoseAsNeighbours,
  kByPoseMovedToFit,
  kByPoseNoFit,
  kMovedToFit,
  kFirstOfChain,
  kChained,
  kDoubtCopy,
  kDoubtBlurred,
  kDoubtOtherPlace,
  kControlNotUsed,
  kControlFarOff,
  kControlFarOffAndNoted,
  kControlNoted,
  // Why a surveyed point is not used, or not all of its marks.
  kPointFewMarks,
  kPointMarksElsewhere,
  kPointMarksApart,
  kPointFarFromOthers,
  kPointOffOthers,
  // What became of a finished map.
  kPhotosAdded,
  kMovedToControl,
  kPlacedByControl,
  kPlacedByPairs,
  kPairsDisagree,
  kPlacedByOrigin,
  kPlacedByPhoto,
  kImported,
  kCoarserPixels,
  kNoBands,
  kBandLaidAsOthers,
  kBandLaidAsReference,
  kCapturesNotPlaced,
  kTargetUnseen,
  kTargetUneven,
  kEveryCaptureAPanel,
  kBandsWithoutPanel,
  // What is foretold.
  kAllByImages,
  kAllByImagesAndControl,
  kSomeByImages,
  kLittleOverlap,
  // Why a picture takes no part.
  kLeftSameBytes,
  kLeftPanorama,
  kLeftRawPicture,
  kLeftThumbnailFirst,
  kLeftCopy,
  kLeftOlderMetadata,
  kLeftOtherCamera,
  kLeftThermal,
  kLeftVisible,
  kLeftPanel,
  kLeftWithoutPosition,
  kLeftOutsideLog,
  kLeftWithoutHeight,
  kLeftNoNumbers,
  kLeftFarFromFlight,
  kLeftBeyondMaps,
  kLeftOnTheGround,
  kLeftBelowGround,
  kLeftTooMuchGround,
  kLeftFarAway,
  kLeftNoFeaturesMatch,
  kLeftBentByChain,
  kLeftNothingInCommon,
};

struct Remark;

// A number, a name as it was given, or what is to be said within the sentence.
struct RemarkValue {
  std::variant<std::int64_t, double, std::string, std::vector<Remark>> is;

  RemarkValue(std::integral auto number) : is(static_cast<std::int64_t>(number)) {}
  RemarkValue(double number) : is(number) {}
  RemarkValue(std::string name) : is(std::move(name)) {}
  RemarkValue(const char* name) : is(std::string(name)) {}
  RemarkValue(Remark within);
  RemarkValue(std::vector<Remark> within);
  bool operator==(const RemarkValue&) const = default;
};

struct Remark {
  RemarkCode code = RemarkCode::kText;
  std::map<std::string, RemarkValue> values;

  Remark(RemarkCode its_code, std::map<std::string, RemarkValue> its_values = {})
      : code(its_code), values(std::move(its_values)) {}
  Remark(std::string text) : values{{"text_words", std::move(text)}} {}
  Remark(const char* text) : Remark(std::string(text)) {}
  bool operator==(const Remark&) const = default;
};

inline RemarkValue::RemarkValue(Remark within) : is(std::vector<Remark>{std::move(within)}) {}
inline RemarkValue::RemarkValue(std::vector<Remark> within) : is(std::move(within)) {}

}  // namespace skyquilt::flight

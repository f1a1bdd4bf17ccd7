// RecallFlight: what an earlier run placed, where the files that it was made of are still there, and what a
// run may do with it instead of aligning the flight anew. Facts that cannot be read are as good as none. Pure
// but for DigestsOf, which reads files; any thread.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/flight/flight.h"
#include "core/pipeline/mosaic_options.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/pyramid/map_memory.h"

namespace skyquilt::pipeline {

// `known`: by name, of files that need not be read again. A file that cannot be read has the digest of zeros.
std::vector<NamedDigest> DigestsOf(const std::vector<flight::InputFile>& files,
                                   const std::map<std::string, Digest>& known, int threads);

struct Recalled {
  FlightFacts facts;
  std::vector<NamedDigest> added;  // files that it did not have
};

// `apart`: names of files that may have come or changed since.
std::optional<Recalled> RecallFiles(const pyramid::MapMemory& memory, const std::vector<NamedDigest>& inputs,
                                    const std::set<std::string>& apart = {});

// Of a run that was asked for the same.
std::optional<Recalled> RecallPlaced(const pyramid::MapMemory& memory, const MosaicOptions& options,
                                     const std::vector<NamedDigest>& inputs);

// The map that somebody placed by hand, of a run that was asked for the same, while most of its photos are
// the same files: whatever else came or went, one that is aligned anew goes there.
std::optional<FlightFacts> RecallPlacedByHand(const pyramid::MapMemory& memory, const MosaicOptions& options,
                                              const std::vector<NamedDigest>& inputs);

// Whether the files that came are photos to be placed against the others. A flight that doubles is better
// aligned as a whole; so is one that was not finished, got other files than photos, or has photos that no
// record places: the new ones may be like them.
bool MayAppend(const Recalled& recalled, const flight::Flight& read, const MosaicOptions& options);

// Whether the flight got its first surveyed points, and nothing else.
bool MayMove(const Recalled& recalled, const flight::Flight& read, const MosaicOptions& options);

std::set<std::string> NamesOf(const std::vector<flight::GcpList>& lists);

// Whether all photos of a finished map are still used as pictures: of two files that show one, another may be
// read now (a copy with better tags that came later, say).
bool HasAllPhotosOf(const alignment::AlignedFlight& known, const flight::Flight& read);

// The photos of a recalled flight as they were read now (where their files are), drawn as they were and with
// the positions that placed them.
void FillPhotos(const flight::Flight& read, alignment::AlignedFlight& flight);

bool HasRemark(const std::vector<flight::Remark>& remarks, const flight::Remark& one);
// Do they say the same of fewer or more photos, say? Also within a sentence.
bool AreSameButForNumbers(const flight::Remark& a, const flight::Remark& b);

// Of a recalled flight that got photos or surveyed points: what is to be said of its files as they were read
// now, as of a flight that is placed anew with them. What was said with other numbers, or of lists of points,
// gives way to that.
void TellReading(const flight::Flight& read, alignment::AlignedFlight& flight);

}  // namespace skyquilt::pipeline

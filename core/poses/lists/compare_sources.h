// CompareSources: the lists of a flight held against its other sources before any is believed. Positions of
// rows become those of the reading that agrees best; a list that agrees in none, or whose times are another
// day's, loses its positions and angles, so that the photos' own hold; of several rows of one photo one keeps
// its place (choose_rows.h). Lists of surveyed points likewise; one that does not serve, or marks the same as
// another, is taken out of the flight. What was made of each goes to Flight::list_uses, what the user is to
// know to its warnings. To be called once on a flight as read, with one photo of each capture of several
// bands, before poses are estimated. Any thread. Errors: kUnprocessable, with the question to answer, where
// two readings of a list are as likely and nothing else places the flight.
#pragma once

#include "core/base/result.h"
#include "core/flight/flight.h"

namespace skyquilt::poses {

Result<void> CompareSources(flight::Flight& flight);

}  // namespace skyquilt::poses

// kCancelJobs: how jobs are cancelled, by whoever asks for it and with a flight that goes.
#pragma once

namespace skyquilt::storage {

// Cancels jobs at the time ?2; those of what follows, of ?1. One that waits for its units has no worker that
// would notice.
inline constexpr const char* kCancelJobs =
    "UPDATE job SET cancel=1,"
    " finished_us=CASE WHEN state='accepted' OR worker='units' THEN ?2 ELSE finished_us END,"
    " state=CASE WHEN state='accepted' OR worker='units' THEN 'dismissed' ELSE state END"
    " WHERE state IN ('accepted','running') AND ";

}  // namespace skyquilt::storage

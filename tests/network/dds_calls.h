#pragma once

#include <map>
#include <string>
#include <vector>

namespace tandem::testing {

/// Counts every call into DDS that this program's own code makes, from now on, by putting itself
/// into the table through which they go. Returns the functions of DDS that the program calls and
/// that are not in the list of those counted. If there are any, the list is to be completed.
std::vector<std::string> WatchDdsCalls();

/// Calls of this thread count as made inside while one of these exists.
class DdsCallsInside {
 public:
  DdsCallsInside();
  ~DdsCallsInside();
  DdsCallsInside(const DdsCallsInside&) = delete;
  DdsCallsInside& operator=(const DdsCallsInside&) = delete;
};

/// Number of calls so far of each function that was called.
struct DdsCalls {
  std::map<std::string, long> inside;
  std::map<std::string, long> outside;
};
DdsCalls CountedDdsCalls();

}  // namespace tandem::testing

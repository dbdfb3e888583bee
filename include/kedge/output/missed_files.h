// What of a run's files the disk had no room for.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace kedge
{
/// Files of one kind, written moment by moment. A run says once that the disk does not take them, and when it takes
/// them again, or at the end, how many moments are missing.
class MissedFiles
{
public:
  explicit MissedFiles(std::string kind_) : kind(std::move(kind_)) {}

  /// Does work that writes one file, which may not fit. Collective.
  void attempt(const std::function<void()>& work);
  /// After the files of a moment. Adds to the warnings.
  void end_moment(unsigned int step, std::vector<std::string>& warnings);
  /// Says what is missing so far. Adds to the warnings.
  void sum_up(std::vector<std::string>& warnings);

private:
  std::string kind, problem; ///< problem: of the first file of this moment that does not fit
  unsigned int n_missing = 0, first = 0, last = 0;
};
} // namespace kedge

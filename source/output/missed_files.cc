#include <fmt/format.h>
#include <kedge/base/failure.h>
#include <kedge/output/missed_files.h>

namespace kedge
{
void MissedFiles::attempt(const std::function<void()>& work)
{
  const std::string here = try_to_write("output", work);
  if (problem.empty())
    problem = here;
}

void MissedFiles::end_moment(const unsigned int step, std::vector<std::string>& warnings)
{
  if (problem.empty())
    return sum_up(warnings);
  if (n_missing == 0)
  {
    first = step;
    warnings.push_back(fmt::format("{}; the run goes on without {} until there is room: free some", problem, kind));
  }
  ++n_missing;
  last = step;
  problem.clear();
}

void MissedFiles::sum_up(std::vector<std::string>& warnings)
{
  if (n_missing == 1)
    warnings.push_back(fmt::format("{} are missing at step {}, for the disk had no room", kind, first));
  else if (n_missing > 1)
    warnings.push_back(fmt::format("{} are missing at {} moments from step {} to step {}, for the disk had no room",
                                   kind, n_missing, first, last));
  n_missing = 0;
}
} // namespace kedge

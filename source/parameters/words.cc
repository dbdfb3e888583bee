#include <algorithm>
#include <cctype>
#include <kedge/parameters/words.h>

namespace kedge::schema
{
namespace
{
std::string plain(std::string word)
{
  for (char& c : word)
    c = (c == '_' || c == '-') ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word;
}
} // namespace

std::size_t edit_distance(const std::string& first, const std::string& second)
{
  const std::string a = plain(first), b = plain(second);
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j)
    {
      if (i == 0 || j == 0)
      {
        cost[i][j] = i + j;
        continue;
      }
      cost[i][j] =
          std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
    }
  return cost[a.size()][b.size()];
}

std::string nearest(const std::string& word, const std::vector<std::string>& candidates)
{
  std::string best;
  std::size_t least = word.size() + 1;
  for (const std::string& candidate : candidates)
  {
    const std::size_t distance = edit_distance(word, candidate);
    // With one error in three letters the word is still recognisable; with more it would be a guess.
    if (distance < least && 3 * distance <= std::max(word.size(), candidate.size()))
    {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

std::string quoted(const std::string& word) { return '"' + word + '"'; }

std::string alternatives(const std::vector<std::string>& words)
{
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " or ") + quoted(words[i]);
  return text;
}
} // namespace kedge::schema

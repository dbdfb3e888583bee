// Words in messages: the likeliest spelling, and lists of alternatives.
#pragma once

#include <string>
#include <vector>

namespace kedge::schema
{
/// Smallest number of insertions, deletions, replacements and swaps of neighbours that turn one word into the other
/// (optimal string alignment). Case does not count, nor the difference between space, "_" and "-".
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The candidate that `word` most likely stands for, or an empty string if none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

/// "x"
std::string quoted(const std::string& word);

/// "a", "b" or "c"
std::string alternatives(const std::vector<std::string>& words);
} // namespace kedge::schema

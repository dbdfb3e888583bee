#include <kedge/base/exceptions.h>
#include <kedge/parameters/place.h>

namespace kedge::schema
{
Place Place::key(const std::string& name) const
{
  Place place(*input);
  place.text = text.empty() ? name : text + "." + name;
  return place;
}

Place Place::entry(std::size_t position) const
{
  Place place(*this); // keeps the meaning: an entry means what its list means
  place.text += "[" + std::to_string(position) + "]";
  return place;
}

Place Place::meaning(const std::string& what) const
{
  Place place(*this);
  place.sentence = what;
  return place;
}

void Place::fail(const std::string& problem, const std::string& remedy) const
{
  throw InputError(text.empty() ? "top level" : text, problem, remedy);
}

void Place::expected(const std::string& what, const std::string& found, const std::string& remedy) const
{
  fail("expected " + what + ", found " + found, !remedy.empty()    ? remedy
                                                : sentence.empty() ? "correct the value"
                                                                   : "correct the value (" + sentence + ")");
}
} // namespace kedge::schema

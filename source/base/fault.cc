#include <csignal>
#include <kedge/base/exceptions.h>
#include <kedge/base/fault.h>
#include <map>
#include <new>
#include <sstream>

namespace kedge
{
namespace
{
using Kind = PlannedFault::Kind;

const std::map<std::string, Kind> kinds = {{"input", Kind::input}, {"solver", Kind::solver},
                                           {"file", Kind::file},   {"bad_alloc", Kind::bad_alloc},
                                           {"logic", Kind::logic}, {"kill", Kind::kill}};

std::map<std::string, std::string> assignments_in(const std::string& text)
{
  std::map<std::string, std::string> values;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');)
    values[part.substr(0, part.find('='))] = part.substr(std::min(part.size(), part.find('=') + 1));
  return values;
}
} // namespace

void PlannedFault::strike_at(const char* place) const
{
  if (step_now != step || phase != place)
    return;
  const std::string message = "a planned fault in \"" + phase + "\"";
  switch (kind)
  {
    case Kind::input:
      throw InputError("KEDGE_FAULT", message);
    case Kind::solver:
      throw SolverError(message);
    case Kind::file:
      throw FileError("KEDGE_FAULT", message);
    case Kind::bad_alloc:
      throw std::bad_alloc();
    case Kind::logic:
      throw std::logic_error(message);
    case Kind::kill:
      std::raise(SIGKILL);
  }
}

std::optional<PlannedFault> planned_fault(const char* text, const int rank)
{
  if (text == nullptr)
    return {};
  const std::map<std::string, std::string> values = assignments_in(text);
  PlannedFault fault;
  try
  {
    if (values.count("rank") && std::stoi(values.at("rank")) != rank)
      return {};
    fault.step = std::stoul(values.at("step"));
    fault.phase = values.at("phase");
    fault.kind = kinds.at(values.at("kind"));
  }
  catch (const std::logic_error&) // what at, stoi and stoul throw
  {
    throw InputError("KEDGE_FAULT", std::string("\"") + text + "\" is no plan",
                     "write \"rank=1,step=2,phase=basis,kind=solver\", or unset it");
  }
  return fault;
}
} // namespace kedge

// Coombs' test (2023, doi 10.1002/nme.7332): a block moves rigidly through the mesh; condition numbers by offset.
#include "matrices.h"
#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <fstream>
#include <kedge/base/environment.h>
#include <kedge/base/exceptions.h>
#include <string>

using namespace kedge;
using translation::Kind;

namespace
{
/// Which matrix of which block, and how much stabilisation.
struct Curve
{
  unsigned int dim;
  bool octree, gimp;
  Kind kind;
  double factor;
};

template <int dim> std::vector<double> conditions_in(const Curve& curve, const std::vector<double>& offsets)
{
  const auto mesh = translation::make_mesh<dim>(curve.octree);
  const unsigned int n_rigid = curve.kind == Kind::stiffness ? dim * (dim + 1) / 2 : 0;
  std::vector<double> result;
  for (const double offset : offsets)
  {
    const translation::Matrices matrices =
        translation::make_matrices(*mesh, curve.octree, curve.gimp, curve.kind, offset);
    result.push_back(translation::condition_number(matrices.base + curve.factor * matrices.ghost, n_rigid));
  }
  return result;
}

std::vector<double> conditions(const Curve& curve, const std::vector<double>& offsets)
{
  return curve.dim == 2 ? conditions_in<2>(curve, offsets) : conditions_in<3>(curve, offsets);
}

/// From one whole cell to the next, finely at both ends, where the cuts are smallest.
std::vector<double> chart_offsets(const unsigned int n)
{
  std::vector<double> offsets;
  for (unsigned int i = 0; i <= n; ++i)
    offsets.push_back(double(i) / n);
  for (double offset = 1e-6; offset < 0.9 / n; offset *= std::sqrt(10.))
    offsets.insert(offsets.end(), {offset, 1. - offset});
  std::sort(offsets.begin(), offsets.end());
  return offsets;
}

void write(const Curve& curve, const std::string& name)
{
  std::ofstream file(name);
  file << "offset,condition\n";
  const std::vector<double> offsets = chart_offsets(curve.dim == 2 ? 200 : 100), values = conditions(curve, offsets);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    file << fmt::format("{:.7g},{:.4g}\n", offsets[i], values[i]);
  file.close();
  if (!file)
    throw FileError(name, "cannot be written");
}

/// Whether a word is the second of two; refuses any other.
bool is_second(const std::string& what, const std::string& word, const std::array<std::string, 2>& known)
{
  if (word != known[0] && word != known[1])
    throw InputError(what, fmt::format("is {}", word), fmt::format("use {}", fmt::join(known, " or ")));
  return word == known[1];
}

double factor_of(const std::string& word)
{
  std::size_t end = 0;
  double value = -1.;
  try
  {
    value = std::stod(word, &end);
  }
  catch (const std::logic_error&)
  {
  }
  if (end != word.size() || !std::isfinite(value) || value < 0.)
    throw InputError("FACTOR", fmt::format("is {}", word), "use a number that is not negative");
  return value;
}

/// Of the words behind the file's name.
Curve curve_of(char** words)
{
  Curve curve;
  curve.dim = is_second("DIMENSION", words[0], {"2", "3"}) ? 3 : 2;
  curve.octree = is_second("MESH", words[1], {"uniform", "octree"});
  curve.gimp = !is_second("BASIS", words[2], {"gimp", "mpm"});
  curve.kind = is_second("MATRIX", words[3], {"stiffness", "mass"}) ? Kind::mass : Kind::stiffness;
  curve.factor = factor_of(words[4]);
  return curve;
}

/// Whether a published factor keeps the condition number below the bound, which it exceeds a hundredfold without
/// stabilisation.
bool check(Curve curve, const std::vector<double>& offsets, const double bound)
{
  const auto largest = [&](const double factor)
  {
    curve.factor = factor;
    const std::vector<double> values = conditions(curve, offsets);
    return *std::max_element(values.begin(), values.end());
  };
  const double with = largest(curve.factor), without = largest(0.);
  const bool good = with < bound && without > 100. * bound;
  fmt::print("{}-D {} {}: {:.3g} with, {:.3g} without stabilisation; bound {}{}\n", curve.dim,
             curve.octree ? "octree" : "uniform", curve.kind == Kind::mass ? "mass" : "stiffness", with, without, bound,
             good ? "" : "  <- failed");
  return good;
}

bool check_all()
{
  struct Bounds
  {
    unsigned int dim;
    bool octree;
    double stiffness, mass; // about twice the largest of the whole chart
  };
  constexpr double published_stiffness = 1. / 30., published_mass = 0.25;
  const std::vector<double> many{1e-5, 3e-4, 0.005, 0.2, 0.505, 0.7, 0.99999}, few{3e-4, 0.2, 0.99999};
  bool passed = true;
  for (const Bounds& bounds : {Bounds{2, false, 2e3, 4e2}, Bounds{2, true, 2.4e4, 9e2}, Bounds{3, false, 8e3, 2.5e3},
                               Bounds{3, true, 1.6e5, 5e3}})
  {
    const auto& offsets = bounds.dim == 3 && bounds.octree ? few : many;
    passed =
        check({bounds.dim, bounds.octree, true, Kind::stiffness, published_stiffness}, offsets, bounds.stiffness) &&
        passed;
    passed = check({bounds.dim, bounds.octree, true, Kind::mass, published_mass}, offsets, bounds.mass) && passed;
  }
  return passed;
}
} // namespace

int main(int argc, char** argv)
{
  Environment environment(argc, argv);
  try
  {
    if (argc == 2 && std::string(argv[1]) == "--check")
      return check_all() ? 0 : 1;
    if (argc == 7)
    {
      write(curve_of(argv + 2), argv[1]);
      return 0;
    }
    fmt::print("Usage: benchmark-ghost-translation FILE.csv DIMENSION MESH BASIS MATRIX FACTOR | --check\n");
  }
  catch (const std::exception& error)
  {
    fmt::print(stderr, "benchmark-ghost-translation: {}\n", error.what());
  }
  return 2;
}

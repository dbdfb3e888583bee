// Coombs' test (2023, doi 10.1002/nme.7332): a block moves rigidly through the mesh; condition numbers by offset.
#include "matrices.h"
#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <fstream>
#include <kedge/base/environment.h>
#include <string>

using namespace kedge;

namespace
{
constexpr std::array<double, 7> factors{0., 1e-3, 1e-2, 1. / 30., 0.25, 1., 10.};
constexpr unsigned int published_stiffness = 3, published_mass = 4; ///< places in `factors` of Coombs' choice

/// Condition numbers at one offset.
struct Conditions
{
  double offset;
  std::array<double, factors.size()> stiffness, mass;
};

template <int dim>
std::vector<Conditions> translate(const bool octree, const bool gimp, const std::vector<double>& offsets)
{
  const auto mesh = translation::make_mesh<dim>(octree);
  std::vector<Conditions> result;
  for (const double offset : offsets)
  {
    const translation::Matrices matrices = translation::make_matrices(*mesh, octree, gimp, offset);
    Conditions& conditions = result.emplace_back();
    conditions.offset = offset;
    for (std::size_t i = 0; i < factors.size(); ++i)
    {
      conditions.stiffness[i] = translation::condition_number(
          matrices.stiffness + factors[i] * matrices.ghost_stiffness, dim * (dim + 1) / 2);
      conditions.mass[i] = translation::condition_number(matrices.mass + factors[i] * matrices.ghost_mass, 0);
    }
  }
  return result;
}

/// The largest over all offsets, by factor.
template <typename Matrix> auto largest(const std::vector<Conditions>& all, const Matrix& matrix)
{
  std::array<double, factors.size()> result{};
  for (const Conditions& conditions : all)
    for (std::size_t i = 0; i < factors.size(); ++i)
      result[i] = std::max(result[i], (conditions.*matrix)[i]);
  return result;
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

template <int dim> void write_rows(const bool octree, const bool gimp, const unsigned int n, std::ofstream& file)
{
  const std::vector<Conditions> all = translate<dim>(octree, gimp, chart_offsets(n));
  for (const auto& [name, matrix] :
       {std::pair{"stiffness", &Conditions::stiffness}, std::pair{"mass", &Conditions::mass}})
  {
    const std::string scene =
        fmt::format("{},{},{},{}", dim, octree ? "octree" : "uniform", gimp ? "gimp" : "mpm", name);
    for (const Conditions& conditions : all)
    {
      file << fmt::format("{},{:.7g}", scene, conditions.offset);
      for (const double condition : conditions.*matrix)
        file << fmt::format(",{:.4g}", condition);
      file << '\n';
    }
    std::string line;
    for (const double condition : largest(all, matrix))
      line += fmt::format(" {:9.3g}", condition);
    fmt::print("{:28}{}\n", scene, line);
  }
}

void write(const std::string& name)
{
  std::ofstream file(name);
  file << "dimension,mesh,basis,matrix,offset";
  std::string line;
  for (const double factor : factors)
  {
    file << fmt::format(",{:.4g}", factor);
    line += fmt::format(" {:9.4g}", factor);
  }
  file << '\n';
  fmt::print("{:28}{}\n", "largest condition number", line);
  for (const bool gimp : {true, false})
  {
    write_rows<2>(false, gimp, 200, file);
    write_rows<2>(true, gimp, 200, file);
    write_rows<3>(false, gimp, 100, file);
    write_rows<3>(true, gimp, 100, file);
  }
}

/// Whether the published factors keep the condition numbers below the bounds, which those without stabilisation exceed
/// a hundredfold.
template <int dim>
bool check(const bool octree, const std::vector<double>& offsets, const double stiffness_bound, const double mass_bound)
{
  const std::vector<Conditions> all = translate<dim>(octree, true, offsets);
  bool passed = true;
  for (const auto& [name, matrix, published, bound] :
       {std::tuple{"stiffness", &Conditions::stiffness, published_stiffness, stiffness_bound},
        std::tuple{"mass", &Conditions::mass, published_mass, mass_bound}})
  {
    const auto conditions = largest(all, matrix);
    const bool good = conditions[published] < bound && conditions[0] > 100. * bound;
    fmt::print("{}-D {} {}: {:.3g} with, {:.3g} without stabilisation; bound {}{}\n", dim,
               octree ? "octree" : "uniform", name, conditions[published], conditions[0], bound,
               good ? "" : "  <- failed");
    passed = passed && good;
  }
  return passed;
}

bool check_all()
{
  // bounds: about twice the largest of the whole chart
  const std::vector<double> many{1e-5, 3e-4, 0.005, 0.2, 0.505, 0.7, 0.99999}, few{3e-4, 0.2, 0.99999};
  bool passed = true;
  passed = check<2>(false, many, 2e3, 4e2) && passed;
  passed = check<2>(true, many, 2.4e4, 9e2) && passed;
  passed = check<3>(false, many, 8e3, 2.5e3) && passed;
  passed = check<3>(true, few, 1.6e5, 5e3) && passed;
  return passed;
}
} // namespace

int main(int argc, char** argv)
{
  Environment environment(argc, argv);
  if (argc != 2)
  {
    fmt::print("Usage: benchmark-ghost-translation FILE.csv | --check\n");
    return 2;
  }
  if (std::string(argv[1]) == "--check")
    return check_all() ? 0 : 1;
  write(argv[1]);
  return 0;
}

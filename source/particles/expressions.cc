#include <cmath>
#include <fmt/format.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/particles/expressions.h>

namespace kedge
{
namespace
{
/// Where an expression has no finite value.
struct Undefined
{
  unsigned int component;
  double value, initial[3], present[3], time;
};

template <int dim> std::string text_of(const double* x)
{
  return dim == 2 ? fmt::format("[{:.6g}, {:.6g}]", x[0], x[1])
                  : fmt::format("[{:.6g}, {:.6g}, {:.6g}]", x[0], x[1], x[2]);
}

/// Remembers the first value of this rank that is not finite.
template <int dim> class FiniteValues
{
public:
  void look_at(const double* values, const double* initial, const double* present, const double time)
  {
    for (unsigned int d = 0; d < dim && found.empty(); ++d)
      if (!std::isfinite(values[d]))
      {
        Undefined place{d, values[d], {}, {}, time};
        std::copy_n(initial, dim, place.initial);
        std::copy_n(present, dim, place.present);
        found.push_back(place);
      }
  }

  /// Throws on all ranks if any has found one. Collective.
  void require(const std::string& path, const MPI_Comm communicator) const
  {
    const std::vector<Undefined> all = gather_everywhere(found, communicator);
    if (all.empty())
      return;
    const Undefined& first = all.front();
    throw InputError(fmt::format("{}.expression[{}]", path, first.component),
                     fmt::format("is {} at the material point that began at {} and is at {}, t = {:.6g}", first.value,
                                 text_of<dim>(first.initial), text_of<dim>(first.present), first.time),
                     "make it finite at every material point, for example by a condition such as \"R > 0 ? 1/R : 0\"");
  }

private:
  std::vector<Undefined> found; ///< at most one
};
} // namespace

std::vector<std::string> initial_variables(const unsigned int dim)
{
  return dim == 2 ? std::vector<std::string>{"X", "Z"} : std::vector<std::string>{"X", "Y", "Z"};
}

std::vector<std::string> present_variables(const unsigned int dim)
{
  std::vector<std::string> names = initial_variables(dim);
  for (const char* name : {"x", "y", "z"})
    if (dim == 3 || *name != 'y')
      names.push_back(name);
  names.push_back("t");
  return names;
}

template <int dim>
BodyForce<dim>::BodyForce(const ExpressionText& text) : path(text.path), expression(text, present_variables(dim))
{
}

template <int dim>
View<double* [3]> BodyForce<dim>::evaluate(const ParticleSet<dim>& particles, const double time,
                                           const MPI_Comm communicator) const {
  const auto& present = particles.positions();
  const auto initial = particles.initial_positions();
  const View<double* [3]> result("body force", present.size());
  const auto values = make_mirror(result);
  Kokkos::deep_copy(values, 0.); // in 2-D the third stays so
  FiniteValues<dim> finite;
  std::array<double, 2 * dim + 1> variables;
  variables[2 * dim] = time;
  for (std::size_t p = 0; p < present.size(); ++p)
  {
    std::copy_n(initial[p].begin(), dim, variables.begin());
    std::copy_n(present[p].begin(), dim, variables.begin() + dim);
    std::array<double, dim> value;
    expression.evaluate(variables.data(), value.data());
    finite.look_at(value.data(), initial[p].data(), present[p].data(), time);
    for (unsigned int d = 0; d < dim; ++d)
      values(p, d) = value[d];
  }
  finite.require(path, communicator);
  Kokkos::deep_copy(result, values);
  return result;
}

template <int dim>
void set_initial_velocity(ParticleSet<dim>& particles, const ExpressionText& text, const MPI_Comm communicator)
{
  const Expression expression(text, initial_variables(dim));
  FiniteValues<dim> finite;
  for (auto& particle : particles.edit())
  {
    const auto properties = particle.get_properties();
    std::array<double, dim> value;
    expression.evaluate(&properties[field::initial_position], value.data());
    finite.look_at(value.data(), &properties[field::initial_position], &properties[field::initial_position], 0.);
    for (unsigned int d = 0; d < dim; ++d)
      properties[field::velocity + d] = value[d];
  }
  finite.require(text.path, communicator);
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template class BodyForce<dim>;                                                                                       \
  template void set_initial_velocity<dim>(ParticleSet<dim>&, const ExpressionText&, MPI_Comm);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge

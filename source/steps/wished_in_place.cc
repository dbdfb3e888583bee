#include <algorithm>
#include <kedge/steps/wished_in_place.h>

namespace kedge
{
template <int dim> void replace_soil(const StepContext<dim>& context, const StepBasis& basis)
{
  Contact<dim>& contact = context.soil.contact();
  contact.take_reference_gaps(context.bodies);
  if (context.stage.stepping.load == GravityLoad::ramp)
    return;
  const ParticleArrays& particles = context.soil.particles().arrays();
  const NodalExchange exchange(dim, numbering_of(basis.nodes));
  const NodalVector force = exchange.make_nodal_vector(), weight = exchange.make_nodal_vector(),
                    rest = exchange.make_nodal_vector();
  update_stress_and_force<dim>(particles, basis.stencils, context.soil.materials(), rest, force, basis.cells);
  add_weight<dim>(particles, basis.stencils, context.gravity, -1., force);
  exchange.sum_over_ranks(force);

  const auto host = copy_to_host(force);
  std::vector<double> missing(host.data(), host.data() + host.extent(0));
  const std::vector<unsigned char> held = find_constrained_dofs(context, basis.nodes);
  for (std::size_t i = 0; i < missing.size(); ++i)
    if (held[i])
      missing[i] = 0.;
  contact.replace_support(context.bodies, missing,
                          [&](std::vector<double>& values)
                          {
                            const NodalVector sum = exchange.make_nodal_vector();
                            const auto copy = copy_to_host(sum);
                            std::copy(values.begin(), values.end(), copy.data());
                            Kokkos::deep_copy(sum, copy);
                            exchange.sum_over_ranks(sum);
                            Kokkos::deep_copy(copy, sum);
                            std::copy_n(copy.data(), values.size(), values.begin());
                          });
}

template void replace_soil<2>(const StepContext<2>&, const StepBasis&);
template void replace_soil<3>(const StepContext<3>&, const StepBasis&);
} // namespace kedge
